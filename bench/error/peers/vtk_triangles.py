"""VTK by its wheel: vtkTriangle's test after Guigue and Devillers, in doubles."""

import numpy as np

from triaxis.bench.error.peers.installed import imported, installed_version
from triaxis.bench.error.peers.peer import Ask, doubles, one_by_one
from triaxis.bench.error.truth import Triangles


class Vtk:
    """VTK's TrianglesIntersect."""

    name = "VTK"
    distribution = "vtk"
    call = "vtkTriangle.TrianglesIntersect"
    batched = False
    _MODULE = "vtkmodules.vtkCommonDataModel"

    def version(self) -> str:
        """Return the version."""
        return installed_version(self.distribution, self._MODULE)

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make a tuple of each vertex."""
        test = imported(self._MODULE).vtkTriangle.TrianglesIntersect
        pairs = np.concatenate([doubles(a), doubles(b)], 1).tolist()
        return one_by_one(test, [tuple(tuple(vertex) for vertex in pair) for pair in pairs])
