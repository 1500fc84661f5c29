"""What trying a fault gave, what became of all that were tried, and the file that says so."""

from collections.abc import Callable
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from triaxis.sim.evidence import write_evidence
from triaxis.sim.validity import Provenance, Sources
from triaxis.verif.faults.faulty_rtl import FOLDER
from triaxis.verif.faults.known_faults import FAULTS, Fault
from triaxis.verif.testbench.settings import TEST_DATA, TEST_MODULES

RESULT = FOLDER / "faults.json"
SOURCES = Sources(
    ("triaxis.verif.faults.catching", "triaxis.verif.faults.fault_tests", *TEST_MODULES),
    ("verif/faults/patches/*.patch", *TEST_DATA),
)


@dataclass(frozen=True)
class Example:
    """A pair that is answered wrongly, as found and as small as it gets.

    ``sent``: what a fresh core is sent, the last pair of which fails: margin, A, B each; ``normals``: those
    handed to the wrapper; ``picture``: its file, from the checkout's root, None where nothing is drawn.
    """

    before: str
    after: str
    meaning: str
    core_said: str
    right: str
    sent: list[dict[str, Any]]
    normals: list[list[int]] | None = None
    picture: str | None = None


@dataclass(frozen=True)
class Catch:
    """How a fault was caught: ``test`` failed with ``message``.

    ``pairs``: up to and including the first that failed, in that test; None where no pair was answered
    wrongly. ``clocks``: until a rule fired, None where none did. ``missed_by``: the tests that passed before,
    with ``pairs_before`` pairs.
    """

    test: str
    message: str
    pairs: int | None = None
    clocks: int | None = None
    missed_by: tuple[str, ...] = ()
    pairs_before: int = 0
    replay: str | None = None


@dataclass(frozen=True)
class Outcome:
    """What became of one fault; ``catch`` is None where nothing caught it, and ``reason`` says why."""

    fault: Fault
    seed: int
    seconds: float
    catch: Catch | None
    example: Example | None = None
    reason: str | None = None

    @property
    def caught(self) -> bool:
        """Return whether it was caught."""
        return self.catch is not None

    def record(self) -> dict[str, Any]:
        """Return the fault's entry of the result file."""
        catch = self.catch
        return {
            "name": self.fault.name,
            "title": self.fault.title,
            "what_it_was": self.fault.story,
            "kind": self.fault.kind.name.lower(),
            "config": self.fault.config,
            "caught": self.caught,
            "test": catch.test if catch else None,
            "seed": self.seed,
            "pairs": catch.pairs if catch else None,
            "clocks": catch.clocks if catch else None,
            "missed_by": list(catch.missed_by) if catch else None,
            "pairs_before": catch.pairs_before if catch else None,
            "message": catch.message if catch else self.reason,
            "replay": catch.replay if catch else None,
            "counterexample": asdict(self.example) if self.example else None,
            "seconds": round(self.seconds, 1),
        }


@dataclass(frozen=True)
class FaultsResult:
    """What became of the faults; ``control``: what the same procedure finds wrong where nothing is.

    ``changed``: what it is valid for was written to during the run.
    """

    outcomes: list[Outcome]
    control: list[str]
    valid_for: Provenance
    changed: bool
    seed: int
    seconds: float

    @cached_property
    def problems(self) -> list[str]:
        """Return the reasons for a failure, one line each."""
        found = [
            f"{o.fault.name} ({o.fault.title}) is not caught: {o.reason}"
            for o in self.outcomes
            if not o.caught
        ]
        found += [
            f"{o.fault.name} is caught without a counterexample"
            for o in self.outcomes
            if o.catch and o.catch.pairs is not None and o.example is None
        ]
        found += [f"without a fault: {problem}" for problem in self.control]
        if not self.outcomes:
            found.append("no fault was tried")
        if self.changed:
            found.append("the RTL, or its environment, changed during the run")
        return found

    @property
    def passed(self) -> bool:
        """Return whether every fault was caught, and nothing where there is none."""
        return not self.problems

    @property
    def complete(self) -> bool:
        """Return whether every fault that a sign-off asks for was tried."""
        return {fault.name for fault in FAULTS if fault.signed_off} <= {o.fault.name for o in self.outcomes}

    @property
    def further(self) -> bool:
        """Return whether further faults were tried too."""
        return any(not outcome.fault.signed_off for outcome in self.outcomes)

    @property
    def summary(self) -> str:
        """Return the result in one line."""
        caught = sum(outcome.caught for outcome in self.outcomes)
        return f"{caught} of {len(self.outcomes)} faults caught"


def write_json(result: FaultsResult, path: Path | None = None) -> Path:
    """Write the result, whole or not at all; ValueError where a sign-off's faults were not all tried."""
    if not result.complete:
        raise ValueError("faults: a restricted run is no evidence")
    content = {
        "passed": result.passed,
        "problems": result.problems,
        "summary": result.summary,
        "command": f"triaxis prove faults --seed {result.seed}{' --all' if result.further else ''}",
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "control": {"passed": not result.control, "problems": result.control},
        "faults": [outcome.record() for outcome in result.outcomes],
        **asdict(result.valid_for),
    }
    return write_evidence(path or RESULT, content, SOURCES)


def _no_example() -> None:
    return None


@dataclass(frozen=True)
class Attempt:
    """``catch`` is None where nothing caught the fault, and ``reason`` says why.

    ``clean``: all that was tried ended well, and passed. ``example`` makes the counterexample, in the main
    thread; None where there is none.
    """

    catch: Catch | None
    reason: str | None = None
    clean: bool = False
    example: Callable[[], Example | None] = _no_example
