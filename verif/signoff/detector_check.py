"""The wrapper CollisionDetector against the golden model."""

from dataclasses import dataclass

import numpy as np

from triaxis.golden.judge import judge_pairs
from triaxis.golden.pairs import coordinate_range
from triaxis.verif.detector import WIDTH, detect
from triaxis.verif.sequences.families import mixed_pairs
from triaxis.verif.sequences.seed_vectors import seed_normals, seed_vectors

SEED_VECTORS = 15
_PAIRS = 3_000


@dataclass(frozen=True)
class DetectorResult:
    """The combinational wrapper: seed vectors that it finds clear, and random pairs it gets wrong."""

    seed_vectors_clear: int
    pairs: int
    wrong: int


def check_detector(seed: int) -> DetectorResult:
    """Check the wrapper on the seed vectors and on random pairs with random normals handed in."""
    clear = int((~detect(seed_vectors(WIDTH), seed_normals())).sum())
    rng = np.random.default_rng([seed, WIDTH])
    low, high = coordinate_range(WIDTH)
    pairs = mixed_pairs(rng, _PAIRS, WIDTH)
    normals = rng.integers(low, high + 1, (_PAIRS, 2, 3))
    near = judge_pairs(pairs, np.zeros(_PAIRS, np.int64))["near"]
    return DetectorResult(clear, len(pairs), int((detect(pairs, normals) != near).sum()))
