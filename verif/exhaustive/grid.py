"""All triangles on the grid {0 .. G-1}^3, and their classes under the symmetries of the cube.

A triangle here is three points in any order, coincident ones included: a multiset of points, which stands
for its arrangements, the ordered triples of those points. Two triangles are of one class where a
symmetry of the cube about the middle of the grid takes one to the other. Whatever holds for a
representative of each class of A, each triangle B and every order of vertices, holds for every pair.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations_with_replacement, product

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import coordinate_range
from triaxis.verif.core.stimulus.symmetry import COORDINATES, NUM_SYMMETRIES, REFLECTED

SMALLEST, LARGEST = 2, 6


def check_size(size: int) -> None:
    """Raise InputError unless a grid of this size can be run."""
    if not SMALLEST <= size <= LARGEST:
        raise InputError(f"grid {size}: must be {SMALLEST}..{LARGEST} points along each coordinate")


def _moved(points: npt.NDArray[np.int32], symmetry: int, size: int) -> npt.NDArray[np.int32]:
    """Return points (P, 3) of the grid under a symmetry about its middle."""
    turned = points[:, COORDINATES[symmetry]]
    return np.where(REFLECTED[symmetry], size - 1 - turned, turned).astype(np.int32)


@dataclass(frozen=True)
class Grid:
    """The grid with ``size`` points along each coordinate; point (x, y, z) is number (x G + y) G + z."""

    size: int

    @cached_property
    def points(self) -> npt.NDArray[np.int32]:
        """Return the points by number: (P, 3)."""
        return np.array(list(product(range(self.size), repeat=3)), np.int32)

    @cached_property
    def triangles(self) -> npt.NDArray[np.uint8]:
        """Return the triangles as ascending point numbers: (T, 3)."""
        return np.array(list(combinations_with_replacement(range(len(self.points)), 3)), np.uint8)

    @cached_property
    def arrangements(self) -> npt.NDArray[np.int64]:
        """Return how many ordered triples each triangle stands for: 1, 3 or 6; (T,)."""
        first, second, third = self.triangles.T
        equal = (first == second).astype(np.int64) + (second == third)
        return np.array([6, 3, 1], np.int64)[equal]

    @cached_property
    def classes(self) -> "Classes":
        """Return the classes, found by the smallest image of each triangle."""
        weights = np.array([len(self.points) ** 2, len(self.points), 1])
        smallest = np.full(len(self.triangles), len(self.points) ** 3)
        for symmetry in range(NUM_SYMMETRIES):
            image = self._number_of(_moved(self.points, symmetry, self.size))
            codes = np.sort(image[self.triangles], axis=1) @ weights
            smallest = np.minimum(smallest, codes)
        codes, sizes = np.unique(smallest, return_counts=True)
        # The triangles ascend, and so do their codes.
        return Classes(np.searchsorted(self.triangles @ weights, codes), sizes)

    @property
    def ordered_pairs(self) -> int:
        """Return how many ordered pairs of ordered triples there are: G^18."""
        return self.size**18

    def _number_of(self, points: npt.NDArray[np.int32]) -> npt.NDArray[np.int64]:
        return points.astype(np.int64) @ np.array([self.size**2, self.size, 1])

    def placed(self, rng: np.random.Generator, width: int) -> npt.NDArray[np.int32]:
        """Return the points (P, 3) turned at random, somewhere in the range, often at its limits."""
        low, high = coordinate_range(width)
        highest = high - (self.size - 1)
        anywhere = rng.integers(low, highest + 1, 3)
        kind = rng.integers(0, 4, 3)
        offset = np.select([kind == 0, kind == 1], [low, highest], anywhere)
        turned = _moved(self.points, int(rng.integers(NUM_SYMMETRIES)), self.size)
        return turned + offset.astype(np.int32)


@dataclass(frozen=True)
class Classes:
    """Classes of triangles: a representative of each, as index into the triangles, and how many it has."""

    representatives: npt.NDArray[np.intp]
    sizes: npt.NDArray[np.intp]

    def __len__(self) -> int:
        """Return the number of classes."""
        return len(self.sizes)

    def __iter__(self) -> Iterator[tuple[int, int]]:
        """Return the representative and the size of each class."""
        return zip(self.representatives.tolist(), self.sizes.tolist(), strict=True)
