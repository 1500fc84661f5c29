"""Broken cores are caught on the pins: for each further fault of the catalogue, the test that is to find it
must fail, say why, keep the failing pairs, and fail again when they are replayed.
"""

import re
from dataclasses import dataclass

import numpy as np
import pytest

from triaxis.sim.configuration import parse_configuration
from triaxis.verif.faults.broken_rtl import faulty_rtl
from triaxis.verif.faults.known_faults import FAULTS, fault_of
from triaxis.verif.testbench.simulation import run, run_settings

pytestmark = pytest.mark.simulator


@dataclass(frozen=True)
class Expected:
    """The test that must see a fault, and by which message."""

    fault: str
    test: str
    message: str
    about_pairs: bool = True
    replays: bool = True


EXPECTED = (
    Expected("touching-is-clear", "TouchingTest", "exact answer"),
    Expected("narrow-cross", "ExtremesTest", "exact answer"),
    Expected("wrong-edge", "RandomTest", "exact answer"),
    Expected("last-axis", "RandomTest", "exact answer"),
    Expected("late-margin", "RandomTest", "exact answer", replays=False),
    Expected("moving-operands", "FarTest", "an operand moved", about_pairs=False, replays=False),
    Expected("overfull-queue", "StallsTest", "in flight", about_pairs=False, replays=False),
    Expected(
        "withdrawn-result", "StallsTest", "a result changed while it waited", about_pairs=False, replays=False
    ),
    Expected("moving-margins", "FarTest", "a margin moved", about_pairs=False, replays=False),
    Expected("short-queue", "RandomTest", "not ready although", about_pairs=False, replays=False),
    Expected(
        "early-result", "RandomTest", "a result is due and not there", about_pairs=False, replays=False
    ),
    Expected("hang", "StallsTest", "the core hangs", about_pairs=False, replays=False),
    Expected("lost-results", "ResetsTest", "was due", replays=False),
)  # fmt: skip


def test_no_further_fault_is_left_out():
    # Those of the mesh engine have tests of their own, in test_fault_catalogue.py.
    core = [fault for fault in FAULTS if not fault.config.startswith("mesh_")]
    further = [fault.name for fault in core if not fault.replaced]
    assert sorted(further) == sorted(expected.fault for expected in EXPECTED)


# Each needs a build of its own: one of each way to be caught for every day.
_DAILY = ("narrow-cross", "hang", "withdrawn-result")


@pytest.mark.parametrize(
    "expected",
    [
        pytest.param(one, id=one.fault, marks=() if one.fault in _DAILY else pytest.mark.regress)
        for one in EXPECTED
    ],
)
def test_fault_is_caught(tmp_path, seed, expected):
    fault = fault_of(expected.fault)
    broken = faulty_rtl(fault)
    configuration = parse_configuration(fault.config)

    settings = run_settings(expected.test, configuration, seed, 1500, folder=tmp_path / "run")
    result = run(settings, dut=broken)
    assert not result.passed
    explanation = result.explain()
    assert expected.message in explanation, explanation
    replay = re.search(rf"replay: \.venv/bin/triaxis sim {expected.test} --seed {seed} --config", explanation)
    assert replay, explanation

    if expected.about_pairs:
        assert result.failing_pairs
        with np.load(result.failing_pairs) as file:
            assert file["pairs"].shape[1:] == (2, 3, 3)
            assert len(file["margins"]) == len(file["pairs"]) > 0
    if expected.replays:
        again = run_settings(
            "ReplayTest", configuration, seed, 1, str(result.failing_pairs), folder=tmp_path / "again"
        )
        assert not run(again, dut=broken).passed
        assert run(again).passed
