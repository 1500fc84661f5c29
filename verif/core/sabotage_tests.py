"""Tests that cannot sign anything off: monitors that lie, so that the scoreboard must fail; a scoreboard that
checks nothing, for measurements.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from pyuvm import uvm_factory

from triaxis.sim.result import AXIS_SHIFT, NEAR
from triaxis.verif.core.burst_agents import BurstSinkMonitor, BurstSourceMonitor
from triaxis.verif.core.checking import Checker
from triaxis.verif.core.items import PairBatch, ResultBatch
from triaxis.verif.core.scoreboard import Scoreboard
from triaxis.verif.core.uvm_tests import MixedTest, VolumeTest
from triaxis.verif.testbench.sabotage import lie_about

# Which beat of a batch is falsified: any will do.
_BEAT = 77


class _SabotagedTest(MixedTest):
    """Sends the mixture to a scoreboard that is lied to, in every batch that is long enough."""

    honest: type
    falsify: Callable[[Any], Any]

    def build_phase(self) -> None:
        """Put the liar in the place of the honest monitor."""
        super().build_phase()
        lie_about(self.honest, self.lie, range(1 << 62))

    def lie(self, datum: Any) -> list[Any]:
        """Return the falsified batch."""
        is_batch = isinstance(datum, PairBatch | ResultBatch) and len(datum) > _BEAT
        return [type(self).falsify(datum) if is_batch else datum]


def _with_rows(choose: Callable[[np.ndarray], np.ndarray]) -> Callable[[ResultBatch], ResultBatch]:
    """Return the lie of other results, by their numbers, than there are."""

    def falsify(batch: ResultBatch) -> ResultBatch:
        rows = choose(np.arange(len(batch)))
        return ResultBatch(batch.words[rows], batch.tags[rows], batch.waits[rows], batch.clocks[rows])

    return staticmethod(falsify)


class DroppedResultTest(_SabotagedTest):
    """A result is lost on its way to the scoreboard."""

    honest, falsify = BurstSinkMonitor, _with_rows(lambda rows: np.delete(rows, _BEAT))


class DuplicatedResultTest(_SabotagedTest):
    """A result reaches the scoreboard twice."""

    honest, falsify = BurstSinkMonitor, _with_rows(lambda rows: np.insert(rows, _BEAT, _BEAT))


class ReorderedResultTest(_SabotagedTest):
    """Two results reach the scoreboard in each other's place."""

    honest = BurstSinkMonitor
    falsify = _with_rows(lambda rows: np.r_[rows[: _BEAT - 1], _BEAT, _BEAT - 1, rows[_BEAT + 1 :]])


class CorruptClaimTest(_SabotagedTest):
    """The first clear pair's claim is falsified on its way to the scoreboard."""

    honest = BurstSinkMonitor

    @staticmethod
    def falsify(batch: ResultBatch) -> ResultBatch:
        """Claim another axis."""
        words = batch.words.copy()
        clear = int(np.flatnonzero(words & NEAR == 0)[0])
        words[clear] ^= np.uint16(1 << AXIS_SHIFT)
        return replace(batch, words=words)


class MissingPairTest(_SabotagedTest):
    """The last pair of each batch is not seen by the input monitor."""

    honest, falsify = BurstSourceMonitor, staticmethod(lambda batch: batch[:-1])


class CorruptPairTest(_SabotagedTest):
    """The scoreboard is told of other pairs than the core got."""

    honest = BurstSourceMonitor

    @staticmethod
    def falsify(batch: PairBatch) -> PairBatch:
        """Put a point into the place of each B."""
        batch.pairs[:, 1] = batch.pairs.min()
        return batch


class RaisingChecker(Checker):
    """A checker with a fault of its own, in the worker's thread."""

    def check(self, pairs: PairBatch, results: ResultBatch) -> None:
        """Fail as code does that was not foreseen."""
        raise ZeroDivisionError("the checker is broken")


class RaisingCheckerTest(MixedTest):
    """The checker raises an exception in the worker's thread."""

    def end_of_elaboration_phase(self) -> None:
        """Put the broken checker in the place of the scoreboard's."""
        self.env.scoreboard.checker = RaisingChecker(self.settings.configuration)


class UncheckedScoreboard(Scoreboard):
    """Counts matched pairs and checks none: what the environment costs without its checks."""

    def _enqueue(self, pairs: PairBatch, results: ResultBatch) -> None:
        pass

    def check_phase(self) -> None:
        """Write that nothing was checked, which no sign-off accepts."""
        self.write_counts({"matched": self.matcher.matched, "checked": 0, "failed": 0})


class UncheckedVolumeTest(VolumeTest):
    """The mixture of all families, unchecked."""

    def build_phase(self) -> None:
        """Put the scoreboard that counts in the place of the one that checks."""
        uvm_factory().set_type_override_by_type(Scoreboard, UncheckedScoreboard)
        super().build_phase()
