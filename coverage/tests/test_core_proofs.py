"""What the model excludes is never seen, what it asks for is: on all pairs of a tiny grid, and many more."""

from functools import cache

import numpy as np
import pytest

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.core_sample import Build
from triaxis.coverage.report import report
from triaxis.coverage.terminal import coverage_lines
from triaxis.coverage.tests.core_pairs import (
    all_pairs_of_unit_cube,
    grid_pairs,
    grown,
    margins_for,
    moved,
    one_size_larger,
    pointing_pairs,
    related_pairs,
    samples,
    sheared,
    sole_representatives,
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


@cache
def covered(parameters, seed):
    """The coverage of everything that is thrown at a build here."""
    rng = np.random.default_rng(seed)
    build = Build(*parameters)
    coverage = CoreCoverage(*parameters)
    cube = all_pairs_of_unit_cube()
    feed(coverage, rng, build, cube, np.zeros(len(cube), np.int64))
    for size in (3, 4):
        pairs = grid_pairs(rng, 60_000, size)
        feed(coverage, rng, build, pairs, rng.integers(0, min(build.largest_margin, 2) + 1, len(pairs)))
    for size in (1, 2, 3, 5):
        pairs = np.concatenate([related_pairs(rng, 40_000, size), pointing_pairs(rng, 2_000)])
        margins = margins_for(rng, build, pairs)
        more, more_margins = sole_representatives(pairs, margins)
        pairs, margins = np.concatenate([pairs, more]), np.concatenate([margins, more_margins])
        reach = 1 << build.width // 2 - 1
        feed(coverage, rng, build, pairs, margins)
        feed(coverage, rng, build, pairs + rng.integers(-reach, reach, (len(pairs), 1, 1, 3)), margins)
        feed(coverage, rng, build, moved(rng, pairs, build.width, to_limits=False), margins)
        feed(coverage, rng, build, moved(rng, pairs, build.width, to_limits=True), margins)
        pairs = pairs[rng.integers(0, len(pairs), 40_000)]
        for widen in (sheared, grown, one_size_larger):
            wide = widen(rng, pairs, build.width)
            margins = margins_for(rng, build, wide)
            feed(coverage, rng, build, wide, margins)
            feed(coverage, rng, build, *sole_representatives(wide, margins))
    wide = wide_pairs(rng, 40_000, build.width)
    margins = margins_for(rng, build, wide)
    feed(coverage, rng, build, wide, margins)
    feed(coverage, rng, build, *sole_representatives(wide, margins))
    feed(coverage, rng, build, wide[:100], np.full(100, build.largest_margin))
    return coverage


@pytest.mark.parametrize("parameters", BUILDS, ids=lambda p: Build(*p).name)
def test_no_excluded_bin_is_hit(parameters, seed):
    coverage = covered(parameters, seed)
    found = report(coverage.model, coverage.counts)
    assert not [hit for item in found.items for hit in item.illegal_hits]
    assert all(group.hits == 0 for item in found.items for group in item.excluded)
    assert sum(group.bins for item in found.items for group in item.excluded) > 100


@pytest.mark.parametrize("parameters", BUILDS, ids=lambda p: Build(*p).name)
def test_every_other_bin_is_reached(parameters, seed):
    coverage = covered(parameters, seed)
    print("\n".join(coverage_lines(report(coverage.model, coverage.counts))))
    found = report(coverage.model, coverage.counts)
    assert not {item.name: item.missing for item in found.items if item.missing}
