"""The golden model's solver against another, PPL's: the same distance of pairs of every family."""

import signal
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.judge import SOLVER, CertificateError, judge
from triaxis.golden.solver import DistanceSolver
from triaxis.verif.core.stimulus.families import mixed

_WIDTHS = (8, 16, 24, 32)
_PAIRS = 4000
_OURS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


@dataclass(frozen=True)
class SolverResult:
    """Pairs that both solvers were asked, and those of which they say another distance, or prove it not."""

    pairs: int
    different: int


def other_solver() -> DistanceSolver:
    """Return PPL's, to be asked by the main thread; raise InputError where it is not installed."""
    handlers = {number: signal.getsignal(number) for number in _OURS}
    try:
        from triaxis.golden.ppl_solver import PplSolver
    except ImportError as error:
        raise InputError(f"pplpy: not installed ({error}): pip install pplpy, or make setup") from error
    # PPL's loader takes signals over; with its handler a hang-up ends the process with exit code 0.
    for number, handler in handlers.items():
        signal.signal(number, handler)
    return PplSolver()


def check_solvers(seed: int, widths: Sequence[int] = _WIDTHS, pairs: int = _PAIRS) -> SolverResult:
    """Ask both solvers pairs of every family at several widths."""
    other = other_solver()
    asked = different = 0
    for width in widths:
        made = mixed(np.random.default_rng([seed, width, *b"solvers"]), pairs, width, width)
        for (a, b), margin in zip(made.pairs.tolist(), made.margins.tolist(), strict=True):
            asked += 1
            different += not _agree(a, b, margin, other)
    return SolverResult(asked, different)


def _agree(a: list[list[int]], b: list[list[int]], margin: int, other: DistanceSolver) -> bool:
    try:
        ours, theirs = judge(a, b, margin, SOLVER), judge(a, b, margin, other)
    except CertificateError:
        return False
    return (ours.near, ours.distance) == (theirs.near, theirs.distance)
