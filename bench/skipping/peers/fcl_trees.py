"""FCL by its headers (Debian: libfcl-dev), which count tests: what no Python package of it tells.

OBB is the tree of S. Gottschalk, M. C. Lin, D. Manocha, OBBTree: A Hierarchical Structure for Rapid
Interference Detection, SIGGRAPH 1996; OBBRSS is what python-fcl builds; AABB has axis-parallel boxes.
"""

import ctypes
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.error.peers.peer import PeerAbsentError
from triaxis.bench.skipping.peers.mesh_peer import Counted, Integers, Question, Reals
from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.paths import BUILD

_SOURCE = Path(__file__).with_suffix(".cpp")
# Not for this processor: FCL is compiled for all, and its types are aligned by what they are compiled for.
_FLAGS = ("-O3", "-DNDEBUG", "-fPIC", "-shared", "-w")
_STANDARD = "-std=c++17"
_KINDS = ("OBB", "OBBRSS", "AABB")
_INSTALL = "install libfcl-dev and pkg-config (Debian), or set PKG_CONFIG_PATH"


class FclTree:
    """FCL's collision of two trees of bounding volumes of a kind, without contact points."""

    distribution = "libfcl-dev"
    boxes_only = False

    def __init__(self, kind: str) -> None:
        """Take the kind of volume: OBB, OBBRSS or AABB."""
        self.name = f"FCL {kind}"
        self.call = f"fcl::detail::collide(BVHModel<{kind}>)"
        self._kind = _KINDS.index(kind)

    def version(self) -> str:
        """Return the version."""
        _library()
        return _asked("--modversion").strip()

    def load(self, a: Reals, b: Reals) -> Question:
        """Build both trees."""
        library = _library()
        trees = [_Tree(library, self._kind, facets) for facets in (a, b)]

        def collide(pairs: npt.NDArray[np.int32] | None, counts: int | None) -> int:
            room, place = (0, None) if pairs is None else (len(pairs), pairs.ctypes.data)
            return library.triaxis_fcl_collide(
                self._kind, trees[0].address, trees[1].address, place, room, counts
            )

        # As many as there were the last time: FCL's own list is the result, the copy is for us.
        room = 1 << 10

        def ask() -> Integers:
            nonlocal room
            pairs = np.empty((room, 2), np.int32)
            found = collide(pairs, None)
            if found > room:
                room = found
                return ask()
            return pairs[:found].astype(np.int64)

        def count() -> Counted:
            tests = np.zeros(2, np.int64)
            collide(None, tests.ctypes.data)
            return Counted(int(tests[0]), int(tests[1]))

        return Question(ask, count)


class _Tree:
    """A tree of FCL's, freed with this."""

    def __init__(self, library: Any, kind: int, facets: Reals) -> None:
        self._free, self._kind = library.triaxis_fcl_free, kind
        vertices = np.ascontiguousarray(facets)
        self.address = library.triaxis_fcl_load(kind, vertices.ctypes.data, len(vertices))

    def __del__(self) -> None:
        self._free(self._kind, self.address)


def _asked(*options: str) -> str:
    """Return what pkg-config says of FCL; raise PeerAbsentError where there is none."""
    if shutil.which("pkg-config") is None:
        raise PeerAbsentError(f"pkg-config: not found: {_INSTALL}")
    answer = subprocess.run(["pkg-config", *options, "fcl"], capture_output=True, text=True, check=False)
    if answer.returncode:
        raise PeerAbsentError(f"FCL's headers: not found: {_INSTALL}")
    return answer.stdout


@cache
def _library() -> Any:
    """Return the compiled calls; raise PeerAbsentError where headers or libraries are missing."""
    flags, libraries = _asked("--cflags").split(), _asked("--libs").split()
    options = [*_FLAGS, *flags, _STANDARD]
    key = content_hash([_SOURCE], target(cxx()), _asked("--modversion"), *options, *libraries)
    folder, file = BUILD / "bench" / "native" / f"fcl-{key[:12]}", "fcl.so"

    def make(partial: Path) -> None:
        command = [cxx(), *options, str(_SOURCE), "-o", str(partial / file), *libraries]
        run_tool(command, partial, "FCL's trees")

    try:
        library = ctypes.CDLL(str(built(folder, make) / file))
    except (InputError, OSError) as error:
        raise PeerAbsentError(f"FCL's headers: found, but {error}") from error
    pointer = ctypes.c_void_p
    library.triaxis_fcl_load.restype = pointer
    library.triaxis_fcl_load.argtypes = [ctypes.c_int, pointer, ctypes.c_int64]
    library.triaxis_fcl_free.restype = None
    library.triaxis_fcl_free.argtypes = [ctypes.c_int, pointer]
    library.triaxis_fcl_collide.restype = ctypes.c_int64
    library.triaxis_fcl_collide.argtypes = [ctypes.c_int, *(pointer,) * 3, ctypes.c_int64, pointer]
    return library
