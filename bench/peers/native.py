"""CGAL and FCL by their C++ headers, in loops compiled here: no Python in between, and tests are counted.

Of FCL's trees, OBB is that of S. Gottschalk, M. C. Lin, D. Manocha, OBBTree: A Hierarchical Structure for
Rapid Interference Detection, SIGGRAPH 1996; OBBRSS is what python-fcl builds; AABB has axis-parallel boxes.
How often they compare volumes and triangles no Python package of FCL tells.
"""

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.harness import FOLDER
from triaxis.bench.peers.peer import (
    Ask,
    Counted,
    Integers,
    MeshPeer,
    PeerAbsentError,
    Question,
    Reals,
    Singles,
    TrianglePeer,
)
from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool

_FLAGS = ("-O3", "-DNDEBUG", "-fPIC", "-shared", "-w")
_STANDARD = "-std=c++17"
# Its interval arithmetic rests on the rounding mode.
_CGAL_FLAGS = ("-march=native", "-frounding-math")
_CGAL_PROBE = "#include <CGAL/version.h>\nCGAL_VERSION_NR\n"
_INSTALL_CGAL = "install libcgal-dev (Debian), or set CPLUS_INCLUDE_PATH"
_INSTALL_FCL = "install libfcl-dev and pkg-config (Debian), or set PKG_CONFIG_PATH"
_VOLUMES = ("OBB", "OBBRSS", "AABB")
_POINTER, _LONG, _KIND = ctypes.c_void_p, ctypes.c_int64, ctypes.c_int


def _compiled(package: str, version: str, flags: Sequence[str], libraries: Sequence[str]) -> ctypes.CDLL:
    """Return the loop of a package, built where needed; raise PeerAbsentError where that fails."""
    name = package.lower()
    source, file = Path(__file__).with_name(f"{name}.cpp"), f"{name}.so"
    options = [*_FLAGS, *flags, _STANDARD]
    key = content_hash([source], target(cxx()), version, *options, *libraries)

    def make(partial_: Path) -> None:
        command = [cxx(), *options, str(source), "-o", str(partial_ / file), *libraries]
        run_tool(command, partial_, f"{package}'s loop")

    try:
        return ctypes.CDLL(str(built(FOLDER / "native" / f"{name}-{key[:12]}", make) / file))
    except (InputError, OSError) as error:
        raise PeerAbsentError(f"{package}'s headers: found, but {error}") from error


class _Held:
    """An object of a package's, freed with this."""

    def __init__(self, address: int, free: Callable[[int], object]) -> None:
        self.address, self._free = address, free

    def __del__(self) -> None:
        self._free(self.address)


@cache
def _cgal() -> Any:
    """Return the compiled loop; raise PeerAbsentError where headers or libraries are missing."""
    probe = subprocess.run(
        [cxx(), "-E", "-P", "-x", "c++", "-"], input=_CGAL_PROBE, capture_output=True, text=True, check=False
    )
    if probe.returncode:
        raise PeerAbsentError(f"CGAL's headers: not found: {_INSTALL_CGAL}")
    library = _compiled("CGAL", probe.stdout, _CGAL_FLAGS, ("-lgmp", "-lmpfr"))
    library.triaxis_cgal_version.restype = _LONG
    library.triaxis_cgal_load.restype = _POINTER
    library.triaxis_cgal_load.argtypes = [_POINTER, _LONG]
    library.triaxis_cgal_free.restype = library.triaxis_cgal_run.restype = None
    library.triaxis_cgal_free.argtypes = [_POINTER]
    library.triaxis_cgal_run.argtypes = [_POINTER, _POINTER, _POINTER]
    return library


def _cgal_version() -> str:
    # A dot, two digits each for major, minor and patch, and four more: 1050511000 is 5.5.1.
    digits = f"{_cgal().triaxis_cgal_version():d}"
    return f"{int(digits[1:3])}.{int(digits[3:5])}.{int(digits[5:6])}"


def _cgal_pairs(a: Singles, b: Singles) -> Ask:
    library = _cgal()
    held: list[_Held] = []
    for triangles in (a, b):
        floats = np.ascontiguousarray(triangles, np.float32)
        address = library.triaxis_cgal_load(floats.ctypes.data, len(floats))
        held.append(_Held(address, library.triaxis_cgal_free))

    def ask() -> Any:
        intersect = np.empty(len(a), np.uint8)
        library.triaxis_cgal_run(held[0].address, held[1].address, intersect.ctypes.data)
        return intersect.astype(np.bool_)

    return ask


def _fcl_asked(*options: str) -> str:
    """Return what pkg-config says of FCL; raise PeerAbsentError where there is none."""
    if shutil.which("pkg-config") is None:
        raise PeerAbsentError(f"pkg-config: not found: {_INSTALL_FCL}")
    answer = subprocess.run(["pkg-config", *options, "fcl"], capture_output=True, text=True, check=False)
    if answer.returncode:
        raise PeerAbsentError(f"FCL's headers: not found: {_INSTALL_FCL}")
    return answer.stdout


@cache
def _fcl() -> Any:
    """Return the compiled calls; raise PeerAbsentError where headers or libraries are missing."""
    # Not for this processor: FCL is compiled for all, and its types are aligned by what they are compiled
    # for.
    flags, libraries = _fcl_asked("--cflags").split(), _fcl_asked("--libs").split()
    library = _compiled("FCL", _fcl_asked("--modversion"), flags, libraries)
    library.triaxis_fcl_load.restype = _POINTER
    library.triaxis_fcl_load.argtypes = [_KIND, _POINTER, _LONG]
    library.triaxis_fcl_free.restype = None
    library.triaxis_fcl_free.argtypes = [_KIND, _POINTER]
    library.triaxis_fcl_collide.restype = _LONG
    library.triaxis_fcl_collide.argtypes = [_KIND, _POINTER, _POINTER, _POINTER, _LONG, _POINTER]
    return library


def _fcl_version() -> str:
    _fcl()
    return _fcl_asked("--modversion").strip()


def _fcl_meshes(kind: int, a: Reals, b: Reals) -> Question:
    """Return FCL's collision of two trees of bounding volumes of a kind, without contact points."""
    library = _fcl()
    trees: list[_Held] = []
    for facets in (a, b):
        vertices = np.ascontiguousarray(facets)
        address = library.triaxis_fcl_load(kind, vertices.ctypes.data, len(vertices))
        trees.append(_Held(address, partial(library.triaxis_fcl_free, kind)))
    collide = partial(library.triaxis_fcl_collide, kind)
    # As many as there were the last time: FCL's own list is the result, the copy is for us.
    room = 1 << 10

    def ask() -> Integers:
        nonlocal room
        pairs = np.empty((room, 2), np.int32)
        found = collide(trees[0].address, trees[1].address, pairs.ctypes.data, room, None)
        if found > room:
            room = found
            return ask()
        return pairs[:found].astype(np.int64)

    def count() -> Counted:
        tests = np.zeros(2, np.int64)
        collide(trees[0].address, trees[1].address, None, 0, tests.ctypes.data)
        return Counted(int(tests[0]), int(tests[1]))

    return Question(ask, count)


CGAL = TrianglePeer(
    "CGAL, C++", "libcgal-dev", "CGAL::do_intersect(Triangle_3, Triangle_3)",
    _cgal_version, _cgal_pairs, batched=True,
)  # fmt: skip
FCL_TREES = tuple(
    MeshPeer(
        f"FCL {volume}", "libfcl-dev", f"fcl::detail::collide(BVHModel<{volume}>)",
        _fcl_version, partial(_fcl_meshes, kind),
    )
    for kind, volume in enumerate(_VOLUMES)
)  # fmt: skip
