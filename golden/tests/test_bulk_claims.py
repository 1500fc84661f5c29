"""Verdicts alone against those that come with all facts; builds that were changed."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden import bulk
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.bulk_claims import bulk_claims, load_claims
from triaxis.golden.claim_check import claims_prove_clear
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import NO_AXIS
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs

GOLDEN = Path(bulk.__file__).parent
WIDTHS = (8, 16, 17, 20, 24, 25, 26, 27, 30, 32)

# Text and replacement: bounds of rounding, shortcuts, signs.
FAULTS = [
    ("kExact = 0x1p16", "kExact = 0x1p40"),
    ("kExactEdge = 0x1p24", "kExactEdge = 0x1p40"),
    ("return doubtful ? exactly : separates", "return separates"),
    ("doubtful ? Exactly(e, f, near, far) : separates", "separates"),
    ("& ~(off_a | off_b)", "& ~(off_a | ~off_a)"),
    ("on_b[j] - on_b[(j + 1) % 3]", "on_b[(j + 1) % 3] - on_b[j]"),
    ("  undecided.Finish();\n", ""),
]


def hard_pairs(rng, count):
    """Return pairs of all widths in random order, so that neighbours need different arithmetic; margins."""
    pairs = [awkward_pairs(rng, count, width) for width in WIDTHS]
    margins = [awkward_margins(rng, p, width) for p, width in zip(pairs, WIDTHS, strict=True)]
    order = rng.permutation(sum(map(len, pairs)))
    return np.concatenate(pairs)[order], np.concatenate(margins)[order]


def test_claims_are_those_of_the_facts(rng):
    pairs, margins = hard_pairs(rng, 8000)
    claims, facts = bulk_claims(pairs, margins), bulk_facts(pairs, margins)
    assert np.array_equal(claims, facts.claim)
    assert len(set(claims)) > 25
    clear = claims != NO_AXIS
    assert claims_prove_clear(pairs[clear], margins[clear], claims[clear]).all()
    collision = bulk_claims(pairs, 0)
    assert np.array_equal(collision, bulk_facts(pairs, 0).claim)
    assert len(set(collision)) > 25


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9])
def test_any_number_of_pairs(rng, count):
    pairs, margins = (array[:count] for array in hard_pairs(rng, 8))
    assert np.array_equal(bulk_claims(pairs, margins), bulk_facts(pairs, margins).claim)


def test_bad_input_is_refused():
    with pytest.raises(InputError, match="shape"):
        bulk_claims(np.zeros((3, 3), np.int32), 0)
    with pytest.raises(InputError, match="margins"):
        bulk_claims(np.zeros((1, 2, 3, 3), np.int32), -1)


@pytest.fixture
def changed(tmp_path):
    """Return a function that changes the sources and returns `bulk_claims` on the build of those."""
    for file in [GOLDEN / "bulk_claims.cpp", *GOLDEN.glob("bulk_*.h")]:
        shutil.copy(file, tmp_path)

    def apply(file, *edits):
        source = (tmp_path / file).read_text()
        for text, replacement in edits:
            assert text in source
            source = source.replace(text, replacement)
        (tmp_path / file).write_text(source)
        native = load_claims(tmp_path)
        return lambda pairs, margins: bulk_claims(pairs, margins, native)

    return apply


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[0].strip())
def test_a_broken_build_is_noticed(changed, rng, fault):
    pairs, margins = hard_pairs(rng, 2000)
    broken = changed("bulk_claims.cpp", fault)
    wrong = broken(pairs, margins) != bulk_facts(pairs, margins).claim
    wrong_without = broken(pairs, 0) != bulk_facts(pairs, 0).claim
    assert wrong.any() or wrong_without.any()


@pytest.mark.parametrize("missing", ["__AVX512F__", "__AVX__"])
def test_a_processor_with_shorter_vectors_agrees(changed, rng, missing):
    pairs, margins = hard_pairs(rng, 2000)
    edits = (
        [("__AVX512F__", "NONE")]
        if missing == "__AVX512F__"
        else [("__AVX512F__", "NONE"), ("__AVX__", "NONE")]
    )
    changed("bulk_claims.cpp", ("__AVX512F__", "NONE"))
    short = changed("bulk_lanes.h", *edits)
    assert np.array_equal(short(pairs, margins), bulk_facts(pairs, margins).claim)
