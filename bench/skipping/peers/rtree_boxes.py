"""trimesh's tree of a mesh's facets, an R-tree of package rtree, asked about the other's boxes."""

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.skipping.peers.mesh_peer import Counted, Integers, Question, Reals


class RtreeBoxes:
    """rtree's bulk query of the tree that trimesh makes: boxes alone, no triangles."""

    name = "trimesh triangles_tree (rtree)"
    distribution = "rtree"
    call = "Trimesh.triangles_tree.intersection_v"
    boxes_only = True

    def version(self) -> str:
        """Return the version."""
        imported("trimesh.triangles")
        return installed_version(self.distribution, "rtree")

    def load(self, a: Reals, b: Reals) -> Question:
        """Make the tree of B, and the boxes of A."""
        tree = imported("trimesh.triangles").bounds_tree(b)
        low, high = np.ascontiguousarray(a.min(1)), np.ascontiguousarray(a.max(1))

        def ask() -> Integers:
            found, counts = tree.intersection_v(low, high)
            return np.stack([np.repeat(np.arange(len(a)), counts.astype(np.int64)), found], 1)

        return Question(ask, Counted)
