"""One simulation of a regression, before it has run: what it is, and how the process that runs it is told."""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.verif.testbench.settings import BURST, PIN, RunSettings
from triaxis.verif.testbench.simulation import run_settings


@dataclass(frozen=True)
class PlannedRun:
    """A test in a configuration with a seed; ``item``: the test of the Hjson file that it comes from."""

    item: str
    test: str
    config: str
    seed: int
    pairs: int
    agent: str
    judged_one_in: int

    @property
    def key(self) -> str:
        """Return a name for files that tells this run from every other."""
        return f"{self.test}-{self.config}-{self.agent}-{self.pairs}-{self.judged_one_in}-{self.seed}"

    @property
    def options(self) -> tuple[str, ...]:
        """Return the options that all seeds of the run share."""
        return (f"--pairs {self.pairs}", f"--agent {self.agent}", f"--judged {self.judged_one_in}")

    def settings(self, folder: Path) -> RunSettings:
        """Return what the simulation is asked to do, in ``folder``."""
        return run_settings(
            self.test,
            self.config,
            self.seed,
            self.pairs,
            folder=folder,
            agent=self.agent,
            judged_one_in=self.judged_one_in,
        )


def add_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a run that a test of the Hjson file gives as its run_opts."""
    parser.add_argument("--pairs", type=int, required=True)
    parser.add_argument("--agent", choices=(PIN, BURST), default=BURST)
    parser.add_argument("--judged", type=int, default=1)


def from_dict(content: dict[str, Any]) -> PlannedRun:
    """Return the run that a file holds; raise TypeError or KeyError where it holds none."""
    fields = {name: content[name] for name in PlannedRun.__dataclass_fields__}
    if not all(isinstance(value, str | int) for value in fields.values()):
        raise TypeError("not a run")
    return PlannedRun(**fields)
