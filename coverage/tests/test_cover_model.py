from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.cover_model import CoverItem, CoverModel, Coverpoint, Exclusion, Kind, MaskPoint

PARITY = Coverpoint[Any]("parity", ("even", "odd"), lambda s: (s % 2).astype(np.uint8))
SIZE = Coverpoint[Any]("size", ("small", "large"), lambda s: (s > 9).view(np.uint8), partial=True)
BITS = MaskPoint[Any]("bits", ("0", "1", "2"), lambda s: (s % 8).astype(np.uint32))
IGNORED = Exclusion(Kind.IGNORE, "dull", "a test", lambda parity, size: parity == 0 and size == 1)
ILLEGAL = Exclusion(Kind.ILLEGAL, "no such", "a test", lambda parity, size: size == 1)
BOTH = CoverItem("both", "both", (PARITY, SIZE), (IGNORED, ILLEGAL), lambda parity, size: 1 + parity)
MODEL = CoverModel("numbers", (BOTH, CoverItem("bits", "bits", (BITS,))))


def test_a_cross_has_all_combinations_the_last_varying_fastest():
    assert [b.name for b in BOTH.bins] == ["even / small", "even / large", "odd / small", "odd / large"]
    assert BOTH.size == 4 and BOTH.shape == (2, 2)


def test_goals_and_exclusions_are_by_bin_and_the_first_exclusion_holds():
    assert [b.exclusion for b in BOTH.bins] == [None, IGNORED, None, ILLEGAL]
    assert BOTH.goals.tolist() == [1, 0, 2, 0]
    assert BOTH.illegal.tolist() == [False, False, False, True]


def test_the_hash_follows_everything_that_is_defined(tmp_path):
    source = tmp_path / "sampling.py"
    source.write_text("one")
    model = replace(MODEL, sources=(source,))
    longer = Coverpoint[Any]("size", ("small", "large", "huge"), SIZE.codes)
    items = [
        replace(BOTH, name="other"),
        replace(BOTH, meaning="other"),
        replace(BOTH, points=(SIZE, PARITY)),
        replace(BOTH, points=(PARITY, longer)),
        replace(BOTH, at_least=2),
        replace(BOTH, exclusions=(IGNORED,)),
        replace(BOTH, exclusions=(replace(IGNORED, reason="other"), ILLEGAL)),
        replace(BOTH, exclusions=(replace(IGNORED, test="other"), ILLEGAL)),
        replace(BOTH, exclusions=(replace(IGNORED, kind=Kind.ILLEGAL), ILLEGAL)),
        replace(BOTH, exclusions=(ILLEGAL, IGNORED)),
    ]
    variants = [replace(model, items=(item, *MODEL.items[1:])) for item in items]
    variants += [replace(model, name="other"), replace(model, items=MODEL.items[::-1]), MODEL]
    before = model.hash
    source.write_text("two")
    hashes = [before, replace(model).hash, *(variant.hash for variant in variants)]
    assert len(set(hashes)) == len(hashes)
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
