"""The vertex of a triangle that is alone on its side of a plane: what both interval tests start from."""

from itertools import product

import numpy as np
import numpy.typing as npt

Signs = npt.NDArray[np.int8]


def _lone(pattern: tuple[int, ...]) -> tuple[int, int]:
    """Return the vertex of a pattern of signs that is alone, and the side that it is on.

    On the plane counts as the other side; a vertex on the plane is alone if the others are beyond it on
    one side. (0, 0) where there is none: all on the plane, or all strictly on one side.
    """
    for number in range(3):
        others = [pattern[(number + 1) % 3], pattern[(number + 2) % 3]]
        for side in (1, -1):
            beyond = all(side * other <= 0 for other in others)
            touching = pattern[number] == 0 and all(side * other < 0 for other in others)
            if (side * pattern[number] > 0 and beyond) or touching:
                return number, side
    return 0, 0


_TABLE = np.array([_lone(pattern) for pattern in product((-1, 0, 1), repeat=3)], np.int8)


def lone_vertex(signs: Signs) -> tuple[npt.NDArray[np.intp], Signs]:
    """Return, from the sides of the vertices (3, N), the number of the lone one and its side: (N,) each."""
    found = _TABLE[9 * signs[0].astype(np.intp) + 3 * signs[1] + signs[2] + 13]
    return found[:, 0].astype(np.intp), found[:, 1]


def all_on_one_side(signs: Signs) -> npt.NDArray[np.bool_]:
    """Return whether all three are strictly on the same side: (N,)."""
    return np.abs(signs.sum(0)) == 3
