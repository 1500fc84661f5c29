"""libigl by its wheel: Guigue and Devillers' test in doubles, and one on exact predicates."""

from typing import Any

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class Libigl:
    """libigl's tri_tri_overlap_test_3d, after Guigue and Devillers, in doubles."""

    name = "libigl"
    distribution = "libigl"
    call = "igl.tri_tri_overlap_test_3d"
    batched = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "igl")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a row of each vertex."""
        igl = imported("igl")
        vertices = np.concatenate([doubles(a), doubles(b)], 1)[:, :, None]
        return one_by_one(igl.tri_tri_overlap_test_3d, [tuple(pair) for pair in vertices])


class LibiglPredicates:
    """libigl's triangle_triangle_intersect, on Shewchuk's predicates."""

    name = "libigl, predicates"
    distribution = "libigl"
    call = "igl.predicates.triangle_triangle_intersect"
    batched = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "igl.predicates")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make an array of each vertex."""
        intersect = imported("igl.predicates").triangle_triangle_intersect

        def first(*vertices: Any) -> Any:
            return intersect(*vertices)[0]

        return one_by_one(first, [tuple(pair) for pair in np.concatenate([doubles(a), doubles(b)], 1)])
