"""What the model excludes is never seen: on all pairs of a tiny grid, and many more."""

import numpy as np
import pytest

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.core_sample import Build
from triaxis.coverage.report import report
from triaxis.coverage.tests.core_pairs import (
    all_pairs_of_unit_cube,
    grid_pairs,
    margins_for,
    moved,
    pointing_pairs,
    related_pairs,
    samples,
    wide_pairs,
)

BUILDS = (
    (8, 0, True, True),
    (8, 8, True, True),
    (16, 0, False, True),
    (13, 4, True, False),
    (32, 32, True, True),
)


def feed(coverage, rng, build, pairs, margins):
    for sample in samples(rng, build, pairs, margins):
        coverage.sample(sample)


@pytest.mark.parametrize("parameters", BUILDS, ids=lambda p: Build(*p).name)
def test_no_excluded_bin_is_hit(parameters, rng):
    build, coverage = Build(*parameters), CoreCoverage(*parameters)
    cube = all_pairs_of_unit_cube()
    feed(coverage, rng, build, cube, np.zeros(len(cube), np.int64))
    for size in (3, 4):
        pairs = grid_pairs(rng, 30_000, size)
        feed(coverage, rng, build, pairs, rng.integers(0, min(build.largest_margin, 2) + 1, len(pairs)))
    for size in (1, 2, 3, 5):
        pairs = np.concatenate([related_pairs(rng, 10_000, size), pointing_pairs(rng, 1_000)])
        margins = margins_for(rng, build, pairs)
        feed(coverage, rng, build, moved(rng, pairs, build.width, to_limits=size % 2 == 0), margins)
    wide = wide_pairs(rng, 10_000, build.width)
    feed(coverage, rng, build, wide, margins_for(rng, build, wide))
    feed(coverage, rng, build, wide[:100], np.full(100, build.largest_margin))
    found = report(coverage.model, coverage.counts)
    assert not [hit for item in found.items for hit in item.illegal_hits]
    assert all(group.hits == 0 for item in found.items for group in item.excluded)
    assert sum(group.bins for item in found.items for group in item.excluded) > 100
