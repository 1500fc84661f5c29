"""Broken cores are caught on the pins: for each further fault of the catalogue, the test that is to find it
must fail, say why, keep the failing pairs, and fail again when they are replayed.
"""

import re

import numpy as np
import pytest

from triaxis.verif.faults.faulty_rtl import faulty_rtl
from triaxis.verif.faults.known_faults import FAULTS, fault_of
from triaxis.verif.testbench.settings import BURST, PIN
from triaxis.verif.testbench.simulation import run, run_settings

pytestmark = pytest.mark.simulator


# By fault: the test that must see it, the agent, what it must say, whether of a pair, and whether a replay
# of that pair fails again.
EXPECTED = {
    "touching-is-clear": ("TouchingTest", PIN, "exact answer", True, True),
    "narrow-cross": ("ExtremesTest", BURST, "exact answer", True, True),
    "wrong-edge": ("RandomTest", PIN, "exact answer", True, True),
    "last-axis": ("RandomTest", PIN, "exact answer", True, True),
    "late-margin": ("RandomTest", PIN, "exact answer", True, False),
    "moving-operands": ("FarTest", BURST, "an operand moved", False, False),
    "overfull-queue": ("StallsTest", PIN, "in flight", False, False),
    "withdrawn-result": ("StallsTest", PIN, "a result changed while it waited", False, False),
    "moving-margins": ("FarTest", PIN, "a margin moved", False, False),
    "short-queue": ("RandomTest", PIN, "not ready although", False, False),
    "early-result": ("RandomTest", PIN, "a result is due and not there", False, False),
    "hang": ("StallsTest", BURST, "not ready although", False, False),
    "lost-results": ("ResetsTest", BURST, "a result is due and not there", True, False),
}


def test_no_further_fault_is_left_out():
    # Those of the mesh engine and the board have tests of their own, in test_fault_catalogue.py.
    core = [fault for fault in FAULTS if not fault.config.startswith(("mesh_", "board_"))]
    further = [fault.name for fault in core if not fault.replaced]
    assert sorted(further) == sorted(EXPECTED)


@pytest.mark.long
@pytest.mark.parametrize("name", EXPECTED)
def test_fault_is_caught(tmp_path, seed, name):
    test, agent, message, about_pairs, replays = EXPECTED[name]
    fault = fault_of(name)
    broken = faulty_rtl(fault)
    result = run(run_settings(test, fault.config, seed, 1500, folder=tmp_path / "run", agent=agent), broken)
    assert not result.passed
    explanation = result.explain()
    assert message in explanation, explanation
    replay = re.search(rf"replay: \.venv/bin/triaxis sim {test} --seed {seed} --config", explanation)
    assert replay, explanation

    if about_pairs:
        assert result.failing_pairs
        with np.load(result.failing_pairs) as file:
            assert file["pairs"].shape[1:] == (2, 3, 3)
            assert len(file["margins"]) == len(file["pairs"]) > 0
    if replays:
        pairs, again = str(result.failing_pairs), tmp_path / "again"
        settings = run_settings("ReplayTest", fault.config, seed, 1, pairs, folder=again, agent=agent)
        assert not run(settings, broken).passed
        assert run(settings).passed
