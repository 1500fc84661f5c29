"""The bare Verilated core against the golden model, and its timing."""

import numpy as np
import pytest

from triaxis.golden.judge import judge_pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.core_engine import RtlEngine, configuration_for
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.stimulus.margins import random_margins
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
    assert near.any()
    assert not near.all()


@pytest.mark.parametrize(("width", "margin_bits"), [(8, 8), (16, 0), *_WIDEST])
def test_latency_is_the_documented_one_at_one_pair_per_clock(rng, width, margin_bits):
    configuration = Configuration(width, margin_bits, gating=False)
    engine = RtlEngine(configuration)
    for count in (1, 500):
        pairs = mixed_pairs(rng, count, width)
        cycles = engine.words(pairs, np.zeros(count, np.int64))[1]
        # The harness counts the clock in which it accepts the first pair and that of the last result.
        assert cycles == configuration.latency + count
