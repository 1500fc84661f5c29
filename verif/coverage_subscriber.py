"""Samples functional coverage from what the scoreboard checked."""

from pathlib import Path

from pyuvm import uvm_subscriber

from triaxis.coverage.core_model import CORE_MODEL, CoreSample
from triaxis.coverage.covergroup import Counts
from triaxis.golden.axes import separating
from triaxis.verif.handles import settings_of
from triaxis.verif.matching import AXES_WITHOUT_EDGE_BOX, CheckedBatch
from triaxis.verif.settings import coverage_file


class CoverageSubscriber(uvm_subscriber):
    """Counts bins of the core's coverage model, and writes them at the end."""

    def build_phase(self) -> None:
        """Start with empty counts."""
        self.settings = settings_of(self)
        self.counts = Counts.empty(CORE_MODEL)

    def write(self, tt: CheckedBatch) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Sample a batch."""
        configuration = self.settings.configuration
        separates = separating(tt.pairs, tt.margins)
        if not configuration.edge_box:
            # Axes that this core does not have decide nothing.
            separates[:, AXES_WITHOUT_EDGE_BOX:] = False
        sample = CoreSample(
            tt.pairs,
            tt.margins,
            tt.expected["near"],
            separates,
            tt.waits_in,
            tt.waits_out,
            configuration.width,
            configuration.max_margin,
        )
        self.counts.sample(CORE_MODEL, sample)

    def report_phase(self) -> None:
        """Write the counts."""
        self.counts.save(coverage_file(Path(self.settings.folder)))
