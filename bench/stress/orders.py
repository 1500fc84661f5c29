"""A method's answers in all 72 orders of each pair, and what is wrong with them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from triaxis.bench.harness import Summed
from triaxis.bench.stress.methods import Mask, Triangles, guigue_devillers, moller, separating_axes
from triaxis.verif.core.stimulus.stimulus import Ints
from triaxis.verif.core.stimulus.symmetry import NUM_ORDERS, VERTICES

# Answers "near" in each order of each pair: (orders, N).
Answers = npt.NDArray[np.bool_]
# From two arrays of triangles (3, 3, N), which pairs it takes for near: (N,).
Test = Callable[[Triangles, Triangles], Mask]

# Bits of the largest coordinate after scaling. Products of six coordinates stay far from the largest float32,
# and those of the smallest triangles from the smallest.
_SCALED_BITS = 20


@dataclass(frozen=True)
class Method:
    """A published test, in a floating-point type."""

    test: Test
    title: str
    dtype: type[np.floating[Any]]

    @property
    def name(self) -> str:
        """Return a name for tables: ``float32 SAT``, .."""
        return f"{np.dtype(self.dtype).name} {self.title}"


METHODS = tuple(
    Method(test, title, dtype)
    for test, title in ((separating_axes, "SAT"), (moller, "Moller"), (guigue_devillers, "Guigue-Devillers"))
    for dtype in (np.float32, np.float64)
)


@dataclass(frozen=True)
class OrderErrors(Summed):
    """Of the answers on N pairs in all orders: how many there are, and how many of them are wrong.

    misses: "clear" of a near pair; false_alarms: "near" of a clear one. pairs: N; changing_pairs: pairs whose
    answer is not the same in all orders.
    """

    answers: int
    misses: int
    false_alarms: int
    pairs: int
    changing_pairs: int

    @property
    def wrong(self) -> int:
        """Return the number of wrong answers."""
        return self.misses + self.false_alarms

    @property
    def wrong_rate(self) -> float:
        """Return the share of wrong answers."""
        return self.wrong / self.answers

    @property
    def changing_rate(self) -> float:
        """Return the share of pairs whose answer hangs on the order."""
        return self.changing_pairs / self.pairs


def errors(answers: Answers, near: Mask) -> OrderErrors:
    """Compare answers (orders, N) with the exact verdicts (N,)."""
    wrong, some = answers != near, answers.any(0)
    return OrderErrors(
        answers.size,
        int((wrong & near).sum()),
        int((wrong & ~near).sum()),
        len(near),
        int((some & ~answers.all(0)).sum()),
    )


def scaled(pairs: Ints | npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return pairs (N, 2, 3, 3) of whole numbers below 2^53 as vertex, coordinate, pair: (6, 3, N), exactly.

    Each is divided by a power of 2 of its own, so that no method overflows.
    """
    points = np.ascontiguousarray(pairs.reshape(-1, 6, 3).transpose(1, 2, 0)).astype(np.float64)
    exponent = np.frexp(np.abs(points).max((0, 1), initial=1.0))[1]
    return np.ldexp(points, _SCALED_BITS - exponent)


def in_all_orders(test: Test, points: npt.NDArray[Any]) -> Answers:
    """Return the answers of a test on points (6, 3, N), computed in their type: (72, N)."""
    answers = np.empty((NUM_ORDERS, points.shape[2]), np.bool_)
    # A number divided by 0, or too large, is what the method would meet in its own program.
    with np.errstate(all="ignore"):
        for number, order in enumerate(VERTICES):
            ordered = points[order]
            answers[number] = test(ordered[:3], ordered[3:])
    return answers


def method_errors(method: Method, pairs: Ints, near: Mask) -> OrderErrors:
    """Return what a method gets wrong on pairs below 2^53, in all orders, against exact verdicts."""
    return errors(in_all_orders(method.test, scaled(pairs).astype(method.dtype)), near)
