"""Builds of the bulk checker that were changed: broken ones are noticed, equivalent ones agree."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden import bulk
from triaxis.golden.bulk import bulk_claims, bulk_facts
from triaxis.golden.tests.bulk_pairs import hard_pairs
from triaxis.golden.tests.test_bulk import assert_equal

# A build of native code for each.
pytestmark = pytest.mark.regress

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
    return hard_pairs(rng, 1500)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[1])
def test_a_broken_checker_is_noticed(change, hard, fault):
    right = bulk_facts(*hard)
    file, text, replacement, field = fault
    change(file, (text, replacement))
    assert (getattr(bulk_facts(*hard), field) != getattr(right, field)).any()


@pytest.mark.parametrize("fault", CLAIM_FAULTS, ids=lambda fault: fault[0].strip())
def test_broken_claims_are_noticed(change, hard, fault):
    change("bulk_claims.cpp", fault, claims=True)
    pairs, margins = hard
    assert any((bulk_claims(pairs, m) != bulk_facts(pairs, m).claim).any() for m in (margins, 0))


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


def test_claims_on_a_processor_with_short_vectors_agree(change, hard):
    change("bulk_claims.cpp", ("__AVX512F__", "NONE"), claims=True)
    change("bulk_lanes.h", ("__AVX512F__", "NONE"), ("__AVX__", "NONE"), claims=True)
    assert np.array_equal(bulk_claims(*hard), bulk_facts(*hard).claim)
