"""Lists of pairs compared: whether one begins with the other, and where they part."""

import numpy as np
import numpy.typing as npt

from triaxis.verif.mesh.observed import Integers


def begins(whole: Integers, part: Integers) -> bool:
    """Return whether pairs (N, 2) begin with pairs (K, 2)."""
    return len(part) <= len(whole) and bool((whole[: len(part)] == part).all())


def first_of(mask: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first pair of a mask (N, M) that is set."""
    i, j = np.argwhere(mask)[0]
    return int(i), int(j)


def difference(found: Integers, due: Integers) -> str:
    """Return where two lists of pairs part, in words."""
    common = min(len(found), len(due))
    unlike = np.flatnonzero((found[:common] != due[:common]).any(1))
    at = int(unlike[0]) if len(unlike) else common
    here = [str(tuple(pairs[at].tolist())) if at < len(pairs) else "none" for pairs in (found, due)]
    return f"number {at} is {here[0]}, {here[1]} is due; {len(found)} and {len(due)} in all"
