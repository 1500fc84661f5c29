"""Models say what is covered; samples are counted as one by one; counts merge, and come back from files."""

from collections import Counter
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.board_coverage import board_model
from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.counts import Counts, CoverageDatabase, load, read_counts
from triaxis.coverage.cover_model import (
    CoverItem,
    CoverModel,
    Coverpoint,
    Exclusion,
    Kind,
    MaskPoint,
    Sampler,
)
from triaxis.coverage.mesh_coverage import mesh_model
from triaxis.coverage.mesh_sample import MeshBuild
from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import Sources

PARITY = Coverpoint[Any]("parity", ("even", "odd"), lambda s: (s % 2).astype(np.uint8))
SIZE = Coverpoint[Any]("size", ("small", "large"), lambda s: (s > 9).view(np.uint8), partial=True)
BITS = MaskPoint[Any]("bits", ("0", "1", "2"), lambda s: (s % 8).astype(np.uint32))
IGNORED = Exclusion(Kind.IGNORE, "dull", "a test", lambda parity, size: parity == 0 and size == 1)
ILLEGAL = Exclusion(Kind.ILLEGAL, "no such", "a test", lambda parity, size: size == 1)
BOTH = CoverItem("both", "both", (PARITY, SIZE), (IGNORED, ILLEGAL), lambda parity, size: 1 + parity)
MODEL = CoverModel("numbers", (BOTH, CoverItem("bits", "bits", (BITS,))))


def test_the_hash_follows_everything_that_is_defined():
    model = replace(MODEL, sources=Sources(("triaxis.coverage.cover_model",)))
    changes = [{"name": "other"}, {"meaning": "other"}, {"points": (SIZE, PARITY)}, {"at_least": 2}]
    other = [replace(IGNORED, **one) for one in ({"reason": "x"}, {"test": "x"}, {"kind": Kind.ILLEGAL})]
    changes += [{"exclusions": (one, ILLEGAL)} for one in other]
    variants = [replace(model, items=(replace(BOTH, **change), *MODEL.items[1:])) for change in changes]
    hashes = {each.hash for each in (model, *variants, replace(model, name="other"), MODEL)}
    assert len(hashes) == 3 + len(changes)


@pytest.mark.parametrize(
    ("model", "decides"),
    [
        (core_model(Configuration()), "verif/core/checking.py golden/bulk.cpp sim/packing.py"),
        (mesh_model(MeshBuild("mesh", 8, 0, 16, 4, 2, 8)), "verif/mesh/sampling.py golden/scene.py"),
        (board_model(), "verif/board/reference.py verif/board/reply_check.py verif/mesh/expectation.py"),
    ],
)
def test_what_makes_samples_is_among_what_a_count_hangs_on(model, decides):
    files = {str(path.relative_to(ROOT)) for path in model.sources.files()}
    assert files >= {"coverage/bins.cpp", *decides.split()}


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
    for count in (0, 1, 300, 2100):
        sample = random_sample(rng, count)
        hits = Sampler(sample).hits(item)
        found = {b.name: n for b, n in zip(item.bins, hits.tolist(), strict=True) if n}
        assert found == counted_one_by_one(item, sample, count)


def test_what_would_always_be_covered_is_refused():
    with pytest.raises(ValueError, match="without bins would always be covered"):
        CoverItem("item", "", (replace(POINTS[0], bins=()),))
    with pytest.raises(ValueError, match=f"item: {POINTS[0].bins[0]}: a bin that needs no hit"):
        list(CoverItem("item", "", (POINTS[0],), at_least=0).bins)


def test_a_code_without_a_bin_is_an_error_and_not_another_bin():
    sample = {"a": np.array([0, 2]), "b": np.array([0, 0]), "mask": np.array([1, 1 << 19], np.uint32)}
    with pytest.raises(ValueError, match="a: code 2"):
        Sampler(sample).hits(CoverItem("item", "", (POINTS[0], POINTS[1])))
    with pytest.raises(ValueError, match="beyond its 19 bins"):
        Sampler(sample).hits(CoverItem("item", "", (MASK,)))
    for kind in (np.int8, np.int64, np.float64):
        signed = replace(POINTS[0], codes=lambda s, kind=kind: np.array([0, -1], kind))
        with pytest.raises(ValueError, match="must be unsigned"):
            Sampler(sample).hits(CoverItem("item", "", (signed,)))
    short = replace(POINTS[1], codes=lambda s: np.zeros(1, np.uint8))
    for points in ((POINTS[3], short), (MASK, short)):
        with pytest.raises(ValueError, match="different samples"):
            Sampler({"d": sample["b"], "mask": np.zeros(2, np.uint32)}).hits(CoverItem("item", "", points))


DIGIT = Coverpoint[Any]("digit", tuple("0123456789"), lambda s: (s % 10).astype(np.uint8))
DIGITS = CoverModel("digits", (CoverItem("digit", "", (DIGIT,)), CoverItem("both", "", (DIGIT, PARITY))))
OTHER = CoverModel("others", (CoverItem("parity", "", (PARITY,)),))
CHANGED = CoverModel("digits", (CoverItem("digit", "", (DIGIT,), at_least=2), DIGITS.items[1]))


def counted(numbers, model=DIGITS):
    counts = Counts.empty(model)
    counts.sample(model, np.array(numbers, np.int64))
    return counts


def merge(model, parts):
    total = Counts.empty(model)
    for part in parts:
        total.add(part)
    return total


def flat(counts):
    return {name: hits.tolist() for name, hits in counts.hits.items()}


def test_counts_of_another_model_or_definition_are_refused(tmp_path):
    for wrong in (counted([1], OTHER), counted([1], CHANGED)):
        with pytest.raises(InputError, match="cannot be merged"):
            merge(DIGITS, [wrong])
    path = tmp_path / "coverage.json"
    counted([1]).save(path)
    with pytest.raises(InputError, match="not among those"):
        load(path, OTHER)
    with pytest.raises(InputError, match="another definition of coverage model digits"):
        load(path, CHANGED)


def test_files_come_back_whole(tmp_path):
    path = tmp_path / "coverage.json"
    counted([1, 2, 30]).save(path)
    database = CoverageDatabase([DIGITS, OTHER])
    database.add_file(path)
    database.add_file(path)
    database.add(counted([7], OTHER))
    database.save(path)
    digits, others = read_counts(path, [OTHER, DIGITS])
    assert flat(digits) == flat(counted([1, 2, 30] * 2)) and flat(others) == flat(counted([7], OTHER))


def test_damaged_files_are_refused(tmp_path):
    path = tmp_path / "coverage.json"
    counted([1]).save(path)
    text = path.read_text()
    for damaged in (
        text[: len(text) // 2],
        "{}",
        text.replace("[0, 1,", "[0, 7,", 1),
        text.replace("triaxis coverage 1", "triaxis coverage 2"),
        text.replace('"digit"', '"tigid"'),
        "[" * 100_000,
    ):
        assert damaged != text
        path.write_text(damaged)
        with pytest.raises(InputError, match=r"coverage\.json: .*delete it and run again"):
            load(path, DIGITS)
    # Whole, but not of the bins that there are.
    for numbers, said in (
        (["x"] * 9, "no number"), ([1 << 80] * 10, "no number"), ([0] * 9, "not fit"), ([-1] * 10, "not fit"),
    ):  # fmt: skip
        counts = counted([1])
        replace(counts, hits={**counts.hits, "digit": np.array(numbers)}).save(path)
        with pytest.raises(InputError, match=f"counts .*{said}.*; delete it and run again"):
            load(path, DIGITS)
