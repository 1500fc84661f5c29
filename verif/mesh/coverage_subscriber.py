"""Samples functional coverage from the runs that the scoreboard checked."""

from pathlib import Path

from pyuvm import uvm_subscriber

from triaxis.coverage.mesh_coverage import MeshCoverage
from triaxis.coverage.mesh_sample import MeshRow
from triaxis.verif.mesh.sampling import mesh_build
from triaxis.verif.testbench.handles import settings_of
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
