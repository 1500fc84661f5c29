"""Coal, formerly hpp-fcl: its triangle shape, which its GJK decides within a tolerance."""

from typing import Any

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class Coal:
    """Coal's test of two triangle shapes, by the function object that it makes for a pair of shapes."""

    name = "coal"
    distribution = "coal"
    call = "coal.ComputeCollision(TriangleP, TriangleP)(..)"
    batched = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "coal")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a function object of each pair."""
        coal = imported("coal")
        here, request, result = coal.Transform3s(), coal.CollisionRequest(), coal.CollisionResult()
        request.enable_contact = False
        clear = result.clear

        def collide(test: Any) -> Any:
            clear()
            return test(here, here, request, result)

        shapes = [
            tuple(coal.TriangleP(*triangle) for triangle in pair)
            for pair in zip(doubles(a), doubles(b), strict=True)
        ]
        ask = one_by_one(collide, [(coal.ComputeCollision(*pair),) for pair in shapes])
        # The function objects point to the shapes.
        ask.__dict__["shapes"] = shapes
        return ask
