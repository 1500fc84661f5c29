"""Other packages that tell whether triangles collide, or which facets of two meshes do."""

from triaxis.bench.peers.native import CGAL, FCL_TREES
from triaxis.bench.peers.wheels import EDGE_WHEELS, MESH_WHEELS, TRIANGLE_WHEELS

TRIANGLE_PEERS = (CGAL, *TRIANGLE_WHEELS)
EDGE_PEERS = EDGE_WHEELS
MESH_PEERS = (*FCL_TREES, *MESH_WHEELS)
