"""The environment of the engine: three agents, the scoreboard, the coverage subscriber."""

from pyuvm import uvm_env

from triaxis.verif.mesh.coverage_subscriber import MeshCoverageSubscriber
from triaxis.verif.mesh.load_agent import LoadAgent
from triaxis.verif.mesh.result_agent import ResultAgent
from triaxis.verif.mesh.run_agent import RunAgent
from triaxis.verif.mesh.scoreboard import MeshScoreboard
from triaxis.verif.testbench.handles import create


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
        board = self.scoreboard
        self.load.monitor.ap.connect(board.loads_export)
        self.run_agent.monitor.ap.connect(board.runs_export)
        self.results.near.ap.connect(board.near_export)
        self.results.core.ap.connect(board.core_export)
        self.results.summary.ap.connect(board.summaries_export)
        self.run_agent.driver.traffic_ap.connect(self.results.ready.analysis_export)
        board.checked_port.connect(self.coverage.analysis_export)
