"""CGAL and FCL by their C++ headers, in loops compiled here: no Python in between, and tests are counted.

Of FCL's trees, OBB is that of S. Gottschalk, M. C. Lin, D. Manocha, OBBTree: A Hierarchical Structure for
Rapid Interference Detection, SIGGRAPH 1996; OBBRSS is what python-fcl builds; AABB has axis-parallel boxes.
How often they compare volumes and triangles no Python package of FCL tells.
"""

import ctypes
import shutil
import subprocess
from collections.abc import Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.harness import FOLDER
from triaxis.bench.peers.peer import Peer, PeerAbsentError, Question, Reals
from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, run_tool

_FLAGS = ("-O3", "-DNDEBUG", "-fPIC", "-shared", "-w")
# Behind what pkg-config says, which is older.
_STANDARD = "-std=c++17"
# Its interval arithmetic rests on the rounding mode.
_CGAL_FLAGS = ("-march=native", "-frounding-math")
_CGAL_PROBE = "#include <CGAL/version.h>\nCGAL_VERSION_NR\n"
_INSTALL_CGAL = "install libcgal-dev (Debian), or set CPLUS_INCLUDE_PATH"
_INSTALL_FCL = "install libfcl-dev and pkg-config (Debian), or set PKG_CONFIG_PATH"
_VOLUMES = ("OBB", "OBBRSS", "AABB")
_MOST_PAIRS = 1 << 26
_POINTER, _LONG, _KIND = ctypes.c_void_p, ctypes.c_int64, ctypes.c_int


def _compiled(package: str, version: str, flags: Sequence[str], libraries: Sequence[str]) -> Any:
    """Return the loop of a package, built where needed; raise PeerAbsentError where that fails."""
    name = package.lower()
    source, file = Path(__file__).with_name(f"{name}.cpp"), f"{name}.so"
    options = [*_FLAGS, *flags, _STANDARD]
    settings = (target(cxx()), version, *options, *libraries)

    def make(partial_: Path) -> None:
        command = [cxx(), *options, str(source), "-o", str(partial_ / file), *libraries]
        run_tool(command, partial_, f"{package}'s loop")

    try:
        library = ctypes.CDLL(str(built(FOLDER / "native" / name, [source], settings, make) / file))
    except (InputError, OSError) as error:
        raise PeerAbsentError(f"{package}'s headers: found, but {error}") from error
    library.triaxis_load.restype, library.triaxis_load.argtypes = _POINTER, [_KIND, _POINTER, _LONG]
    library.triaxis_free.restype, library.triaxis_free.argtypes = None, [_KIND, _POINTER]
    library.triaxis_ask.restype = _LONG
    library.triaxis_ask.argtypes = [_KIND, _POINTER, _POINTER, _POINTER, _LONG, _POINTER]
    return library


class _Loaded:
    """Two sets of triangles, (N, 3, 3) and (M, 3, 3), as a library holds them: freed with this."""

    def __init__(self, library: Any, kind: int, a: Reals, b: Reals) -> None:
        self._library, self._kind = library, kind
        made = [np.ascontiguousarray(triangles, np.float64) for triangles in (a, b)]
        self._held = [library.triaxis_load(kind, each.ctypes.data, len(each)) for each in made]

    def __del__(self) -> None:
        for address in self._held:
            self._library.triaxis_free(self._kind, address)

    def ask(self, answer: npt.NDArray[np.int32], tests: npt.NDArray[np.int64] | None = None) -> int:
        """Fill ``answer`` as far as it goes; return how many answers there are."""
        counted = None if tests is None else tests.ctypes.data
        return self._library.triaxis_ask(self._kind, *self._held, answer.ctypes.data, len(answer), counted)


@cache
def _cgal() -> Any:
    """Return the compiled loop; raise PeerAbsentError where headers or libraries are missing."""
    probe = subprocess.run(
        [cxx(), "-E", "-P", "-x", "c++", "-"], input=_CGAL_PROBE, capture_output=True, text=True, check=False
    )
    if probe.returncode:
        raise PeerAbsentError(f"CGAL's headers: not found: {_INSTALL_CGAL}")
    library = _compiled("CGAL", probe.stdout, _CGAL_FLAGS, ("-lgmp", "-lmpfr"))
    library.triaxis_version.restype = _LONG
    return library


def _cgal_version() -> str:
    # A dot, two digits each for major, minor and patch, and four more: 1050511000 is 5.5.1.
    digits = f"{_cgal().triaxis_version():d}"
    return f"{int(digits[1:3])}.{int(digits[3:5])}.{int(digits[5:6])}"


def _cgal_pairs(a: Reals, b: Reals) -> Question:
    loaded = _Loaded(_cgal(), 0, a, b)

    def ask() -> npt.NDArray[np.bool_]:
        intersect = np.empty(len(a), np.int32)
        loaded.ask(intersect)
        return intersect.astype(np.bool_)

    return Question(ask)


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
    return _compiled("FCL", _fcl_asked("--modversion"), flags, libraries)


def _fcl_version() -> str:
    _fcl()
    return _fcl_asked("--modversion").strip()


def _fcl_meshes(kind: int, a: Reals, b: Reals) -> Question:
    """Return FCL's collision of two trees of bounding volumes of a kind, without contact points."""
    trees = _Loaded(_fcl(), kind, a, b)

    def ask() -> npt.NDArray[np.int64]:
        # Room for all, so that it is asked once: memory that nobody writes to is not taken.
        pairs = np.empty((_MOST_PAIRS, 2), np.int32)
        found = trees.ask(pairs)
        if not 0 <= found <= _MOST_PAIRS:
            raise InputError(f"FCL {_VOLUMES[kind]}: {found} pairs: must be 0..{_MOST_PAIRS}")
        return pairs[:found].astype(np.int64)

    def count() -> tuple[int, int]:
        tests = np.zeros(2, np.int64)
        trees.ask(np.empty((0, 2), np.int32), tests)
        return int(tests[0]), int(tests[1])

    return Question(ask, count)


CGAL = Peer(
    "CGAL, C++", "libcgal-dev", "CGAL::do_intersect(Triangle_3, Triangle_3)",
    _cgal_version, _cgal_pairs, batched=True,
)  # fmt: skip
FCL_TREES = tuple(
    Peer(
        f"FCL {volume}", "libfcl-dev", f"fcl::detail::collide(BVHModel<{volume}>)",
        _fcl_version, partial(_fcl_meshes, kind),
    )
    for kind, volume in enumerate(_VOLUMES)
)  # fmt: skip
