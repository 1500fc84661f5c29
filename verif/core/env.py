"""The environment: two agents, the scoreboard, the coverage subscriber."""

from pathlib import Path

from pyuvm import uvm_env, uvm_subscriber

from triaxis.coverage.core_coverage import CoreCoverage
from triaxis.coverage.core_sample import CoreSample
from triaxis.verif.core.pin_agents import SinkAgent, SourceAgent
from triaxis.verif.core.scoreboard import Scoreboard
from triaxis.verif.testbench.environment import create, settings_of
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
        self.coverage = CoreCoverage(self.settings.configuration)
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


class CoreEnv(uvm_env):
    """Everything around the core."""

    def build_phase(self) -> None:
        """Make the parts."""
        self.source = create(SourceAgent, "source", self)
        self.sink = create(SinkAgent, "sink", self)
        self.scoreboard = create(Scoreboard, "scoreboard", self)
        self.coverage = create(CoverageSubscriber, "coverage", self)

    def connect_phase(self) -> None:
        """Connect monitors to the scoreboard, the scoreboard to coverage, and stalls to the sink."""
        self.source.monitor.ap.connect(self.scoreboard.pairs_export)
        self.sink.monitor.ap.connect(self.scoreboard.results_export)
        self.source.driver.stalls_ap.connect(self.sink.ready.analysis_export)
        self.scoreboard.checked_port.connect(self.coverage.analysis_export)

    def flush(self) -> None:
        """Publish what the monitors still hold."""
        self.source.monitor.flush()
        self.sink.monitor.flush()
