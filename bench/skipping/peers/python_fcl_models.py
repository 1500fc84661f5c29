"""FCL by python-fcl: trees of OBBRSS volumes. It makes a Python object of each contact, within its time."""

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.skipping.peers.mesh_peer import Counted, Integers, Question, Reals

# FCL's own limit of contacts is 1.
_ALL = 1 << 31


class PythonFclModels:
    """python-fcl's collision of two BVHModels."""

    name = "FCL OBBRSS, python-fcl"
    distribution = "python-fcl"
    call = "fcl.collide(BVHModel, BVHModel)"
    boxes_only = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "fcl")

    def load(self, a: Reals, b: Reals) -> Question:
        """Make a model of each mesh."""
        fcl = imported("fcl")

        def model(facets: Reals) -> object:
            bvh = fcl.BVHModel()
            bvh.beginModel(3 * len(facets), len(facets))
            bvh.addSubModel(facets.reshape(-1, 3), np.arange(3 * len(facets)).reshape(-1, 3))
            bvh.endModel()
            return fcl.CollisionObject(bvh)

        first, second = model(a), model(b)

        def ask() -> Integers:
            request, result = fcl.CollisionRequest(num_max_contacts=_ALL), fcl.CollisionResult()
            fcl.collide(first, second, request, result)
            pairs = [(contact.b1, contact.b2) for contact in result.contacts]
            return np.array(pairs, np.int64).reshape(-1, 2)

        return Question(ask, Counted)
