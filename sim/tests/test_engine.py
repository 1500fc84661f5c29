"""The bare Verilated core against the golden model, and its timing."""

import re

import numpy as np
import pytest

from triaxis.golden.axes import first_separating
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import NO_AXIS
from triaxis.sim.build import run_tool
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import LockstepEngine, RtlEngine, configuration_for
from triaxis.sim.detector import WIDTH, detect
from triaxis.sim.lanes import LanesError, write_lanes
from triaxis.sim.models import lockstep_build
from triaxis.sim.paths import DUT
from triaxis.sim.verilate import FAST, QUICK, verilate_command
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.stimulus.margins import random_margins
from triaxis.verif.core.stimulus.seed_vectors import seed_normals, seed_vectors
from triaxis.verif.core.stimulus.symmetry import all_orders

pytestmark = pytest.mark.simulator


# Wide cores take most of a minute to build.
_WIDE = [
    pytest.param(width, largest, marks=pytest.mark.regress)
    for width, largest in ((24, 1 << 23), (32, (1 << 32) - 1))
]
_WIDEST = [pytest.param(width, width, marks=pytest.mark.regress) for width in (16, 24, 32)]


@pytest.mark.parametrize(("width", "largest"), [(8, 255), (16, 0), *_WIDE])
def test_core_and_golden_model_agree(rng, width, largest):
    engine = RtlEngine(configuration_for(width, largest))
    pairs = mixed_pairs(rng, 2500, width)
    margins = random_margins(rng, pairs, largest)
    assert (engine.verdicts(pairs, margins) == judge_pairs(pairs, margins)).all()


def test_all_72_orders_agree(rng):
    engine = RtlEngine(configuration_for(16, 0))
    pairs = mixed_pairs(rng, 3000, 16)
    near = engine.verdicts(all_orders(pairs), np.zeros(72 * 3000, np.int64))["near"].reshape(3000, 72)
    assert (near == near[:, :1]).all()
    assert near.any() and not near.all()


@pytest.mark.parametrize(("width", "margin_bits"), [(8, 8), (16, 0), *_WIDEST])
def test_latency_is_the_documented_one_at_one_pair_per_clock(rng, width, margin_bits):
    configuration = Configuration(width, margin_bits, gating=False)
    engine = RtlEngine(configuration)
    for count in (1, 500):
        pairs = mixed_pairs(rng, count, width)
        cycles = engine.words(pairs, np.zeros(count, np.int64))[1]
        # The harness counts the clock in which it accepts the first pair and that of the last result.
        assert cycles == configuration.latency + count


def test_all_fifteen_seed_vectors_are_clear():
    assert not detect(seed_vectors(WIDTH), seed_normals()).any()


def test_the_detector_is_exact_and_blind_to_the_normals_handed_in(rng):
    """The combinational wrapper: the seed design's users drop it in."""
    pairs = mixed_pairs(rng, 3000, WIDTH)
    expected = first_separating(pairs, np.zeros(3000, np.int64)) == NO_AXIS
    for normals in (np.zeros((3000, 2, 3), np.int64), rng.integers(-32768, 32768, (3000, 2, 3))):
        assert (detect(pairs, normals) == expected).all()
    assert expected.any() and not expected.all()
    text = (DUT / "core" / "CollisionDetector.sv").read_text()
    inputs = re.findall(r"input logic signed \[W-1:0\] (\w+)", text)
    vertices = [f"{t}{i}_{k}" for t in "AB" for i in (1, 2, 3) for k in "xyz"]
    assert inputs == vertices + [f"N{t}_{k}" for t in "AB" for k in "xyz"]


_LOCKSTEP = [
    pytest.param(*core, FAST, marks=pytest.mark.regress)
    for core in ((8, 1, True), (16, 0, False), (18, 18, True), (20, 0, True))
]


@pytest.mark.parametrize(("width", "margin_bits", "gating", "speed"), [(8, 0, True, QUICK), *_LOCKSTEP])
def test_cores_in_lockstep_answer_rightly(rng, width, margin_bits, gating, speed):
    configuration = Configuration(width, margin_bits, gating=gating)
    engine = LockstepEngine(configuration, speed)
    # More than a tag tells apart in a part, none for the last cores, one for one of them.
    for count in (1, 40, 70_000):
        pairs = mixed_pairs(rng, count, width)
        margins = random_margins(rng, pairs, (1 << margin_bits) - 1)
        words, clocks = engine.words(pairs, margins)
        assert (words == expected_words(bulk_facts(pairs, margins), configuration)).all()
        assert clocks >= count // 16


def test_what_lanes_do_not_understand_is_refused(tmp_path):
    with pytest.raises(InputError, match="at most 20"):
        LockstepEngine(Configuration(24, 0))
    build = lockstep_build(Configuration(8, 1))
    run_tool(verilate_command(build, tmp_path), tmp_path, build.kind)
    source = tmp_path / "Vtop___024root__0.cpp"
    text = source.read_text()
    for found, instead, said in (
        ("triaxis_core__DOT__accept = ", "triaxis_core__DOT__unheard_of = ", "an unknown signal"),
        ("triaxis_core__DOT__accept = ", "triaxis_core__DOT__accept += ", "no assignment"),
        ("ico_sequent__TOP__0(Vtop", "renamed(Vtop", "no function"),
    ):
        source.write_text(text.replace(found, instead))
        with pytest.raises(LanesError, match=said):
            write_lanes(tmp_path, 16)
