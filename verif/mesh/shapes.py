"""Meshes to make scenes of, and kinds of scenes by what decides them.

Clouds, clusters and lattices of triangles, wherever a range has room; rows, groups, boxes of triangles and
the core decide, in every mixture.
"""

from collections.abc import Callable
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
        # As often of each order of magnitude.
        any_many = int(2 ** self.rng.uniform(0, np.log2(depth)))
        return min(depth, int(self.rng.choice([*few, several, several, any_many])))


# From shapes, sizes of A and B, and a margin: both meshes, A where it is to come.
SceneKind = Callable[[Shapes, int, int, int], tuple[Integers, Integers]]

_X = np.array([1, 0, 0])


def cloud(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """Two clouds in one place, loose or dense."""
    spread = max(1, int(shapes.reach * shapes.rng.choice([0.02, 0.1, 0.4])))
    size = max(1, int(spread * shapes.rng.choice([0.1, 0.5, 2.0])))
    centre = shapes.somewhere()
    return shapes.cloud(count_a, centre, spread, size), shapes.cloud(count_b, centre, spread, size)


def rows_apart(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """A far away from the whole of B."""
    axis = np.roll(_X, int(shapes.rng.integers(3))) * shapes.rng.choice([-1, 1])
    away = axis * (shapes.reach * 3 // 4)
    size = max(1, shapes.reach // 16)
    return shapes.cloud(count_a, away, 0, size), shapes.cloud(count_b, -away, 0, size)


def groups_apart(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """A between the groups of B."""
    side = np.roll(_X, int(shapes.rng.integers(3))) * (shapes.reach * 3 // 4)
    size = max(1, shapes.reach // 16)
    b = shapes.by_groups(count_b, np.stack([side, -side]), size)
    return shapes.cloud(count_a, 0 * _X, 0, size), b


def rows_and_groups_apart(
    shapes: Shapes, count_a: int, count_b: int, margin: int
) -> tuple[Integers, Integers]:
    """Of A's groups every other one between those of B, the others far away on another axis."""
    axis = int(shapes.rng.integers(3))
    side, away = np.roll(_X, axis), np.roll(_X, axis + 1) * (shapes.reach * 3 // 4)
    side = side * (shapes.reach * 3 // 4)
    size = max(1, shapes.reach // 16)
    a = shapes.by_groups(count_a, np.stack([0 * _X, away]), size)
    return a, shapes.by_groups(count_b, np.stack([side, -side]), size)


def lattice(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """Triangles of both in each other's gaps: groups overlap, boxes do not."""
    pitch = margin + 3
    return shapes.lattice(count_a, 0, pitch), shapes.lattice(count_b, 1, pitch)


def lattice_and_groups(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """The same, and of A's groups every other one far away."""
    a, b = lattice(shapes, count_a, count_b, margin)
    group = np.arange(count_a) // shapes.configuration.group
    away = np.roll(_X, int(shapes.rng.integers(3))) * (shapes.reach * 3 // 4)
    return shapes.clipped(a + ((group % 2)[:, None] * away)[:, None]), b


def in_one_place(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """All triangles through one another: nothing can be skipped, and mostly everything is near."""
    centre, size = shapes.somewhere(), max(2, shapes.reach // 8)
    # All reach from one end of the box to the other.
    ends = np.array([[-size] * 3, [size] * 3, [-size, size, 0]])
    jitter = [shapes.rng.integers(-1, 2, (count, 3, 3)) for count in (count_a, count_b)]
    a, b = (shapes.clipped(centre + ends + j) for j in jitter)
    return a, b


def clusters(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """Groups in one of two places: those in the same place are all tested."""
    side = np.roll(_X, int(shapes.rng.integers(3))) * (shapes.reach * 3 // 4)
    centres = np.stack([side, -side])
    return shapes.by_groups(count_a, centres, 1), shapes.by_groups(count_b, centres, 1)


def slots(shapes: Shapes, count_a: int, count_b: int, of_groups: bool) -> tuple[Integers, Integers]:
    """Triangles, or whole groups, at random in a few places apart: where both are in the same, all is near.

    What is decided by boxes, and what is not, come in any order.
    """
    groups, places = shapes.configuration.group if of_groups else 1, int(shapes.rng.integers(2, 12))
    pitch = max(3, 2 * shapes.reach // places)

    def mesh(count: int) -> Integers:
        chosen = np.repeat(shapes.rng.integers(0, places, -(-count // groups)), groups)[:count]
        return np.array([[0, 0, 0], [2, 0, 1], [0, 2, 1]]) + (chosen * pitch - shapes.reach)[:, None, None]

    return mesh(count_a), mesh(count_b)


def one_contact(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """A lattice in which one triangle of A is one of B."""
    a, b = lattice(shapes, count_a, count_b, margin)
    if count_a and count_b:
        a[shapes.rng.integers(count_a)] = b[shapes.rng.integers(count_b)]
    return a, b


def late_contacts(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """All in one place, but for most of B's first groups: much is skipped while the first near pairs wait."""
    a, b = in_one_place(shapes, count_a, count_b, margin)
    few = min(max(count_b - shapes.configuration.group, 0), 4 * shapes.configuration.group)
    return a, _some_away(shapes, b, (np.arange(count_b) < few) & (shapes.rng.integers(0, 5, count_b) > 0))


def every_other(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """All in one place, but for every other triangle of B, and of A from one on: all groups overlap."""
    a, b = in_one_place(shapes, count_a, count_b, margin)
    odd_a, odd_b = (np.arange(count) % 2 == 1 for count in (count_a, count_b))
    odd_a &= np.arange(count_a) > shapes.rng.integers(0, max(count_a, 1))
    return _some_away(shapes, a, odd_a), _some_away(shapes, b, odd_b)


def _some_away(shapes: Shapes, triangles: Integers, which: np.ndarray) -> Integers:
    """Return triangles (N, 3, 3) of which those marked (N,) lie at the end of the range that is farther."""
    side = -1 if triangles.size and triangles[..., 0].mean() > 0 else 1
    away = triangles.copy()
    away[which, :, 0] = side * (shapes.reach - 1)
    return away


def planes(shapes: Shapes, count_a: int, count_b: int, margin: int) -> tuple[Integers, Integers]:
    """Triangles of two parallel tilted planes: boxes overlap, and the core finds nothing near."""
    size = max(8, shapes.reach // 8)
    corner = np.array([[0, 0, 0], [size, -size, 0], [0, size, -size]])
    apart = min(margin + 1 + int(shapes.rng.integers(0, 3)), shapes.reach // 2)
    shift = np.array([apart, apart, apart])
    jitter = shapes.rng.integers(-2, 3, (count_a + count_b, 1, 3))
    jitter[..., 2] = -jitter[..., :2].sum(-1)
    both = corner + jitter
    return shapes.clipped(both[:count_a] - shift), shapes.clipped(both[count_a:] + shift)


KINDS: dict[str, SceneKind] = {
    kind.__name__: kind
    for kind in (
        cloud,
        rows_apart,
        groups_apart,
        rows_and_groups_apart,
        lattice,
        lattice_and_groups,
        in_one_place,
        clusters,
        one_contact,
        late_contacts,
        every_other,
        planes,
    )
}
