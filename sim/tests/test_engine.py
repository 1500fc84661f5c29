"""The bare Verilated core against the golden model, and its timing."""

import re

import numpy as np
import pytest

from triaxis.golden.judge import judge_pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine, configuration_for
from triaxis.sim.paths import ROOT
from triaxis.verif.core.stimulus.families import all_orders, mixed_pairs, random_margins


@pytest.mark.parametrize(("width", "largest"), [(8, 255), (16, 0), (24, 1 << 23), (32, (1 << 32) - 1)])
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
    assert near.any()
    assert not near.all()


def readme_latencies():
    """Return (W, latency at M = 0, at M = 8, at M = W) from the README's table."""
    section = (ROOT / "README.md").read_text().split("### Latency")[1]
    rows = re.findall(r"^\| *(\d+) *\| *(\d+) *\| *(\d+) *\| *(\d+) *\|", section, re.MULTILINE)
    return [tuple(map(int, row)) for row in rows]


@pytest.mark.parametrize(("width", "column"), [(8, 3), (16, 1), (16, 3), (24, 3), (32, 3)])
def test_latency_is_what_the_readme_says_at_one_pair_per_clock(rng, width, column):
    row = next(r for r in readme_latencies() if r[0] == width)
    margin_bits = {1: 0, 2: 8, 3: width}[column]
    engine = RtlEngine(Configuration(width, margin_bits, gating=False))
    for count in (1, 500):
        pairs = mixed_pairs(rng, count, width)
        cycles = engine.words(pairs, np.zeros(count, np.int64))[1]
        # The harness counts the clock in which it accepts the first pair and that of the last result.
        assert cycles == row[column] + count
