"""What the model excludes is never seen: on all pairs of a tiny grid, and many more."""

from itertools import product

import numpy as np
import pytest

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.report import report
from triaxis.coverage.tests.core_samples import samples
from triaxis.sim.configuration import Configuration
from triaxis.verif.core.stimulus.families import mixed

BUILDS = (
    Configuration(8),
    Configuration(8, 8),
    Configuration(edge_box=False),
    Configuration(13, 4, gating=False),
    Configuration(32, 32),
)
# All 2^18 ordered pairs of triangles with vertices in {0, 1}^3.
CUBE = np.array(list(product((0, 1), repeat=3)))[np.indices((8,) * 6).reshape(6, -1).T].reshape(-1, 2, 3, 3)


@pytest.mark.parametrize("build", BUILDS, ids=lambda build: build.name)
def test_no_excluded_bin_is_hit(build, rng):
    coverage = CoreCoverage(build)
    grid = rng.integers(0, 4, (60_000, 2, 3, 3))
    families = mixed(rng, 100_000, build.width, build.max_margin)
    for pairs, margins in (
        (CUBE, np.zeros(len(CUBE), np.int64)),
        (grid, rng.integers(0, min(build.max_margin, 2) + 1, len(grid))),
        (families.pairs.astype(np.int64), families.margins),
        (families.pairs[:100].astype(np.int64), np.full(100, build.max_margin)),
    ):
        for sample in samples(rng, build, pairs, margins):
            coverage.sample(sample)
    found = report(coverage.model, coverage.counts)
    assert not [hit for item in found.items for hit in item.illegal_hits]
    assert all(group.hits == 0 for item in found.items for group in item.excluded)
    assert sum(group.bins for item in found.items for group in item.excluded) > 100
    # Most of what may be hit was: the pairs are rich enough to tell.
    assert found.hit > 0.85 * found.total
