"""What a proof is, and what came of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path
from typing import Protocol


class Result(StrEnum):
    """What can come of a proof."""

    PROVED = "proved"
    # The prover came to its end, and found something against the claim or the argument for it.
    FAILED = "failed"
    # A tool did not come to its end: no word about the RTL.
    UNDECIDED = "not decided"


@dataclass(frozen=True)
class Finding:
    """What speaks against a claim, and what no tool decided, a line each; where there is neither: proved.

    ``facts``: how much was checked.
    """

    problems: tuple[str, ...] = ()
    log: Path | None = None
    facts: Mapping[str, int] = field(default_factory=dict)
    undecided: tuple[str, ...] = ()

    @property
    def result(self) -> Result:
        """Return what came of the proof."""
        if self.problems:
            return Result.FAILED
        return Result.UNDECIDED if self.undecided else Result.PROVED


class Proof(Protocol):
    """A claim with a way to prove it."""

    @property
    def name(self) -> str:
        """Return its name."""
        ...

    @property
    def claim(self) -> str:
        """Return what is proved, in a sentence."""
        ...

    @property
    def method(self) -> str:
        """Return how it is proved."""
        ...

    @property
    def parameters(self) -> Mapping[str, int | str]:
        """Return what it holds for."""
        ...

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Return what it takes for granted, a sentence each."""
        ...

    def prove(self, dut: Path, folder: Path) -> Finding:
        """Prove it of a folder of RTL; ``folder`` takes logs and traces."""
        ...


@dataclass(frozen=True)
class Outcome:
    """A proof and what came of it, in so many seconds."""

    proof: Proof
    finding: Finding
    seconds: float

    @property
    def passed(self) -> bool:
        """Return whether it is proved."""
        return self.finding.result is Result.PROVED
