"""The bulk checker: facts of many pairs, or their claims alone, exactly, at the speed of a simulation.

Native code, compiled on first use, that decides the 32 axes by their definition, for all coordinates of 32
bits and margins below 2^32. It runs without Python's lock, so a thread can check one burst of pairs while the
simulation works at the next. For claims alone (bulk_claims.cpp) it asks the axes in their order until one
separates: in doubles where a bound on their rounding allows it, in exact arithmetic elsewhere; several times
as fast as with all the facts that coverage wants (bulk.cpp).
"""

import ctypes
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.golden.facts import Facts
from triaxis.golden.native import native_function
from triaxis.golden.pairs import VERDICT, Verdicts, native_margins, native_pairs

_FOLDER = Path(__file__).parent

# Pairs between two calls of ``progress``.
_CHUNK = 1 << 16

# The types of the fields of Facts, in the order of FactArrays in bulk.cpp.
_TYPES = {
    **dict.fromkeys(
        ("above", "below", "upper", "lower", "level", "clear_step", "near_step", "flat"), np.uint32
    ),
    **dict.fromkeys(("support_a", "support_b", "rank_a", "rank_b", "order_a", "order_b"), np.uint8),
    **dict.fromkeys(("coplanar", "a_in_b", "b_in_a"), np.uint8),
    **dict.fromkeys(("low", "high"), np.int32),
    **dict.fromkeys(("extent", "kind"), np.uint32),
}

# From the addresses of pairs and margins, their number, and the address of what is to be filled.
_Native = Callable[[int | None, int | None, int, Any], None]


def load_native(library: str, function: str, folder: Path = _FOLDER) -> _Native:
    """Return a native function, compiled where needed, from the sources in a folder."""
    return native_function(library, function, "ppip", folder, sorted(folder.glob("bulk_*.h")))


@cache
def _facts() -> _Native:
    return load_native("bulk", "triaxis_facts")


@cache
def _claims() -> _Native:
    return load_native("bulk_claims", "triaxis_claims")


def bulk_facts(pairs: npt.NDArray[Any], margins: npt.NDArray[Any] | int) -> Facts:
    """Return the facts of pairs (N, 2, 3, 3) at margins (N,), or at the same one, in LSB.

    Exact for coordinates of 32 bits, signed, and margins of 32 bits, unsigned; other ones raise
    InputError. Contiguous int32 and uint32 arrays are used as they are, others are checked and copied.
    """
    coordinates = native_pairs(pairs)
    count = len(coordinates)
    limits = native_margins(margins, count)
    arrays: dict[str, npt.NDArray[Any]] = {name: np.empty(count, kind) for name, kind in _TYPES.items()}
    addresses = (ctypes.c_void_p * len(arrays))(*(array.ctypes.data for array in arrays.values()))
    _facts()(coordinates.ctypes.data, limits.ctypes.data, count, addresses)
    return Facts(**arrays)


def bulk_verdicts(
    pairs: npt.NDArray[Any],
    margins: npt.NDArray[Any] | int,
    progress: Callable[[int], None] | None = None,
) -> Verdicts:
    """Return the verdicts on pairs, as `bulk_facts` takes them; see `VERDICT`.

    ``progress`` is told how many pairs were done.
    """
    coordinates = native_pairs(pairs)
    limits = native_margins(margins, len(coordinates))
    verdicts = np.zeros(len(coordinates), VERDICT)
    for start in range(0, len(coordinates), _CHUNK):
        chunk = slice(start, start + _CHUNK)
        verdicts[chunk] = bulk_facts(coordinates[chunk], limits[chunk]).verdicts
        if progress:
            progress(len(verdicts[chunk]))
    return verdicts


def bulk_claims(pairs: npt.NDArray[Any], margins: npt.NDArray[Any] | int) -> npt.NDArray[np.int8]:
    """Return the lowest-numbered separating axis of each pair, NO_AXIS (-1) where the pair is near: (N,).

    Pairs and margins, in LSB, as `bulk_facts` takes them; exact for all of those. The axis of a clear pair is
    its certificate, which `triaxis.golden.certificate` confirms.
    """
    coordinates = native_pairs(pairs)
    limits = native_margins(margins, len(coordinates))
    claims = np.empty(len(coordinates), np.int8)
    _claims()(coordinates.ctypes.data, limits.ctypes.data, len(coordinates), claims.ctypes.data)
    return claims
