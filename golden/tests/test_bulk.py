"""The bulk checker: facts by their definitions, verdicts by the linear program; broken builds are noticed."""

import shutil
import subprocess
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden import bulk
from triaxis.golden.axes import separating
from triaxis.golden.bulk import bulk_claims, bulk_facts, bulk_verdicts
from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.errors import InputError
from triaxis.golden.facts import Facts
from triaxis.golden.judge import judge, judge_pairs
from triaxis.golden.pairs import NO_AXIS, coordinate_range
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs, hard_pairs
from triaxis.golden.tests.bulk_reference import slow_facts

WIDTHS = (8, 16, 24, 32)
FOLDER = Path(bulk.__file__).parent
# Reads pairs and margins, and writes: the claim of each, whether that is proven, and near, of each alone.
IN_C = """
#include <stdio.h>
#include <triaxis.h>
int main(void) {
  struct { int32_t pair[TRIAXIS_COORDINATES]; uint32_t margin; } one;
  while (fread(&one, sizeof one, 1, stdin) == 1) {
    int8_t claim;
    uint8_t proven;
    triaxis_claims(one.pair, &one.margin, 1, &claim);
    triaxis_proven(one.pair, &one.margin, &claim, 1, &proven);
    printf("%d %d %d\\n", claim, proven, triaxis_near(one.pair, one.margin));
  }
  return 0;
}
"""
NAMES = [field.name for field in fields(Facts)]


def packed(separates):
    return (separates << np.arange(32, dtype=np.uint64)).sum(1, dtype=np.uint64).astype(np.uint32)


def assert_equal(facts, expected):
    for name in NAMES:
        wrong = np.flatnonzero(getattr(facts, name) != getattr(expected, name))
        assert len(wrong) == 0, f"{name} of pair {wrong[0]}"


@pytest.mark.parametrize("width", WIDTHS)
def test_facts_are_what_they_are_defined_to_be(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    facts = bulk_facts(pairs, margins)
    for index, ((a, b), margin) in enumerate(zip(pairs.tolist(), margins.tolist(), strict=True)):
        found = {name: int(getattr(facts, name)[index]) for name in NAMES}
        assert found == slow_facts(a, b, margin), f"pair {[a, b]}, margin {margin}"
    # Nothing above was trivial: steps on normals and edge x edge axes, among pairs that fill the range.
    for name in NAMES:
        assert len(np.unique(getattr(facts, name))) > 1, name
    filling = np.ptp(pairs.reshape(len(pairs), 6, 3), axis=1).max(1) >= 1 << (width - 2)
    assert (facts.clear_step[filling] & 0x3FF8).any() and (facts.near_step[filling] & 0x3FF8).any()


@pytest.mark.parametrize(("width", "count"), [(8, 20000), (16, 20000), (17, 20000), (20, 2000), (32, 2000)])
def test_separating_axes_agree_with_their_definition(rng, width, count):
    pairs = awkward_pairs(rng, count, width)
    margins = awkward_margins(rng, pairs, width)
    assert (bulk_facts(pairs, margins).separating == packed(separating(pairs, margins))).all()
    # All coordinates at the limits.
    low, high = coordinate_range(width)
    pairs = rng.choice(np.array([low, high]), (500, 2, 3, 3))
    for margin in (0, 1, high - low - 1, high - low):
        expected = packed(separating(pairs, np.full(len(pairs), margin)))
        assert (bulk_facts(pairs, margin).separating == expected).all()


@pytest.mark.parametrize("width", WIDTHS)
def test_the_linear_program_agrees_which_knows_nothing_of_axes(rng, width):
    pairs = awkward_pairs(rng, 300, width)
    margins = awkward_margins(rng, pairs, width)
    verdicts, facts = bulk_verdicts(pairs, margins), bulk_facts(pairs, margins)
    assert (verdicts == judge_pairs(pairs, margins)).all()
    assert 0.1 < verdicts["near"].mean() < 0.9
    level = facts.near & (facts.level != 0)
    assert level.any()
    for (a, b), margin in zip(pairs[level].tolist(), margins[level].tolist(), strict=True):
        assert judge(a, b, 0).distance == margin


def test_claims_are_those_of_the_facts(rng):
    pairs, margins = hard_pairs(rng, 8000)
    claims = bulk_claims(pairs, margins)
    assert np.array_equal(claims, bulk_facts(pairs, margins).claim) and len(set(claims)) > 25
    clear = claims != NO_AXIS
    assert claims_prove_clear(pairs[clear], margins[clear], claims[clear]).all()
    collision = bulk_claims(pairs, 0)
    assert np.array_equal(collision, bulk_facts(pairs, 0).claim) and len(set(collision)) > 25
    for count in (0, 1, 7, 8, 9):
        assert np.array_equal(bulk_claims(pairs[:count], margins[:count]), claims[:count])


def test_a_margin_that_reaches_everything():
    corner = (1 << 31) - 1
    a, b = np.full((3, 3), -1 - corner), np.full((3, 3), corner)
    pairs = np.stack([a, b])[None]
    assert bulk_facts(pairs, (1 << 32) - 1).near.all()
    assert bulk_facts(pairs, (1 << 32) - 1).level[0] == 0b111
    assert bulk_facts(pairs, (1 << 32) - 2).clear_step[0] == 0b111
    close = np.zeros((1, 2, 3, 3), np.int32)
    close[:, 1] = 5
    for margin, field in ((4, "clear_step"), (5, "level"), (6, "near_step")):
        assert getattr(bulk_facts(close, margin), field)[0] == 0b111
    for margin in (7, 8, 1 << 31, (1 << 32) - 1):
        assert_equal(bulk_facts(close, margin), bulk_facts(close, 7))


def test_bad_input_is_refused():
    good = np.zeros((3, 2, 3, 3), np.int64)
    outside = good.copy()
    outside[2, 1, 0, 2] = 1 << 31
    for pairs, margins, says in (
        (outside, 0, "pair 2, triangle B, vertex 0, coordinate z: 2147483648 is outside"),
        (good[0].astype(np.int32), 0, r"shape \(2, 3, 3\)"),
        (good * 0.5, 0, "type float64"),
        (good[:2], np.array([0, -1]), r"margins: number 1: .*: must be 0\.\.4294967295"),
        (good[:2], np.array([0, 1 << 32]), r"margins: number 1: .*: must be 0\.\.4294967295"),
        (good[:2], np.zeros(3, np.int64), r"must be integers of shape \(2,\)"),
        (good[:2], np.zeros(2), "margins: float64"),
    ):
        for asked in (bulk_facts, bulk_claims):
            with pytest.raises(InputError, match=says):
                asked(pairs, margins)


def test_verdicts_of_chunks(rng, monkeypatch):
    monkeypatch.setattr(bulk, "_CHUNK", 64)
    pairs = awkward_pairs(rng, 200, 16)
    margins = awkward_margins(rng, pairs, 16)
    done = []
    assert (bulk_verdicts(pairs, margins, done.append) == bulk_facts(pairs, margins).verdicts).all()
    assert sum(done) == len(pairs) and len(bulk_verdicts(pairs[:0], 0)) == 0


# Builds of native code that were changed.
GOLDEN = Path(bulk.__file__).parent

# File, text, replacement, and a field that goes wrong.
FAULTS = [
    ("bulk_axes.h", "for (int k = 0; k < 3; ++k) Examine", "for (int k = 0; k < 2; ++k) Examine", "above"),
    ("bulk_axes.h", "(beyond_up > 0)", "(beyond_up >= 0)", "above"),
    ("bulk_narrow.h", "return p * q - r * s", "return p * q + r * s", "below"),
    ("bulk_narrow.h", "kLargestExtent = 0x1p16", "kLargestExtent = 0x1p32", "level"),
    ("bulk_wide.h", "(coarse - high) + fine", "coarse - high", "level"),
]

CLAIM_FAULTS = [
    ("kExact = 0x1p16", "kExact = 0x1p40"),
    ("kExactEdge = 0x1p24", "kExactEdge = 0x1p40"),
    ("return doubtful ? exactly : separates", "return separates"),
    ("doubtful ? Exactly(e, f, near, far) : separates", "separates"),
    ("& ~(off_a | off_b)", "& ~(off_a | ~off_a)"),
    ("on_b[j] - on_b[(j + 1) % 3]", "on_b[(j + 1) % 3] - on_b[j]"),
    ("  undecided.Finish();\n", ""),
]


@pytest.fixture
def change(tmp_path, monkeypatch):
    """Return a function that changes sources and makes `bulk_facts`, or `bulk_claims`, use them."""
    for file in [GOLDEN / "bulk.cpp", GOLDEN / "bulk_claims.cpp", *GOLDEN.glob("bulk_*.h")]:
        shutil.copy(file, tmp_path)

    def apply(file, *edits, claims=False):
        source = (tmp_path / file).read_text()
        for text, replacement in edits:
            assert text in source
            source = source.replace(text, replacement)
        (tmp_path / file).write_text(source)
        names = ("bulk_claims", "triaxis_claims") if claims else ("bulk", "triaxis_facts")
        native = bulk.load_native(*names, tmp_path)
        monkeypatch.setattr(bulk, "_claims" if claims else "_facts", lambda: native)

    return apply


@pytest.fixture
def hard(rng):
    return hard_pairs(rng, 6000)


@pytest.mark.regress
@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[1])
def test_a_broken_checker_is_noticed(change, hard, fault):
    right = bulk_facts(*hard)
    file, text, replacement, field = fault
    change(file, (text, replacement))
    assert (getattr(bulk_facts(*hard), field) != getattr(right, field)).any()


@pytest.mark.regress
@pytest.mark.parametrize("fault", CLAIM_FAULTS, ids=lambda fault: fault[0].strip())
def test_broken_claims_are_noticed(change, hard, fault):
    change("bulk_claims.cpp", fault, claims=True)
    # Of several counts, as some faults are at the end of the last block.
    for count in (*range(100, 900, 100), len(hard[0])):
        pairs, margins = (each[:count] for each in hard)
        if any((bulk_claims(pairs, m) != bulk_facts(pairs, m).claim).any() for m in (margins, 0)):
            return
    pytest.fail("not noticed")


@pytest.mark.regress
@pytest.mark.parametrize(
    ("file", "edits"),
    [
        # The wide arithmetic for all; a processor with short vectors.
        ("bulk_narrow.h", [("kLargestExtent = 0x1p16", "kLargestExtent = -1")]),
        ("bulk_lanes.h", [("__AVX512F__", "NONE"), ("__AVX__", "NONE")]),
    ],
)
def test_equivalent_builds_agree(change, hard, file, edits):
    right = bulk_facts(*hard)
    change(file, *edits)
    assert_equal(bulk_facts(*hard), right)


@pytest.mark.regress
def test_claims_on_a_processor_with_short_vectors_agree(change, hard):
    change("bulk_lanes.h", ("__AVX512F__", "NONE"), ("__AVX__", "NONE"), claims=True)
    assert np.array_equal(bulk_claims(*hard), bulk_facts(*hard).claim)


def test_a_program_in_c_is_answered_alike(rng, tmp_path):
    (tmp_path / "program.c").write_text(IN_C)
    flags = ["-O3", "-march=native"]
    sources = [FOLDER / "bulk_claims.cpp", FOLDER / "certificate.cpp"]
    built = [
        ["c++", *flags, "-std=c++20", "-c", *map(str, sources)],
        [
            "cc",
            "-Wall",
            "-Wextra",
            "-Werror",
            f"-I{FOLDER.parent / 'docs'}",
            "program.c",
            *(f"{path.stem}.o" for path in sources),
            "-lstdc++",
            "-o",
            "program",
        ],
    ]
    for command in built:
        subprocess.run(command, cwd=tmp_path, check=True)
    pairs = awkward_pairs(rng, 3000, 32)
    margins = awkward_margins(rng, pairs, 32)
    asked = np.concatenate(
        [pairs.reshape(-1, 18).astype(np.int32), margins.astype(np.uint32).view(np.int32)[:, None]], axis=1
    )
    done = subprocess.run([tmp_path / "program"], input=asked.tobytes(), capture_output=True, check=True)
    claims, proven, near = np.array(done.stdout.split(), np.int64).reshape(-1, 3).T
    assert (claims == bulk_claims(pairs, margins)).all()
    assert (proven == (claims != NO_AXIS)).all() and (near == bulk_verdicts(pairs, margins)["near"]).all()
    assert 100 < near.sum() < 2900
