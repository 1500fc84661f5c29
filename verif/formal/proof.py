"""What a proof is, and what came of it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol


@dataclass(frozen=True)
class Finding:
    """What a proof came to: its problems (none: proved), how much was checked, and where the log is."""

    problems: tuple[str, ...]
    log: Path | None = None
    facts: Mapping[str, int] = field(default_factory=dict)


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
        return not self.finding.problems
