"""The environment of the board: the agent of its line, the scoreboard, the coverage subscriber."""

from pathlib import Path

from pyuvm import uvm_env, uvm_subscriber

from triaxis.coverage.board_coverage import BoardCoverage, Happened
from triaxis.verif.board.line_agent import LineAgent
from triaxis.verif.board.scoreboard import BoardScoreboard
from triaxis.verif.testbench.environment import create, settings_of
from triaxis.verif.testbench.settings import coverage_file


class BoardCoverageSubscriber(uvm_subscriber):
    """Counts bins of the board's coverage model, and writes them at the end."""

    def build_phase(self) -> None:
        """Start with empty counts."""
        self.coverage = BoardCoverage()
        self.happened: list[Happened] = []

    def write(self, tt: Happened) -> None:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Take what happened."""
        self.happened.append(tt)

    def report_phase(self) -> None:
        """Write the counts."""
        self.coverage.sample(self.happened)
        self.coverage.counts.save(coverage_file(Path(settings_of(self).folder)))


class BoardEnv(uvm_env):
    """Everything around the board."""

    def build_phase(self) -> None:
        """Make the parts."""
        self.line = create(LineAgent, "line", self)
        self.scoreboard = create(BoardScoreboard, "scoreboard", self)
        self.coverage = create(BoardCoverageSubscriber, "coverage", self)

    def connect_phase(self) -> None:
        """Connect the monitor to the scoreboard, and that to coverage."""
        self.line.monitor.ap.connect(self.scoreboard.seen_export)
        self.scoreboard.checked_port.connect(self.coverage.analysis_export)
