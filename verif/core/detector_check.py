"""The wrapper CollisionDetector against the golden model."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.sim.core_engine import CoreError
from triaxis.sim.detector import WIDTH, DetectorPlayer, detect, detector_inputs
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.stimulus.general import at_corners
from triaxis.verif.core.stimulus.near_miss import sole_axis
from triaxis.verif.core.stimulus.seed_vectors import seed_normals, seed_vectors

SEED_VECTORS = 15
_PAIRS = 6_000


@dataclass(frozen=True)
class DetectorResult:
    """The combinational wrapper: seed vectors that it finds clear, and random pairs it gets wrong."""

    seed_vectors_clear: int
    pairs: int
    wrong: int


def _random_questions(seed: int, width: int) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return random pairs (N, 2, 3, 3), and random normals handed in (N, 2, 3).

    A third of them at corners, a third that one axis alone decides.
    """
    rng = np.random.default_rng([seed, width])
    low, high = coordinate_range(width)
    corners = at_corners(rng, _PAIRS // 3, width, 0).pairs
    decided = sole_axis(rng, _PAIRS // 3, width, 0).pairs
    others = mixed_pairs(rng, _PAIRS - len(corners) - len(decided), width)
    pairs = np.concatenate([others, corners, decided])
    return pairs.astype(np.int64), rng.integers(low, high + 1, (_PAIRS, 2, 3))


def wrapper_questions(seed: int) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return the pairs (N, 2, 3, 3) that the wrapper is asked, and the normals handed in (N, 2, 3).

    First the seed vectors with theirs, then random pairs with random ones.
    """
    pairs, normals = _random_questions(seed, WIDTH)
    return np.concatenate([seed_vectors(WIDTH), pairs]), np.concatenate([seed_normals(), normals])


def check_detector(seed: int) -> DetectorResult:
    """Check the wrapper on the seed vectors and on random pairs with random normals handed in."""
    pairs, normals = wrapper_questions(seed)
    collides = detect(pairs, normals)
    wrong = collides != _exact(pairs)
    clear = int((~collides[:SEED_VECTORS]).sum())
    return DetectorResult(clear, _PAIRS, int(wrong[SEED_VECTORS:].sum()))


def _exact(pairs: Pairs) -> npt.NDArray[np.bool_]:
    return judge_pairs(pairs, np.zeros(len(pairs), np.int64))["near"]


@cache
def _asked(seed: int, width: int) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.bool_]]:
    """Return what the wrapper of a width is asked at random, and the answers."""
    pairs, normals = _random_questions(seed, width)
    return detector_inputs(pairs, normals, width), _exact(pairs)


def ask_at_random(player: DetectorPlayer, seed: int, width: int) -> tuple[int, int]:
    """Ask the wrapper of a library random pairs; return how many, and how many it answers wrongly."""
    inputs, answers = _asked(seed, width)
    return len(answers), int((player.play(inputs) != answers).sum())


def first_wrong(seed: int, width: int, library: Path, selected: int = 0) -> int:
    """Return the number of the first random pair that the wrapper of a library answers wrongly; 0: none.

    ``selected``: the mutant, where the library holds any.
    """
    inputs, answers = _asked(seed, width)
    try:
        wrong = np.flatnonzero(DetectorPlayer(library, selected).play(inputs) != answers)
    except CoreError:
        return 1
    return int(wrong[0]) + 1 if len(wrong) else 0
