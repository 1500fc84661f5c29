"""The bulk checker's verdicts alone, several times as fast as with all the facts that coverage wants.

Native code (bulk_claims.cpp, compiled on first use) that asks the axes in their order until one separates: in
doubles where a bound on their rounding allows it, in exact arithmetic elsewhere.
"""

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import _as_coordinates, _as_margins
from triaxis.golden.native import native_library

_FOLDER = Path(__file__).parent

_Native = Callable[[int | None, int | None, int, int | None], None]


def load_claims(folder: Path = _FOLDER) -> _Native:
    """Return the native function, compiled where needed, from the sources in a folder."""
    sources, headers = [folder / "bulk_claims.cpp"], sorted(folder.glob("bulk_*.h"))
    function = native_library("bulk_claims", sources, headers).triaxis_claims
    function.argtypes = [ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p]
    function.restype = None
    return function


_native = cache(load_claims)


def bulk_claims(
    pairs: npt.NDArray[Any], margins: npt.NDArray[Any] | int, native: _Native | None = None
) -> npt.NDArray[np.int8]:
    """Return the lowest-numbered separating axis of each pair, NO_AXIS (-1) where the pair is near: (N,).

    Pairs and margins, in LSB, as `triaxis.golden.bulk.bulk_facts` takes them; exact for all of those. The
    axis of a clear pair is its certificate, which `triaxis.golden.claim_check` confirms. ``native``: another
    build, see `load_claims`.
    """
    coordinates = _as_coordinates(pairs)
    limits = _as_margins(margins, len(coordinates))
    claims = np.empty(len(coordinates), np.int8)
    (native or _native())(coordinates.ctypes.data, limits.ctypes.data, len(coordinates), claims.ctypes.data)
    return claims
