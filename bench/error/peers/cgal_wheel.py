"""CGAL by its wheel: exact predicates on doubles, filtered, behind SWIG's choice of overloads."""

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class CgalWheel:
    """CGAL's do_intersect, called from Python."""

    name = "CGAL, wheel"
    distribution = "cgal"
    call = "CGAL_Kernel.do_intersect(Triangle_3, Triangle_3)"
    batched = False

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, "CGAL.CGAL_Kernel")

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make CGAL's triangles."""
        kernel = imported("CGAL.CGAL_Kernel")

        def triangle(vertices: list[list[float]]) -> object:
            return kernel.Triangle_3(*(kernel.Point_3(*vertex) for vertex in vertices))

        pairs = [
            (triangle(x), triangle(y)) for x, y in zip(doubles(a).tolist(), doubles(b).tolist(), strict=True)
        ]
        return one_by_one(kernel.do_intersect, pairs)
