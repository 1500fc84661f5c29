"""Tests whose monitors lie: they must fail, which shows that the scoreboard's checks can."""

from collections.abc import Callable
from typing import Any

import numpy as np
from pyuvm import uvm_factory

from triaxis.verif.agents.burst_agent import BurstSinkMonitor, BurstSourceMonitor
from triaxis.verif.batches import PairBatch, ResultBatch
from triaxis.verif.result import AXIS_SHIFT, NEAR
from triaxis.verif.testlist.tests import MixedTest

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
    """Sees pairs that lie apart where the core was sent others."""

    def build_phase(self) -> None:
        """Put the lie in front of the analysis port."""
        super().build_phase()
        publish = self.ap.write

        def write(datum: Any) -> None:
            if isinstance(datum, PairBatch):
                pairs = datum.pairs.copy()
                # A point, far from everything but what is as far.
                pairs[:, 1] = pairs.min()
                datum = PairBatch(pairs, datum.margins, datum.tags, datum.waits)
            publish(datum)

        self.ap.write = write


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


class CorruptClaimTest(_SabotagedTest):
    """A claim is falsified on its way to the scoreboard."""

    honest, liar = BurstSinkMonitor, CorruptClaimSinkMonitor


class CorruptPairTest(_SabotagedTest):
    """The scoreboard is told of other pairs than the core got."""

    honest, liar = BurstSourceMonitor, CorruptPairSourceMonitor
