"""Every way by which pairs come in from outside the simulator, tried with coordinates that do not fit.

In the simulator the driver of sequence items is one more: see `triaxis.verif.faults.fault_tests`.
"""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, coordinate_range, read_pairs
from triaxis.host.quantise import Grid, quantise
from triaxis.sim.configuration import Configuration
from triaxis.sim.detector import detect
from triaxis.verif.core.failing_pairs import read_failing, read_failing_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors

WIDTH = 16
_CORE = Configuration(WIDTH)
_ORIGIN = (Fraction(0), Fraction(0), Fraction(0))


def verdict_file(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis verdict`` does."""
    path = folder / "pairs.npy"
    np.save(path, pairs)
    read_pairs(path, WIDTH)


def _archive(pairs: Pairs, folder: Path, context: Pairs) -> Path:
    path = folder / "failing_pairs.npz"
    count = len(pairs)
    np.savez(
        path,
        pairs=pairs,
        margins=np.zeros(count, np.int64),
        context=np.repeat(context[None], count, 0),
        context_margins=np.zeros((count, len(context)), np.int64),
        context_counts=np.full(count, len(context)),
    )
    return path


def replay_file(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis sim ReplayTest`` does."""
    read_failing_pairs(_archive(pairs, folder, pairs), _CORE)


def shrink_context(pairs: Pairs, folder: Path) -> None:
    """Read the pairs as ``triaxis regress shrink`` does what came before a failing pair."""
    read_failing(_archive(np.zeros_like(pairs), folder, pairs), _CORE)


def mesh(pairs: Pairs, _: Path) -> None:
    """Quantise the triangles as ``triaxis check`` does facets, on a grid of whole numbers."""
    facets = pairs.reshape(-1, 3, 3).astype(np.float32)
    quantise(facets, Grid(Fraction(1), _ORIGIN, WIDTH), "mesh")


def wrapper(pairs: Pairs, _: Path) -> None:
    """Ask the wrapper CollisionDetector about the pairs."""
    detect(pairs, np.zeros((len(pairs), 2, 3), np.int64))


def wrapper_normals(pairs: Pairs, _: Path) -> None:
    """Hand the wrapper the first vertices for normals."""
    detect(np.zeros_like(pairs), pairs[:, :, 0])


ENTRANCES: dict[str, Callable[[Pairs, Path], None]] = {
    "pairs of `triaxis verdict`": verdict_file,
    "pairs of ReplayTest": replay_file,
    "context of `triaxis regress shrink`": shrink_context,
    "mesh of `triaxis check`": mesh,
    "pairs of the wrapper": wrapper,
    "normals of the wrapper": wrapper_normals,
}


def refusals(pairs: Pairs) -> dict[str, str | None]:
    """Return what each entrance says of the pairs; None where it lets them in."""
    said: dict[str, str | None] = {}
    with TemporaryDirectory() as folder:
        for name, enter in ENTRANCES.items():
            try:
                enter(pairs, Path(folder))
                said[name] = None
            except InputError as error:
                said[name] = str(error)
    return said


def boundary() -> tuple[Pairs, Pairs]:
    """Return pairs at both ends of the range, and pairs one step beyond them: (2, 2, 3, 3) each.

    In each, one coordinate differs from 0: x of the first vertex of A.
    """
    inside = np.zeros((2, 2, 3, 3), np.int64)
    inside[:, 0, 0, 0] = coordinate_range(WIDTH)
    outside = inside.copy()
    outside[:, 0, 0, 0] += (-1, 1)
    return inside, outside


def seed_vectors_by_width() -> dict[int, str | None]:
    """Return, by width, what a core that is too narrow for the seed vectors is told; None: they fit."""
    said: dict[int, str | None] = {}
    for width in (WIDTH - 1, WIDTH):
        try:
            seed_vectors(width)
            said[width] = None
        except InputError as error:
            said[width] = str(error)
    return said
