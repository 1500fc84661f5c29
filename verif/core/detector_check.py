"""The wrapper CollisionDetector against the golden model."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import Pairs, coordinate_range
from triaxis.sim.detector import WIDTH, detect
from triaxis.verif.core.stimulus.families import mixed_pairs
from triaxis.verif.core.stimulus.seed_vectors import seed_normals, seed_vectors

SEED_VECTORS = 15
_PAIRS = 3_000


@dataclass(frozen=True)
class DetectorResult:
    """The combinational wrapper: seed vectors that it finds clear, and random pairs it gets wrong."""

    seed_vectors_clear: int
    pairs: int
    wrong: int


def wrapper_questions(seed: int) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Return the pairs (N, 2, 3, 3) that the wrapper is asked, and the normals handed in (N, 2, 3).

    First the seed vectors with theirs, then random pairs with random ones.
    """
    rng = np.random.default_rng([seed, WIDTH])
    low, high = coordinate_range(WIDTH)
    pairs = mixed_pairs(rng, _PAIRS, WIDTH)
    normals = rng.integers(low, high + 1, (_PAIRS, 2, 3))
    return np.concatenate([seed_vectors(WIDTH), pairs]), np.concatenate([seed_normals(), normals])


def check_detector(seed: int) -> DetectorResult:
    """Check the wrapper on the seed vectors and on random pairs with random normals handed in."""
    pairs, normals = wrapper_questions(seed)
    collides = detect(pairs, normals)
    wrong = collides != judge_pairs(pairs, np.zeros(len(pairs), np.int64))["near"]
    clear = int((~collides[:SEED_VECTORS]).sum())
    return DetectorResult(clear, _PAIRS, int(wrong[SEED_VECTORS:].sum()))
