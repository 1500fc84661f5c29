"""trimesh: its collision managers, which hand meshes to python-fcl; it has no test of its own."""

from typing import Any

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class Trimesh:
    """trimesh's CollisionManager.in_collision_other."""

    name = "trimesh"
    distribution = "trimesh"
    call = "CollisionManager.in_collision_other"
    batched = False

    def version(self) -> str:
        """Return the version."""
        # Its managers need python-fcl.
        imported("fcl")
        return installed_version(self.distribution, "trimesh.collision")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a manager of each triangle."""
        trimesh, collision = imported("trimesh"), imported("trimesh.collision")
        face = np.array([[0, 1, 2]])

        def manager(triangle: Any) -> Any:
            made = collision.CollisionManager()
            made.add_object("", trimesh.Trimesh(triangle, face, process=False))
            return made

        pairs = [(manager(x), manager(y)) for x, y in zip(doubles(a), doubles(b), strict=True)]
        return one_by_one(collision.CollisionManager.in_collision_other, pairs)
