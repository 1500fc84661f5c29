"""A scene's translation: A is taken back from where it is to come, as far as the range and the port allow."""

import numpy as np

from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Move
from triaxis.verif.mesh.shapes import Integers


def as_move(values: Integers) -> Move:
    """Return a translation."""
    x, y, z = (int(value) for value in values)
    return x, y, z


def allowed_moves(there: Integers, configuration: MeshConfiguration) -> tuple[Integers, Integers]:
    """Return the least and the largest translation (3,) that A (N, 3, 3), now there, can have come by."""
    low, high = coordinate_range(configuration.width)
    reach = 1 << configuration.width
    if not len(there):
        return np.full(3, -reach), np.full(3, reach - 1)
    points = there.reshape(-1, 3)
    return points.max(0) - high, points.min(0) - low


def placed(
    rng: np.random.Generator, there: Integers, configuration: MeshConfiguration
) -> tuple[Integers, Move]:
    """Return A before it is moved, and its translation: none, an end of what can be, or any between."""
    low, high = allowed_moves(there, configuration)
    kind = rng.integers(0, 4, 3)
    # Between zero and the ends; zero is always allowed where A is within the range.
    between = rng.integers(low, high + 1)
    move = np.choose(kind, [0 * low, low, high, between])
    return there - move, as_move(move)


def random_margin(rng: np.random.Generator, configuration: MeshConfiguration) -> int:
    """Return a margin: 0, 1, the largest, or of any order of size."""
    largest = configuration.max_margin
    any_size = int(2 ** rng.uniform(0, configuration.margin_bits)) if largest else 0
    return min(largest, int(rng.choice([0, 1, largest, any_size, any_size, any_size // 8])))
