"""Other packages that tell whether two triangles collide: optional, each behind one module."""

from triaxis.bench.error.peers.cgal_native import CgalNative
from triaxis.bench.error.peers.cgal_wheel import CgalWheel
from triaxis.bench.error.peers.coal_triangles import Coal
from triaxis.bench.error.peers.libigl_triangles import Libigl, LibiglPredicates
from triaxis.bench.error.peers.open3d_meshes import Open3D
from triaxis.bench.error.peers.peer import Peer
from triaxis.bench.error.peers.python_fcl import PythonFcl
from triaxis.bench.error.peers.trimesh_managers import Trimesh
from triaxis.bench.error.peers.vtk_triangles import Vtk

PEERS: tuple[Peer, ...] = (
    CgalNative(),
    CgalWheel(),
    Libigl(),
    LibiglPredicates(),
    Vtk(),
    PythonFcl(),
    Coal(),
    Open3D(),
    Trimesh(),
)
