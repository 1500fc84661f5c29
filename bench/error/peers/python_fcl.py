"""FCL by python-fcl: a hierarchy of one triangle each, as it has no other way for triangles."""

from typing import Any

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class PythonFcl:
    """FCL's test of two OBB trees."""

    name = "python-fcl"
    distribution = "python-fcl"
    call = "fcl.collide(BVHModel, BVHModel)"
    batched = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "fcl")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a model of each triangle."""
        fcl = imported("fcl")
        face, request = np.array([[0, 1, 2]]), fcl.CollisionRequest()

        def model(triangle: Any) -> Any:
            bvh = fcl.BVHModel()
            bvh.beginModel(3, 1)
            bvh.addSubModel(triangle, face)
            bvh.endModel()
            return fcl.CollisionObject(bvh)

        pairs = [(model(x), model(y), request) for x, y in zip(doubles(a), doubles(b), strict=True)]
        return one_by_one(fcl.collide, pairs)
