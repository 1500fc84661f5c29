"""One class of A against every triangle B, in random orders and at a random place, at every margin."""

from collections.abc import Callable
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from triaxis.golden.certificate import claims_prove_clear
from triaxis.golden.facts import Facts
from triaxis.golden.judge import CertificateError, judge_pairs
from triaxis.sim.configuration import Configuration
from triaxis.sim.result import NEAR, claimed_axes, encode
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.stimulus.symmetry import random_orders
from triaxis.verif.exhaustive.grid import Grid

Words = npt.NDArray[np.uint16]
# Facts of pairs (N, 2, 3, 3) at margins (N,).
Oracle = Callable[[npt.NDArray[np.int32], npt.NDArray[np.uint32]], Facts]

# The margins 0 and 1: what one margin bit can say.
MARGINS = (0, 1)
CONFIGURATION = Configuration(8, 1)

# Pairs that the core and the oracle take at a time.
_BLOCK = 1 << 16
# Pairs of each class that the linear program judges too.
_JUDGED = 8
# Mismatches kept of a class; beyond that they are only counted.
_KEPT = 3
# Runs before a wrong one that are kept with it: a fault may need them. More than any latency.
_CONTEXT = 64


class Core(Protocol):
    """What answers: `triaxis.sim.core_engine.RtlEngine`, or a broken one in tests."""

    def words(self, pairs: npt.NDArray[np.int32], margins: npt.NDArray[np.uint32]) -> tuple[Words, int]:
        """Return the result words and the clock cycles."""
        ...


@dataclass(frozen=True)
class Mismatch:
    """A pair that the core got wrong, or that contradicts another answer of its own.

    pair: (2, 3, 3); context, context_margins: the pairs just before it. Lists, as JSON has them.
    """

    message: str
    pair: list[Any]
    margin: int
    context: list[Any] = field(default_factory=list)
    context_margins: list[int] = field(default_factory=list)


@dataclass(frozen=True)
class Counts:
    """What was run and found.

    pairs: class of A and triangle B; runs: pairs x margins; near: runs that the core calls near.
    claims: clear answers proven by their axis; judged: runs that the linear program judged.
    mismatches: runs answered wrongly, and pairs near at a margin and not at the next.
    ordered: ordered pairs that the runs at each margin stand for; ordered_near: near ones among them.
    """

    classes: int = 0
    pairs: int = 0
    runs: int = 0
    near: int = 0
    claims: int = 0
    judged: int = 0
    mismatches: int = 0
    ordered: tuple[int, ...] = (0,) * len(MARGINS)
    ordered_near: tuple[int, ...] = (0,) * len(MARGINS)

    def __add__(self, other: "Counts") -> "Counts":
        """Return the sums."""

        def total(name: str) -> Any:
            one, two = getattr(self, name), getattr(other, name)
            return one + two if isinstance(one, int) else tuple(map(sum, zip(one, two, strict=True)))

        return Counts(**{f.name: total(f.name) for f in fields(self)})


@dataclass
class ClassResult:
    """Counts of one or several classes, and the first mismatches."""

    counts: Counts = field(default_factory=Counts)
    mismatches: list[Mismatch] = field(default_factory=list)


def check_class(grid: Grid, core: Core, oracle: Oracle, seed: int, number: int) -> ClassResult:
    """Run class ``number`` against every triangle, and compare all that the core answers.

    What is random follows from the seed and the number of the class.
    """
    return _ClassRun(grid, core, oracle, seed, number).result()


class _ClassRun:
    """Run n is triangle n % T as B, at margin MARGINS[n // T]."""

    def __init__(self, grid: Grid, core: Core, oracle: Oracle, seed: int, number: int) -> None:
        self._rng = np.random.default_rng([seed, grid.size, number])
        self._core, self._oracle = core, oracle
        placed = grid.placed(self._rng, CONFIGURATION.width)
        representative = int(grid.classes.representatives[number])
        self._a = placed[grid.triangles[representative]]
        self._bs = placed[grid.triangles]
        self._stands_for = grid.arrangements * grid.arrangements[representative] * grid.classes.sizes[number]
        self._runs = len(MARGINS) * len(self._bs)
        # 0 not answered, 1 clear, 2 near.
        self._answers = np.zeros(self._runs, np.uint8)
        self._claims = self._judged = self._failed = 0
        self._mismatches: list[Mismatch] = []

    def result(self) -> ClassResult:
        # In random order, so that neighbours in the pipeline differ in everything.
        order = self._rng.permutation(self._runs)
        for start in range(0, self._runs, _BLOCK):
            self._check_block(order[start : start + _BLOCK])
        self._judge_some(order[:_JUDGED])
        answers = self._answers.reshape(len(MARGINS), -1)
        self._check_monotonic(answers)
        counts = Counts(
            classes=1,
            pairs=int((answers > 0).all(0).sum()),
            runs=int((answers > 0).sum()),
            near=int((answers == 2).sum()),
            claims=self._claims,
            judged=self._judged,
            mismatches=self._failed,
            ordered=tuple(int(self._stands_for[row > 0].sum()) for row in answers),
            ordered_near=tuple(int(self._stands_for[row == 2].sum()) for row in answers),
        )
        return ClassResult(counts, self._mismatches)

    def _pairs(self, runs: npt.NDArray[np.intp]) -> npt.NDArray[np.int32]:
        pairs = np.empty((len(runs), 2, 3, 3), np.int32)
        pairs[:, 0] = self._a
        pairs[:, 1] = self._bs.take(runs % len(self._bs), 0)
        return pairs

    def _margins(self, runs: npt.NDArray[np.intp]) -> npt.NDArray[np.uint32]:
        return np.array(MARGINS, np.uint32)[runs // len(self._bs)]

    def _check_block(self, runs: npt.NDArray[np.intp]) -> None:
        pairs, margins = random_orders(self._rng, self._pairs(runs)), self._margins(runs)
        words = self._core.words(pairs, margins)[0]
        expected = expected_words(self._oracle(pairs, margins), CONFIGURATION)
        near = words & NEAR != 0
        self._answers[runs] = 1 + near
        proven = near | claims_prove_clear(pairs, margins, claimed_axes(words))
        self._claims += int((proven & ~near).sum())
        for i in self._count((words != expected) | ~proven):
            lie = "" if proven[i] else "; the claimed axis does not separate"
            message = f"core says {words[i]:#06x}, bulk checker {expected[i]:#06x}{lie}"
            before = slice(max(0, i - _CONTEXT), i)
            context = pairs[before].tolist(), margins[before].tolist()
            self._mismatches.append(Mismatch(message, pairs[i].tolist(), int(margins[i]), *context))

    def _check_monotonic(self, answers: npt.NDArray[np.uint8]) -> None:
        """Require what is near at a margin to be near at the next, whatever any oracle says."""
        for margin, (tight, wide) in enumerate(pairwise(answers)):
            for i in self._count((tight == 2) & (wide != 2)):
                message = f"near at margin {MARGINS[margin]} and not beyond"
                pair = [self._a.tolist(), self._bs[i].tolist()]
                self._mismatches.append(Mismatch(message, pair, MARGINS[margin + 1]))

    def _judge_some(self, runs: npt.NDArray[np.intp]) -> None:
        """Compare the oracle with the linear program; both are exact, so they must agree."""
        pairs, margins = self._pairs(runs), self._margins(runs)
        judged = judge_pairs(pairs.astype(np.int64), margins.astype(np.int64))
        words = expected_words(self._oracle(pairs, margins), replace(CONFIGURATION, gating=False))
        for i in np.flatnonzero(words != encode(judged)):
            raise CertificateError(
                f"bulk checker and linear program disagree on {pairs[i].tolist()}, {margins[i]}"
            )
        self._judged += len(runs)

    def _count(self, wrong: npt.NDArray[np.bool_]) -> list[int]:
        """Count what is wrong; return the first ones, to be kept."""
        where = np.flatnonzero(wrong)
        self._failed += len(where)
        return where[: _KEPT - len(self._mismatches)].tolist()
