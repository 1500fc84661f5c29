"""Meshes to make scenes of: clouds, clusters and lattices of triangles, wherever a range has room."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration

Integers = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Shapes:
    """Makers of meshes (N, 3, 3) in the range of a configuration, from one generator."""

    rng: np.random.Generator
    configuration: MeshConfiguration

    @property
    def reach(self) -> int:
        """Return half of the range."""
        return 1 << (self.configuration.width - 1)

    def clipped(self, triangles: Integers) -> Integers:
        """Return triangles with every coordinate within the range."""
        return np.clip(triangles, *coordinate_range(self.configuration.width))

    def cloud(self, count: int, centre: Integers, spread: int, size: int) -> Integers:
        """Return triangles of a size, spread around a centre (3,) or around centres (count, 3)."""
        places = np.asarray(centre) + self.rng.integers(-spread, spread + 1, (count, 3))
        return self.clipped(places[:, None] + self.rng.integers(-size, size + 1, (count, 3, 3)))

    def by_groups(self, count: int, centres: Integers, size: int) -> Integers:
        """Return triangles around centres (K, 3), those of a group around the same one, in turn."""
        number = np.arange(count) // self.configuration.group % len(centres)
        return self.cloud(count, centres[number], 0, size)

    def lattice(self, count: int, parity: int, pitch: int) -> Integers:
        """Return small triangles in cells of one parity; no cell of the other comes within pitch - 2."""
        side = max(3, int(np.ceil((4 * count) ** (1 / 3))))
        cells = np.stack(np.meshgrid(*[np.arange(side)] * 3, indexing="ij"), -1).reshape(-1, 3)
        cells = cells[cells.sum(1) % 2 == parity] - side // 2
        chosen = cells[self.rng.choice(len(cells), count, replace=len(cells) < count)]
        return self.clipped(chosen[:, None] * pitch + self.rng.integers(0, 2, (count, 3, 3)))

    def somewhere(self, share: float = 0.5) -> Integers:
        """Return a point (3,) in the inner share of the range."""
        limit = max(1, int(self.reach * share))
        return self.rng.integers(-limit, limit, 3)

    def size(self) -> int:
        """Return a number of triangles: each class of sizes as often as any other, but more than fit."""
        group, depth = self.configuration.group, self.configuration.depth
        few = [0, 1, max(1, group - 1), group, group + 1, depth]
        several = int(self.rng.integers(1, max(2, min(depth, 4 * group))))
        return min(depth, int(self.rng.choice([*few, several, several])))
