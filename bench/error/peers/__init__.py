"""Other packages that tell whether two triangles collide: optional, each behind one module."""

from triaxis.verif.bench.peers.cgal_native import CgalNative
from triaxis.verif.bench.peers.cgal_wheel import CgalWheel
from triaxis.verif.bench.peers.coal_triangles import Coal
from triaxis.verif.bench.peers.libigl_triangles import Libigl, LibiglPredicates
from triaxis.verif.bench.peers.open3d_meshes import Open3D
from triaxis.verif.bench.peers.peer import Peer
from triaxis.verif.bench.peers.python_fcl import PythonFcl
from triaxis.verif.bench.peers.trimesh_managers import Trimesh
from triaxis.verif.bench.peers.vtk_triangles import Vtk

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
