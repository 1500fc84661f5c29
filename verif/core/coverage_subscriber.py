"""Samples functional coverage from what the scoreboard checked."""

from pathlib import Path

from pyuvm import uvm_subscriber

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.core_sample import CoreSample
from triaxis.verif.testbench.handles import settings_of
from triaxis.verif.testbench.settings import coverage_file

# In a soak every so many batches one is sampled.
_SOAK_EVERY = 8


class CoverageSubscriber(uvm_subscriber):
    """Counts bins of the coverage model of the core's configuration, and writes them at the end.

    Samples come from the worker's thread, in order; the phases run when it has ended.
    """

    def build_phase(self) -> None:
        """Start with empty counts."""
        self.settings = settings_of(self)
        self.coverage = CoreCoverage(*self.settings.configuration.covered)
        self.every = _SOAK_EVERY if self.settings.soak else 1
        self.batches = 0

    def write(self, tt: CoreSample) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Sample a batch."""
        if self.batches % self.every == 0:
            self.coverage.sample(tt)
        self.batches += 1

    def report_phase(self) -> None:
        """Write the counts."""
        self.coverage.counts.save(coverage_file(Path(self.settings.folder)))
