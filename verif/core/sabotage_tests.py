"""Tests whose monitors lie: they must fail, which shows that the scoreboard's checks can."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pyuvm import uvm_factory

from triaxis.sim.result import AXIS_SHIFT, NEAR
from triaxis.verif.core.burst_agent import BurstSinkMonitor, BurstSourceMonitor
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.uvm_tests import MixedTest
from triaxis.verif.testbench.batches import PairBatch, ResultBatch

# Which beat of a batch is falsified: any will do.
_BEAT = 77


class LyingSinkMonitor(BurstSinkMonitor):
    """Publishes results after `falsify` had them."""

    falsify: Callable[[ResultBatch], ResultBatch]

    def build_phase(self) -> None:
        """Put the lie in front of the analysis port."""
        super().build_phase()
        publish = self.ap.write

        def write(datum: Any) -> None:
            is_batch = isinstance(datum, ResultBatch) and len(datum) > _BEAT
            publish(type(self).falsify(datum) if is_batch else datum)

        self.ap.write = write


def _chosen(batch: ResultBatch, rows: np.ndarray) -> ResultBatch:
    return ResultBatch(batch.words[rows], batch.tags[rows], batch.waits[rows])


class DroppingSinkMonitor(LyingSinkMonitor):
    """Loses a result."""

    @staticmethod
    def falsify(batch: ResultBatch) -> ResultBatch:
        """Leave it out."""
        return _chosen(batch, np.delete(np.arange(len(batch)), _BEAT))


class DuplicatingSinkMonitor(LyingSinkMonitor):
    """Sees a result twice."""

    @staticmethod
    def falsify(batch: ResultBatch) -> ResultBatch:
        """Repeat it."""
        return _chosen(batch, np.insert(np.arange(len(batch)), _BEAT, _BEAT))


class ReorderingSinkMonitor(LyingSinkMonitor):
    """Sees two results in each other's place."""

    @staticmethod
    def falsify(batch: ResultBatch) -> ResultBatch:
        """Exchange them."""
        rows = np.arange(len(batch))
        rows[[_BEAT - 1, _BEAT]] = _BEAT, _BEAT - 1
        return _chosen(batch, rows)


class CorruptClaimSinkMonitor(LyingSinkMonitor):
    """Sees another axis than the one that a clear pair was claimed with."""

    @staticmethod
    def falsify(batch: ResultBatch) -> ResultBatch:
        """Change the claim of the first clear pair."""
        words = batch.words.copy()
        clear = int(np.flatnonzero(words & NEAR == 0)[0])
        words[clear] ^= np.uint16(1 << AXIS_SHIFT)
        return ResultBatch(words, batch.tags, batch.waits)


class CorruptPairSourceMonitor(BurstSourceMonitor):
    """Sees other pairs than the core was sent."""

    def fetch(self) -> tuple[PairBatch, bool]:
        """Put a point into the place of each B."""
        batch, reset = super().fetch()
        batch.pairs[:, 1] = batch.pairs.min(initial=0)
        return batch, reset


class MissingPairSourceMonitor(BurstSourceMonitor):
    """Misses the last pair of each fetch."""

    def fetch(self) -> tuple[PairBatch, bool]:
        """Leave it out."""
        batch, reset = super().fetch()
        return batch[:-1], reset


class RaisingChecker(Checker):
    """A checker with a fault of its own, in the worker's thread."""

    def check(self, pairs: PairBatch, results: ResultBatch) -> None:
        """Fail as code does that was not foreseen."""
        raise ZeroDivisionError("the checker is broken")


class _SabotagedTest(MixedTest):
    """Sends the mixture to a scoreboard that is lied to."""

    honest: type
    liar: type

    def build_phase(self) -> None:
        """Put the liar in the place of the honest monitor."""
        super().build_phase()
        uvm_factory().set_type_override_by_type(self.honest, self.liar)


class DroppedResultTest(_SabotagedTest):
    """A result is lost on its way to the scoreboard."""

    honest, liar = BurstSinkMonitor, DroppingSinkMonitor


class DuplicatedResultTest(_SabotagedTest):
    """A result reaches the scoreboard twice."""

    honest, liar = BurstSinkMonitor, DuplicatingSinkMonitor


class ReorderedResultTest(_SabotagedTest):
    """Two results reach the scoreboard in each other's place."""

    honest, liar = BurstSinkMonitor, ReorderingSinkMonitor


class MissingPairTest(_SabotagedTest):
    """A pair is not seen by the input monitor."""

    honest, liar = BurstSourceMonitor, MissingPairSourceMonitor


class RaisingCheckerTest(MixedTest):
    """The checker raises an exception in the worker's thread."""

    def end_of_elaboration_phase(self) -> None:
        """Put the broken checker in the place of the scoreboard's."""
        self.env.scoreboard.checker = RaisingChecker(self.settings.configuration)


class CorruptClaimTest(_SabotagedTest):
    """A claim is falsified on its way to the scoreboard."""

    honest, liar = BurstSinkMonitor, CorruptClaimSinkMonitor


class CorruptPairTest(_SabotagedTest):
    """The scoreboard is told of other pairs than the core got."""

    honest, liar = BurstSourceMonitor, CorruptPairSourceMonitor
