"""Models say what is covered; samples are counted as one by one."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from triaxis.coverage.cover_model import (
    CoverItem,
    CoverModel,
    Coverpoint,
    Exclusion,
    Kind,
    MaskPoint,
    Sampler,
)

PARITY = Coverpoint[Any]("parity", ("even", "odd"), lambda s: (s % 2).astype(np.uint8))
SIZE = Coverpoint[Any]("size", ("small", "large"), lambda s: (s > 9).view(np.uint8), partial=True)
BITS = MaskPoint[Any]("bits", ("0", "1", "2"), lambda s: (s % 8).astype(np.uint32))
IGNORED = Exclusion(Kind.IGNORE, "dull", "a test", lambda parity, size: parity == 0 and size == 1)
ILLEGAL = Exclusion(Kind.ILLEGAL, "no such", "a test", lambda parity, size: size == 1)
BOTH = CoverItem("both", "both", (PARITY, SIZE), (IGNORED, ILLEGAL), lambda parity, size: 1 + parity)
MODEL = CoverModel("numbers", (BOTH, CoverItem("bits", "bits", (BITS,))))


def test_bins_goals_and_exclusions_of_a_cross():
    # The last point varies fastest, and the first exclusion holds.
    assert [b.name for b in BOTH.bins] == ["even / small", "even / large", "odd / small", "odd / large"]
    assert BOTH.size == 4 and BOTH.shape == (2, 2)
    assert [b.exclusion for b in BOTH.bins] == [None, IGNORED, None, ILLEGAL]
    assert BOTH.goals.tolist() == [1, 0, 2, 0]
    assert BOTH.illegal.tolist() == [False, False, False, True]


def test_the_hash_follows_everything_that_is_defined(tmp_path):
    source = tmp_path / "sampling.py"
    source.write_text("one")
    model = replace(MODEL, sources=(source,))
    longer = Coverpoint[Any]("size", ("small", "large", "huge"), SIZE.codes)
    changed = [
        replace(IGNORED, **change) for change in ({"reason": "x"}, {"test": "x"}, {"kind": Kind.ILLEGAL})
    ]
    changes = [{"name": "other"}, {"meaning": "other"}, {"points": (SIZE, PARITY)}]
    changes += [{"points": (PARITY, longer)}, {"at_least": 2}]
    every = ((IGNORED,), (ILLEGAL, IGNORED), *((one, ILLEGAL) for one in changed))
    changes += [{"exclusions": exclusions} for exclusions in every]
    variants = [replace(model, items=(replace(BOTH, **change), *MODEL.items[1:])) for change in changes]
    variants += [replace(model, name="other"), replace(model, items=MODEL.items[::-1]), MODEL]
    before = model.hash
    source.write_text("two")
    hashes = [before, replace(model).hash, *(variant.hash for variant in variants)]
    assert len(set(hashes)) == len(hashes) == 15
    source.write_text("one")
    assert replace(model).hash == before


def test_what_cannot_be_sampled_is_refused():
    with pytest.raises(ValueError, match="only as the first"):
        CoverItem("wrong", "", (PARITY, BITS))
    with pytest.raises(ValueError, match="needs points"):
        CoverItem("wrong", "", ())
    with pytest.raises(ValueError, match="32 bits"):
        CoverItem("wrong", "", (MaskPoint[Any]("m", ("",) * 33, lambda s: s),))
    with pytest.raises(ValueError, match="share a name"):
        CoverModel("wrong", (BOTH, BOTH))


def point(name, bins, partial):
    """A point whose codes are a column of the sample."""
    return Coverpoint[Any](name, tuple(map(str, range(bins))), lambda s: s[name].astype(np.uint8), partial)


POINTS = (point("a", 2, False), point("b", 3, True), point("c", 7, True), point("d", 13, False))
MASK = MaskPoint[Any]("mask", tuple(map(str, range(19))), lambda s: s["mask"])


def random_sample(rng, count):
    sample = {p.name: rng.integers(0, p.radix, count) for p in POINTS}
    masks = rng.integers(0, 1 << 19, count) * rng.integers(0, 2, count)
    return {**sample, "mask": masks.astype(np.uint32)}


def counted_one_by_one(item, sample, count):
    """The counts of an item by the names of its bins, without arrays."""
    found = Counter()
    points = [p for p in item.points if isinstance(p, Coverpoint)]
    for i in range(count):
        codes = [int(sample[p.name][i]) for p in points]
        if any(code == len(p.bins) for p, code in zip(points, codes, strict=True)):
            continue
        heads = [[]]
        if item.points[0] is MASK:
            heads = [[str(bit)] for bit in range(19) if int(sample["mask"][i]) >> bit & 1]
        rest = [p.bins[code] for p, code in zip(points, codes, strict=True)]
        found.update(" / ".join([*head, *rest]) for head in heads)
    return found


@pytest.mark.parametrize("chosen", ["a", "c", "ab", "ba", "bcd", "dcba", "m", "ma", "mbc", "mdcb"])
def test_counts_are_those_of_counting_one_by_one(rng, chosen):
    by_name = {**{p.name: p for p in POINTS}, "m": MASK}
    item = CoverItem("item", "", tuple(by_name[name] for name in chosen))
    for count in (0, 1, 300):
        sample = random_sample(rng, count)
        hits = Sampler(sample).hits(item)
        found = {b.name: n for b, n in zip(item.bins, hits.tolist(), strict=True) if n}
        assert found == counted_one_by_one(item, sample, count)


@settings(max_examples=30, deadline=None)
@given(st.lists(st.integers(2, 40), min_size=1, max_size=4))
def test_joint_codes_have_room_whatever_the_sizes(sizes):
    points = tuple(point(str(k), size, True) for k, size in enumerate(sizes))
    sample = {str(k): np.array([0, size - 1, size - 1]) for k, size in enumerate(sizes)}
    hits = Sampler(sample).hits(CoverItem("item", "", points))
    assert hits[0] == 1 and hits[-1] == 2 and hits.sum() == 3


def test_a_code_without_a_bin_is_an_error_and_not_another_bin():
    sample = {"a": np.array([0, 2]), "b": np.array([0, 0]), "mask": np.array([1, 1 << 19], np.uint32)}
    with pytest.raises(ValueError, match="a: code 2"):
        Sampler(sample).hits(CoverItem("item", "", (POINTS[0], POINTS[1])))
    with pytest.raises(ValueError, match="beyond its 19 bins"):
        Sampler(sample).hits(CoverItem("item", "", (MASK,)))
