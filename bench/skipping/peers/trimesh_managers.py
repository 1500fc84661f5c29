"""trimesh: its collision managers, which hand meshes to python-fcl."""

from typing import Any

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.skipping.peers.mesh_peer import Counted, Integers, Question, Reals


class TrimeshManagers:
    """trimesh's CollisionManager.in_collision_other, with the data of all contacts."""

    name = "trimesh CollisionManager"
    distribution = "trimesh"
    call = "CollisionManager.in_collision_other(return_data=True)"
    boxes_only = False

    def version(self) -> str:
        """Return the version."""
        # Its managers need python-fcl.
        imported("fcl")
        return installed_version(self.distribution, "trimesh.collision")

    def load(self, a: Reals, b: Reals) -> Question:
        """Make a manager of each mesh."""
        trimesh, collision = imported("trimesh"), imported("trimesh.collision")

        def manager(name: str, facets: Reals) -> Any:
            made = collision.CollisionManager()
            faces = np.arange(3 * len(facets)).reshape(-1, 3)
            made.add_object(name, trimesh.Trimesh(facets.reshape(-1, 3), faces, process=False))
            return made

        first, second = manager("a", a), manager("b", b)

        def ask() -> Integers:
            _, contacts = first.in_collision_other(second, return_data=True)
            pairs = [(contact.index("a"), contact.index("b")) for contact in contacts]
            return np.array(pairs, np.int64).reshape(-1, 2)

        return Question(ask, Counted)
