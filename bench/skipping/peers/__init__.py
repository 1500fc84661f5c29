"""Other packages' ways to find all colliding facets of two meshes: optional, each behind one module."""

from triaxis.bench.skipping.peers.fcl_trees import FclTree
from triaxis.bench.skipping.peers.mesh_peer import MeshPeer
from triaxis.bench.skipping.peers.python_fcl_models import PythonFclModels
from triaxis.bench.skipping.peers.rtree_boxes import RtreeBoxes
from triaxis.bench.skipping.peers.trimesh_managers import TrimeshManagers

MESH_PEERS: tuple[MeshPeer, ...] = (
    FclTree("OBB"),
    FclTree("OBBRSS"),
    FclTree("AABB"),
    PythonFclModels(),
    TrimeshManagers(),
    RtreeBoxes(),
)
