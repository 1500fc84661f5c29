"""Open3D by its wheel: meshes of one triangle each, which it compares after their boxes."""

from typing import Any

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class Open3D:
    """Open3D's TriangleMesh.is_intersecting."""

    name = "Open3D"
    distribution = "open3d"
    call = "TriangleMesh.is_intersecting"
    batched = False
    _MODULE = "open3d"

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, self._MODULE)

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a mesh of each triangle."""
        open3d = imported(self._MODULE)
        vector, mesh = open3d.utility.Vector3dVector, open3d.geometry.TriangleMesh
        face = open3d.utility.Vector3iVector(np.array([[0, 1, 2]], np.int32))

        def meshes(triangles: Triangles) -> list[Any]:
            return [mesh(vector(triangle), face) for triangle in doubles(triangles)]

        return one_by_one(mesh.is_intersecting, list(zip(meshes(a), meshes(b), strict=True)))
