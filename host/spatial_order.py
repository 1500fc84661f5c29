"""The order in which triangles are given to the mesh engine: neighbours in space stand side by side.

The engine makes a group of each run of consecutive triangles, and skips whole pairs of groups whose
boxes are apart. The order changes no verdict, only how much is skipped.
"""

from typing import Any

import numpy as np
import numpy.typing as npt


def spatial_order(triangles: npt.NDArray[Any], group: int) -> npt.NDArray[np.int64]:
    """Return the numbers of triangles (N, 3, 3) in an order with compact groups of ``group``: (N,).

    The set is cut in two across the longest side of the box of its boxes' centres, at a multiple of
    the group next to the median, and each part again, as a k-d tree is built.
    """
    # Twice the centres of the boxes, in the unit of the coordinates.
    centres = triangles.min(1).astype(np.float64) + triangles.max(1).astype(np.float64)
    parts = [np.arange(len(triangles))]
    done: list[npt.NDArray[np.int64]] = []
    while parts:
        part = parts.pop()
        if len(part) <= group:
            done.append(part)
            continue
        groups = -(-len(part) // group)
        # All groups but the last are full: the first part takes whole ones.
        half = groups // 2 * group
        axis = int(np.argmax(np.ptp(centres[part], axis=0)))
        sorted_part = part[np.argsort(centres[part, axis], kind="stable")]
        parts += [sorted_part[half:], sorted_part[:half]]
    return np.concatenate(done) if done else np.zeros(0, np.int64)
