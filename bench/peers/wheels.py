"""Packages with wheels, of the lock file of peers: each called in the cheapest way it has from Python."""

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.peers.peer import Peer, Question, Reals, imported, installed_version

_VTK = "vtkmodules.vtkCommonDataModel"
_PREDICATES = "igl.predicates"
# FCL's own limit of contacts is 1.
_ALL_CONTACTS = 1 << 31


def one_by_one(call: Callable[..., Any], arguments: list[tuple[Any, ...]]) -> Question:
    """Return what calls a function on each pair's arguments; anything that is true is a collision."""
    return Question(lambda: np.array([call(*pair) for pair in arguments], dtype=object).astype(np.bool_))


def _each(make: Callable[[Reals], Any], a: Reals, b: Reals) -> list[tuple[Any, Any]]:
    """Return the objects that a package makes of each triangle, pair by pair."""
    return [(make(x), make(y)) for x, y in zip(a, b, strict=True)]


def _numbered(facets: Reals) -> tuple[Reals, npt.NDArray[np.int64]]:
    """Return the vertices (3 N, 3) of facets (N, 3, 3), and the numbers of those of each: (N, 3)."""
    return facets.reshape(-1, 3), np.arange(3 * len(facets)).reshape(-1, 3)


def _pairs(found: list[tuple[int, int]]) -> npt.NDArray[np.int64]:
    return np.array(found, np.int64).reshape(-1, 2)


def _cgal(a: Reals, b: Reals) -> Question:
    kernel = imported("CGAL.CGAL_Kernel")

    def triangle(vertices: Reals) -> object:
        return kernel.Triangle_3(*(kernel.Point_3(*vertex) for vertex in vertices.tolist()))

    return one_by_one(kernel.do_intersect, _each(triangle, a, b))


def _libigl(a: Reals, b: Reals) -> Question:
    test = imported("igl").tri_tri_overlap_test_3d
    return one_by_one(test, [tuple(pair) for pair in np.concatenate([a, b], 1)[:, :, None]])


def _libigl_predicates(a: Reals, b: Reals) -> Question:
    intersect = imported(_PREDICATES).triangle_triangle_intersect
    pairs: list[tuple[Any, ...]] = [tuple(pair) for pair in np.concatenate([a, b], 1)]
    return one_by_one(lambda *vertices: intersect(*vertices)[0], pairs)


def _vtk(a: Reals, b: Reals) -> Question:
    test = imported(_VTK).vtkTriangle.TrianglesIntersect
    return one_by_one(test, [tuple(map(tuple, pair)) for pair in np.concatenate([a, b], 1).tolist()])


def fcl_model(facets: Reals) -> Any:
    """Return a hierarchy over facets (N, 3, 3): python-fcl has no other way, for a single triangle either."""
    fcl = imported("fcl")
    bvh = fcl.BVHModel()
    bvh.beginModel(3 * len(facets), len(facets))
    bvh.addSubModel(*_numbered(facets))
    bvh.endModel()
    return fcl.CollisionObject(bvh)


def _python_fcl(a: Reals, b: Reals) -> Question:
    fcl = imported("fcl")
    request = fcl.CollisionRequest()
    pairs = _each(lambda triangle: fcl_model(triangle[None]), a, b)
    return one_by_one(fcl.collide, [(*pair, request) for pair in pairs])


def _python_fcl_meshes(a: Reals, b: Reals) -> Question:
    """It makes a Python object of each contact, within its time."""
    fcl = imported("fcl")
    first, second = fcl_model(a), fcl_model(b)

    def ask() -> npt.NDArray[np.int64]:
        request, result = fcl.CollisionRequest(num_max_contacts=_ALL_CONTACTS), fcl.CollisionResult()
        fcl.collide(first, second, request, result)
        return _pairs([(contact.b1, contact.b2) for contact in result.contacts])

    return Question(ask)


def _coal(a: Reals, b: Reals) -> Question:
    """Coal, formerly hpp-fcl: its triangle shape, which its GJK decides within a tolerance.

    Asked by the function object that it makes for a pair of shapes.
    """
    coal = imported("coal")
    here, request, result = coal.Transform3s(), coal.CollisionRequest(), coal.CollisionResult()
    request.enable_contact = False
    clear = result.clear
    shapes = _each(lambda triangle: coal.TriangleP(*triangle), a, b)

    # The function objects only point to the shapes, which this keeps.
    def collide(test: Any, _shapes: Any = shapes) -> Any:
        clear()
        return test(here, here, request, result)

    return one_by_one(collide, [(coal.ComputeCollision(*pair),) for pair in shapes])


def _open3d(a: Reals, b: Reals) -> Question:
    """Meshes of one triangle each, which it compares after their boxes."""
    open3d = imported("open3d")
    vector, mesh = open3d.utility.Vector3dVector, open3d.geometry.TriangleMesh
    face = open3d.utility.Vector3iVector(np.array([[0, 1, 2]], np.int32))
    return one_by_one(mesh.is_intersecting, _each(lambda triangle: mesh(vector(triangle), face), a, b))


def _edges(triangle: Reals) -> tuple[Reals, Reals]:
    """Return where the edges of a triangle (3, 3) begin and end: (3, 3) each."""
    return triangle, np.roll(triangle, -1, 0)


def _ipctk(a: Reals, b: Reals) -> Question:
    """Each edge is asked both ways: the answers differ where it only just touches."""
    test = imported("ipctk").is_edge_intersecting_triangle

    def meet(one: Reals, other: Reals) -> bool:
        for edges, face in ((one, other), (other, one)):
            for start, end in zip(*_edges(edges), strict=True):
                if test(start, end, *face) or test(end, start, *face):
                    return True
        return False

    return one_by_one(meet, list(zip(a, b, strict=True)))


def _embree(a: Reals, b: Reals) -> Question:
    """A scene of each triangle, in float32; edges of the other are rays that end with them."""
    embree, mesh = imported("embreex.rtcore_scene").EmbreeScene, imported("embreex.mesh_construction")

    def scene(triangle: Reals) -> Any:
        made = embree()
        mesh.TriangleMesh(made, np.ascontiguousarray(triangle[None], np.float32))
        return made

    def rays(triangle: Reals) -> tuple[Any, Any]:
        starts, ends = _edges(triangle)
        return np.ascontiguousarray(starts, np.float32), np.ascontiguousarray(ends - starts, np.float32)

    def meet(scene_a: Any, scene_b: Any, rays_a: Any, rays_b: Any) -> bool:
        asked = ((scene_b, rays_a), (scene_a, rays_b))
        return any((hit.run(*edges, dists=np.ones(3, np.float32)) >= 0).any() for hit, edges in asked)

    pairs = zip(_each(scene, a, b), _each(rays, a, b), strict=True)
    return one_by_one(meet, [(*scenes, *edges) for scenes, edges in pairs])


def _parry(a: Reals, b: Reals) -> Question:
    """Parry by ncollpyde: the edges of each triangle as segments, which meet the other one or not."""
    volume, face = imported("ncollpyde").Volume, np.array([[0, 1, 2]], np.uint32)

    def made(triangle: Reals) -> Any:
        return volume(triangle, face, validate=False, threads=False, n_rays=0)

    def meet(first: Any, second: Any, edges_a: Any, edges_b: Any) -> bool:
        asked = ((second, edges_a), (first, edges_b))
        return any(len(surface.intersections(*edges, threads=False)[0]) > 0 for surface, edges in asked)

    pairs = zip(_each(made, a, b), _each(_edges, a, b), strict=True)
    return one_by_one(meet, [(*volumes, *edges) for volumes, edges in pairs])


def _trimesh_manager(name: str, facets: Reals) -> Any:
    """Return a manager of a mesh of facets (N, 3, 3), which hands it to python-fcl."""
    made = imported("trimesh.collision").CollisionManager()
    made.add_object(name, imported("trimesh").Trimesh(*_numbered(facets), process=False))
    return made


def _trimesh(a: Reals, b: Reals) -> Question:
    ask = imported("trimesh.collision").CollisionManager.in_collision_other
    return one_by_one(ask, _each(lambda triangle: _trimesh_manager("", triangle[None]), a, b))


def _trimesh_meshes(a: Reals, b: Reals) -> Question:
    # Its own limit is 100,000.
    imported("trimesh.collision").COLLISION_PER_PAIR_CAP = _ALL_CONTACTS
    first, second = _trimesh_manager("a", a), _trimesh_manager("b", b)

    def ask() -> npt.NDArray[np.int64]:
        _, contacts = first.in_collision_other(second, return_data=True)
        return _pairs([(contact.index("a"), contact.index("b")) for contact in contacts])

    return Question(ask)


def _rtree_boxes(a: Reals, b: Reals) -> Question:
    """The tree that trimesh makes of a mesh's facets, of package rtree, asked about the other's boxes."""
    tree = imported("trimesh.triangles").bounds_tree(b)
    low, high = np.ascontiguousarray(a.min(1)), np.ascontiguousarray(a.max(1))

    def ask() -> npt.NDArray[np.int64]:
        found, counts = tree.intersection_v(low, high)
        return np.stack([np.repeat(np.arange(len(a)), counts.astype(np.int64)), found], 1)

    return Question(ask)


def _of(distribution: str, *modules: str) -> Callable[[], str]:
    return partial(installed_version, distribution, *modules)


# trimesh's managers need python-fcl.
_FCL, _TRIMESH = _of("python-fcl", "fcl"), _of("trimesh", "fcl", "trimesh.collision")

TRIANGLE_WHEELS = (
    Peer("CGAL, wheel", "cgal", "CGAL_Kernel.do_intersect(Triangle_3, Triangle_3)",
                 _of("cgal", "CGAL.CGAL_Kernel"), _cgal),
    Peer("libigl", "libigl", "igl.tri_tri_overlap_test_3d", _of("libigl", "igl"), _libigl),
    Peer("libigl, predicates", "libigl", "igl.predicates.triangle_triangle_intersect",
                 _of("libigl", _PREDICATES), _libigl_predicates),
    Peer("VTK", "vtk", "vtkTriangle.TrianglesIntersect", _of("vtk", _VTK), _vtk),
    Peer("python-fcl", "python-fcl", "fcl.collide(BVHModel, BVHModel)", _FCL, _python_fcl),
    Peer("coal", "coal", "coal.ComputeCollision(TriangleP, TriangleP)(..)",
                 _of("coal", "coal"), _coal),
    Peer("Open3D", "open3d", "TriangleMesh.is_intersecting", _of("open3d", "open3d"), _open3d),
    Peer("trimesh", "trimesh", "CollisionManager.in_collision_other", _TRIMESH, _trimesh),
)  # fmt: skip

# These have no test of two triangles: the edges of each are asked against the other one.
EDGE_WHEELS = (
    Peer("IPC toolkit", "ipctk", "is_edge_intersecting_triangle, of six edges both ways",
         _of("ipctk", "ipctk"), _ipctk),
    Peer("Embree", "embreex", "EmbreeScene.run, edges as rays",
         _of("embreex", "embreex.mesh_construction"), _embree),
    Peer("Parry, ncollpyde", "ncollpyde", "Volume.intersections of the edges",
         _of("ncollpyde", "ncollpyde"), _parry),
)  # fmt: skip

MESH_WHEELS = (
    Peer("FCL OBBRSS, python-fcl", "python-fcl", "fcl.collide(BVHModel, BVHModel)",
             _FCL, _python_fcl_meshes),
    Peer("trimesh CollisionManager", "trimesh", "CollisionManager.in_collision_other(return_data=True)",
             _TRIMESH, _trimesh_meshes),
    Peer("trimesh triangles_tree (rtree)", "rtree", "Trimesh.triangles_tree.intersection_v",
             _of("rtree", "trimesh.triangles"), _rtree_boxes, boxes_only=True),
)  # fmt: skip
