import numpy as np
import pytest

from triaxis.golden.pairs import NO_AXIS, VERDICT, coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.sim.packing import data_bytes, data_words, pack_data, pack_user, unpack_data, unpack_user
from triaxis.sim.result import decode, encode


@pytest.mark.parametrize("width", [8, 13, 16, 24, 31, 32])
def test_pairs_survive(rng, width):
    low, high = coordinate_range(width)
    pairs = rng.integers(low, high + 1, (50, 2, 3, 3))
    pairs[0], pairs[1] = low, high
    words = pack_data(pairs, width)
    assert max(words) < 1 << (8 * data_bytes(width))
    assert (unpack_data(words, width) == pairs).all()
    # A1 x lies lowest.
    assert words[0] & ((1 << width) - 1) == 1 << (width - 1)
    whole = data_words(pairs, width)
    assert whole.shape[1] % 4 == 0 and not whole[:, data_bytes(width) :].any()


@pytest.mark.parametrize(
    "configuration", [Configuration(16, 0), Configuration(32, 32), Configuration(13, 4, 1)]
)
def test_users_survive(rng, configuration):
    margins = rng.integers(0, configuration.max_margin + 1, 30)
    tags = rng.integers(0, 1 << configuration.tag_bits, 30)
    got_margins, got_tags = unpack_user(pack_user(margins, tags, configuration), configuration)
    assert (got_margins == margins).all()
    assert (got_tags == tags).all()


def test_results_survive():
    verdicts = np.zeros(64, VERDICT)
    verdicts["near"] = np.arange(64) >= 32
    verdicts["axis"] = np.where(verdicts["near"], NO_AXIS, np.arange(64) % 32)
    verdicts["coplanar"] = np.arange(64) % 2 == 1
    verdicts["degenerate_b"] = np.arange(64) % 3 == 1
    assert (decode(encode(verdicts)) == verdicts).all()
