"""The environment of the engine: three agents, the scoreboard, the coverage subscriber."""

from pathlib import Path

from pyuvm import uvm_env, uvm_subscriber

from triaxis.coverage.mesh_coverage import MeshCoverage
from triaxis.coverage.mesh_sample import MeshRow
from triaxis.verif.mesh.pin_agents import LoadAgent, ResultAgent, RunAgent
from triaxis.verif.mesh.sampling import mesh_build
from triaxis.verif.mesh.scoreboard import MeshScoreboard
from triaxis.verif.testbench.environment import create, settings_of
from triaxis.verif.testbench.settings import coverage_file

# Runs counted at a time: a call has a cost of its own.
_BATCH = 256


class MeshCoverageSubscriber(uvm_subscriber):
    """Counts bins of the coverage model of the engine's configuration, and writes them at the end."""

    def build_phase(self) -> None:
        """Start with empty counts."""
        self.settings = settings_of(self)
        self.coverage = MeshCoverage(mesh_build(self.settings.mesh_configuration))
        self.rows: list[MeshRow] = []

    def write(self, tt: MeshRow) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Take a run."""
        self.rows.append(tt)
        if len(self.rows) == _BATCH:
            self._count()

    def _count(self) -> None:
        self.coverage.sample(self.rows)
        self.rows = []

    def report_phase(self) -> None:
        """Write the counts."""
        self._count()
        self.coverage.counts.save(coverage_file(Path(self.settings.folder)))


class MeshEnv(uvm_env):
    """Everything around the engine."""

    def build_phase(self) -> None:
        """Make the parts."""
        self.load = create(LoadAgent, "load", self)
        self.run_agent = create(RunAgent, "run", self)
        self.results = create(ResultAgent, "results", self)
        self.scoreboard = create(MeshScoreboard, "scoreboard", self)
        self.coverage = create(MeshCoverageSubscriber, "coverage", self)

    def connect_phase(self) -> None:
        """Connect monitors to the scoreboard, the scoreboard to coverage, and stalls to the results."""
        scoreboard = self.scoreboard
        self.load.monitor.ap.connect(scoreboard.loads_export)
        self.run_agent.monitor.ap.connect(scoreboard.runs_export)
        self.results.near.ap.connect(scoreboard.near_export)
        self.results.core.ap.connect(scoreboard.core_export)
        self.results.summary.ap.connect(scoreboard.summaries_export)
        self.run_agent.driver.traffic_ap.connect(self.results.ready.analysis_export)
        scoreboard.checked_port.connect(self.coverage.analysis_export)
