"""Tests for measurements only: they cannot sign anything off."""

from pathlib import Path

from pyuvm import uvm_factory

from triaxis.verif.core.scoreboard import Scoreboard, write_counts
from triaxis.verif.core.uvm_tests import VolumeTest
from triaxis.verif.testbench.batches import PairBatch, ResultBatch
from triaxis.verif.testbench.settings import result_file


class UncheckedScoreboard(Scoreboard):
    """Counts matched pairs and checks none: what the environment costs without its checks."""

    def _enqueue(self, pairs: PairBatch, results: ResultBatch) -> None:
        pass

    def check_phase(self) -> None:
        """Write that nothing was checked, which no sign-off accepts."""
        counts = {"matched": self.matcher.matched, "checked": 0, "failed": 0, "seconds": self.seconds}
        write_counts(result_file(Path(self.settings.folder)), counts)


class UncheckedVolumeTest(VolumeTest):
    """The mixture of all families, unchecked."""

    def build_phase(self) -> None:
        """Put the scoreboard that counts in the place of the one that checks."""
        uvm_factory().set_type_override_by_type(Scoreboard, UncheckedScoreboard)
        super().build_phase()
