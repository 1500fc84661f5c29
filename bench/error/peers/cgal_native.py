"""CGAL by its headers (Debian: libcgal-dev), in a loop in C++ that is compiled here."""

import ctypes
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.bench.error.peers.peer import Ask, PeerAbsentError
from triaxis.bench.error.truth import Triangles
from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.paths import BUILD

_SOURCE = Path(__file__).with_name("cgal_native.cpp")
# Its interval arithmetic rests on the rounding mode.
_FLAGS = ("-O3", "-march=native", "-DNDEBUG", "-frounding-math", "-std=c++17", "-fPIC", "-shared", "-w")
_LIBRARIES = ("-lgmp", "-lmpfr")
_PROBE = "#include <CGAL/version.h>\nCGAL_VERSION_NR\n"


class CgalNative:
    """CGAL's do_intersect, called from C++."""

    name = "CGAL, C++"
    distribution = "libcgal-dev"
    call = "CGAL::do_intersect(Triangle_3, Triangle_3)"
    batched = True

    def version(self) -> str:
        """Return the version that the headers tell."""
        # A dot, two digits each for major, minor and patch, and four more: 1050511000 is 5.5.1.
        digits = f"{_library().triaxis_cgal_version():d}"
        return f"{int(digits[1:3])}.{int(digits[3:5])}.{int(digits[5:6])}"

    def load(self, a: Triangles, b: Triangles) -> Ask:
        """Make CGAL's triangles."""
        library = _library()
        held = [_Held(library, triangles) for triangles in (a, b)]

        def ask() -> Any:
            intersect = np.empty(len(a), np.uint8)
            library.triaxis_cgal_run(held[0].address, held[1].address, intersect.ctypes.data)
            return intersect.astype(np.bool_)

        return ask


class _Held:
    """Triangles in CGAL's form, freed with this."""

    def __init__(self, library: Any, triangles: Triangles) -> None:
        floats = np.ascontiguousarray(triangles, np.float32)
        self._free = library.triaxis_cgal_free
        self.address = library.triaxis_cgal_load(floats.ctypes.data, len(floats))

    def __del__(self) -> None:
        self._free(self.address)


@cache
def _library() -> Any:
    """Return the compiled loop; raise PeerAbsentError where headers or libraries are missing."""
    probe = subprocess.run(
        [cxx(), "-E", "-P", "-x", "c++", "-"], input=_PROBE, capture_output=True, text=True, check=False
    )
    if probe.returncode:
        raise PeerAbsentError(
            "CGAL's headers: not found: install libcgal-dev (Debian), or set CPLUS_INCLUDE_PATH"
        )
    key = content_hash([_SOURCE], target(cxx()), probe.stdout, *_FLAGS)
    folder, file = BUILD / "bench" / "native" / f"cgal-{key[:12]}", "cgal.so"

    def make(partial: Path) -> None:
        run_tool(
            [cxx(), *_FLAGS, str(_SOURCE), "-o", str(partial / file), *_LIBRARIES], partial, "CGAL's loop"
        )

    try:
        library = ctypes.CDLL(str(built(folder, make) / file))
    except (InputError, OSError) as error:
        raise PeerAbsentError(f"CGAL's headers: found, but {error}") from error
    pointer = ctypes.c_void_p
    library.triaxis_cgal_version.restype = ctypes.c_int64
    library.triaxis_cgal_load.restype = pointer
    library.triaxis_cgal_load.argtypes = [pointer, ctypes.c_int64]
    library.triaxis_cgal_free.restype = library.triaxis_cgal_run.restype = None
    library.triaxis_cgal_free.argtypes = [pointer]
    library.triaxis_cgal_run.argtypes = [pointer, pointer, pointer]
    return library
