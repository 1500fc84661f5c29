"""The environment: two agents, the scoreboard, the coverage subscriber."""

from pyuvm import uvm_env

from triaxis.verif.core.coverage_subscriber import CoverageSubscriber
from triaxis.verif.core.scoreboard import Scoreboard
from triaxis.verif.core.sink_agent import SinkAgent
from triaxis.verif.core.source_agent import SourceAgent
from triaxis.verif.testbench.handles import create


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
