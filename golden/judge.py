"""Exact verdicts on pairs: the reference that everything else is compared with."""

from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import numpy.typing as npt

from triaxis.golden.axes import first_separating
from triaxis.golden.certificate import axis_gap, axis_proves_clear, witness_proves_near
from triaxis.golden.errors import ToldError
from triaxis.golden.exact import Rational, Scalar, Triangle, coplanar, triangle_rank
from triaxis.golden.game_solver import GameSolver
from triaxis.golden.pairs import NO_AXIS, VERDICT, Pairs, Verdicts
from triaxis.golden.processes import in_processes
from triaxis.golden.solver import BestAxis, DistanceSolver, NearestPoints

# Pairs a worker process takes at a time: large enough to hide the cost of handing them over.
_CHUNK = 2000
# Used where no other is named.
SOLVER: DistanceSolver = GameSolver()


@dataclass(frozen=True)
class Judgement:
    """An exact verdict with its certificate, which has been checked.

    ``distance`` is the Chebyshev distance, in the unit of the coordinates.
    """

    near: bool
    distance: Fraction
    witness: NearestPoints | None
    axis: BestAxis | None


class CertificateError(ToldError, AssertionError):
    """The solver's answer does not prove itself. Never seen; it would be a fault of the solver."""


def judge(a: Triangle, b: Triangle, margin: Scalar, solver: DistanceSolver = SOLVER) -> Judgement:
    """Decide near(A, B, margin) exactly, for integers or fractions of any size.

    Raises CertificateError where the solver's certificate fails the checker, or does not show the distance:
    the axis that it is no less, the points that it is no more.
    """
    best = solver.best_axis(a, b)
    if axis_gap(a, b, best.axis) < best.distance or sum(map(abs, best.axis)) > 1:
        raise CertificateError(f"axis {best.axis} does not show {a} and {b} apart by {best.distance}")
    nearest = solver.nearest_points(a, b)
    if nearest.distance != best.distance:
        raise CertificateError(f"{a} and {b}: distance {nearest.distance}, dual {best.distance}")
    if not witness_proves_near(a, b, nearest.distance, nearest.weights_a, nearest.weights_b):
        raise CertificateError(f"{nearest} does not show how near {a} and {b} are")
    if best.distance > margin:
        if not axis_proves_clear(a, b, margin, best.axis):
            raise CertificateError(f"axis {best.axis} does not separate {a} and {b} by {margin}")
        return Judgement(False, _fraction(best.distance), None, best)
    return Judgement(True, _fraction(nearest.distance), nearest, None)


def _fraction(value: Rational) -> Fraction:
    return Fraction(int(value.numerator), int(value.denominator))


def judge_pairs(pairs: Pairs, margins: npt.NDArray[np.int64]) -> Verdicts:
    """Decide pairs of shape (N, 2, 3, 3) at margins of shape (N,); see `VERDICT` for the result.

    ``near`` is decided by the linear program. ``axis`` is the lowest-numbered of the 32 axes that
    separates by the definition of the axes; where the program and the axes disagree on whether any
    does, CertificateError is raised.
    """
    verdicts = np.zeros(len(pairs), VERDICT)
    verdicts["axis"] = first_separating(pairs, margins)
    for index, (pair, margin) in enumerate(zip(pairs.tolist(), margins.tolist(), strict=True)):
        a, b = pair
        near = judge(a, b, margin).near
        if near != (verdicts["axis"][index] == NO_AXIS):
            raise CertificateError(f"the 32 axes and the linear program disagree on {pair}, {margin}")
        verdicts[index] = (
            near,
            verdicts["axis"][index],
            coplanar(a, b),
            triangle_rank(a) < 2,
            triangle_rank(b) < 2,
        )
    return verdicts


def _judge_chunk(chunk: tuple[Pairs, npt.NDArray[np.int64]]) -> Verdicts:
    return judge_pairs(*chunk)


def judge_in_parallel(
    pairs: Pairs, margins: npt.NDArray[np.int64], progress: Callable[[int], None] | None = None
) -> Verdicts:
    """Do as `judge_pairs`, on all cores; ``progress`` is told how many pairs were done."""
    chunks = [
        (pairs[start : start + _CHUNK], margins[start : start + _CHUNK])
        for start in range(0, len(pairs), _CHUNK)
    ]
    report = progress or (lambda _: None)
    results = in_processes(_judge_chunk, chunks, lambda result: report(len(result)))
    return np.concatenate(results) if results else np.zeros(0, VERDICT)
