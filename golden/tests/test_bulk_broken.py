"""Builds of the bulk checker that were changed: broken ones are noticed, equivalent ones agree."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from triaxis.golden import bulk
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.tests.bulk_pairs import awkward_margins, awkward_pairs
from triaxis.golden.tests.test_bulk import assert_equal

GOLDEN = Path(bulk.__file__).parent

# File, text, replacement, and a field that goes wrong.
FAULTS = [
    ("bulk_axes.h", "for (int k = 0; k < 3; ++k) Examine", "for (int k = 0; k < 2; ++k) Examine", "above"),
    ("bulk_axes.h", "(beyond_up > 0)", "(beyond_up >= 0)", "above"),
    ("bulk_narrow.h", "return p * q - r * s", "return p * q + r * s", "below"),
    ("bulk_narrow.h", "kLargestExtent = 0x1p16", "kLargestExtent = 0x1p32", "level"),
    ("bulk_wide.h", "(coarse - high) + fine", "coarse - high", "level"),
]


@pytest.fixture
def change(tmp_path, monkeypatch):
    """Return a function that changes the sources of the checker and makes `bulk_facts` use them."""
    for file in [GOLDEN / "bulk.cpp", *GOLDEN.glob("bulk_*.h")]:
        shutil.copy(file, tmp_path)

    def apply(file, *edits):
        source = (tmp_path / file).read_text()
        for text, replacement in edits:
            assert text in source
            source = source.replace(text, replacement)
        (tmp_path / file).write_text(source)
        checker = bulk.load_checker(tmp_path)
        monkeypatch.setattr(bulk, "_checker", lambda: checker)

    return apply


@pytest.fixture
def hard(rng):
    """Return pairs, small and large, and their margins."""
    kinds = [(awkward_pairs(rng, 2000, width), width) for width in (8, 16, 24, 32)]
    margins = [awkward_margins(rng, pairs, width) for pairs, width in kinds]
    return np.concatenate([pairs for pairs, _ in kinds]), np.concatenate(margins)


@pytest.mark.parametrize("fault", FAULTS, ids=lambda fault: fault[1])
def test_a_broken_checker_is_noticed(change, hard, fault):
    right = bulk_facts(*hard)
    file, text, replacement, field = fault
    change(file, (text, replacement))
    broken = bulk_facts(*hard)
    assert (getattr(broken, field) != getattr(right, field)).any()


def test_both_arithmetics_agree(change, hard):
    right = bulk_facts(*hard)
    change("bulk_narrow.h", ("kLargestExtent = 0x1p16", "kLargestExtent = -1"))
    assert_equal(bulk_facts(*hard), right)


def test_a_processor_with_short_vectors_agrees(change, hard):
    right = bulk_facts(*hard)
    change("bulk_lanes.h", ("__AVX512F__", "NONE"), ("__AVX__", "NONE"))
    assert_equal(bulk_facts(*hard), right)
