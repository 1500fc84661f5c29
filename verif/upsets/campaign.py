"""Upsets of the whole board, counted by what comes of them, module by module."""

import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass
from math import exp, lgamma, log
from pathlib import Path
from threading import Event, Thread
from typing import Any

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.sim.board_parameters import parse_board_configuration
from triaxis.sim.evidence import write_evidence
from triaxis.sim.validity import Provenance, Sources, provenance
from triaxis.sim.verilate import library
from triaxis.verif.testbench.settings import BOARD_TESTS, BURST, ENTRY
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.upsets.builds import FOLDER, module_of, upset_build
from triaxis.verif.upsets.verdict import Fate, Kind, Upset, upset_files

RESULT = FOLDER / "upsets.json"
TEST = "BoardUpsetsTest"
SOURCES = Sources(("triaxis.verif.upsets.campaign", "triaxis.verif.upsets.upset_test", ENTRY, *BOARD_TESTS))
# A board small enough that so many upsets invert each bit at least once, memories and core among them.
CONFIG, UPSETS = "board_w8_m0_d16_g4_l2", 44_000
# Dangerous ones that are described in full.
_DESCRIBED = 50
_CONFIDENCE = 0.95
_POLL_SECONDS = 1.0
# Of the watchdog, which each upset is to outlive.
_LONGEST = 1_000_000
STUCK = (Kind.STUCK_AT_0, Kind.STUCK_AT_1)


@dataclass(frozen=True)
class Outcome:
    """An upset, in which module, and what came of it; how that showed."""

    upset: Upset
    module: str
    fate: Fate
    how: str


@dataclass(frozen=True)
class Tally:
    """How many upsets there were, and of how many what came."""

    upsets: int
    dangerous: int
    detected: int
    false_stops: int

    @property
    def bound(self) -> float:
        """Return the share of dangerous ones that is not exceeded, with a confidence of 95 %."""
        return most_share(self.dangerous, self.upsets)


def tally(outcomes: Sequence[Outcome]) -> Tally:
    """Return the totals of some upsets."""
    fates = Counter(one.fate for one in outcomes)
    return Tally(len(outcomes), fates[Fate.DANGEROUS], fates[Fate.DETECTED], fates[Fate.FALSE_STOP])


def most_share(found: int, tried: int) -> float:
    """Return the upper end of the one-sided Clopper-Pearson interval (1934): the share of which it would be
    as likely as 5 % to find so few.
    """
    if found >= tried:
        return 1.0

    def so_few(share: float) -> float:
        return sum(
            exp(
                lgamma(tried + 1) - lgamma(k + 1) - lgamma(tried - k + 1)
                + k * log(share) + (tried - k) * log(1 - share)
            )
            for k in range(found + 1)
        )  # fmt: skip

    low, high = found / tried, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if so_few(middle) > 1 - _CONFIDENCE else (low, middle)
    return high


@dataclass(frozen=True)
class UpsetsResult:
    """What came of all upsets of a board. ``problems``: of the run itself; ``bits``: of the design."""

    outcomes: tuple[Outcome, ...]
    config: str
    bits: int
    seed: int
    seconds: float
    problems: tuple[str, ...]
    valid_for: Provenance

    def of(self, *kinds: Kind, running: bool | None = None) -> list[Outcome]:
        """Return what came of some kinds, in runs, between them, or at all times."""
        return [
            one for one in self.outcomes if one.upset.kind in kinds and running in (None, one.upset.running)
        ]

    @property
    def dangerous(self) -> list[Outcome]:
        """Return those that were dangerous."""
        return [one for one in self.outcomes if one.fate is Fate.DANGEROUS]

    @property
    def passed(self) -> bool:
        """Return whether none was dangerous."""
        return not self.problems and not self.dangerous

    @property
    def summary(self) -> str:
        """Return the result in one line."""
        flips, stuck = tally(self.of(Kind.FLIP)), tally(self.of(*STUCK))
        missed = tally(self.of(Kind.MISSED_EDGE))
        shares = [tally(self.of(Kind.FLIP, running=running)) for running in (True, False)]
        within, between = (
            f"{one.dangerous} of {one.upsets} (at most {100 * one.bound:.2f} %)" for one in shares
        )
        return (
            f"bits inverted: dangerous in runs {within}, between runs {between}; {flips.detected} detected, "
            f"{flips.false_stops} false stops; dangerous are {stuck.dangerous} of {stuck.upsets} bits that "
            f"are stuck, {missed.dangerous} of {missed.upsets} edges that are missed"
        )


def by_module(outcomes: Sequence[Outcome]) -> dict[str, Tally]:
    """Return the totals of each module."""
    groups: dict[str, list[Outcome]] = {}
    for one in outcomes:
        groups.setdefault(one.module, []).append(one)
    return {module: tally(groups[module]) for module in sorted(groups)}


def upset_board(
    progress: Callable[[int], None], seed: int = 1, upsets: int = UPSETS, config: str = CONFIG
) -> UpsetsResult:
    """Upset the board so many times; ``progress`` is told how many more are done.

    Raises InputError for a board whose watchdog takes too long.
    """
    if parse_board_configuration(config).watchdog_clocks > _LONGEST:
        raise InputError(
            f"{config}: its watchdog takes more than {_LONGEST} clocks: give one with short times"
        )
    start, before = time.monotonic(), provenance(SOURCES)
    built = library(upset_build(parse_board_configuration(config)))
    settings = run_settings(TEST, config, seed, upsets, folder=FOLDER / "run", agent=BURST)
    folder = Path(settings.folder)
    over, told = Event(), 0

    def tell() -> None:
        nonlocal told
        while not over.wait(_POLL_SECONDS):
            lines = sum(len(_lines(file)) for file in upset_files(folder))
            progress(lines - told)
            told = lines

    # The simulation is in the main thread: who interrupts this ends it.
    telling = Thread(target=tell)
    telling.start()
    try:
        result = run(settings, model=built)
    finally:
        over.set()
        telling.join()
    outcomes = tuple(
        sorted(
            (
                Outcome(Upset(Kind(kind), *what), module_of(what[0]), Fate(fate), how)
                for file in upset_files(folder)
                for kind, *what, fate, how in map(json.loads, _lines(file))
            ),
            key=lambda one: (one.upset.clock, astuple(one.upset)),
        )
    )
    progress(len(outcomes) - told)
    problems = [] if result.passed else [line.strip() for line in result.explain().splitlines()]
    bits = 0
    if result.passed:
        with np.load(folder / "undisturbed.npz") as kept:
            bits = int(kept["bits"])
        if len(outcomes) != upsets:
            problems.append(f"{len(outcomes)} upsets of {upsets} came to an end")
        flips = [one.upset for one in outcomes if one.upset.kind is Kind.FLIP]
        inverted = {(one.register, one.element, one.bit) for one in flips}
        if (config, upsets) == (CONFIG, UPSETS) and len(inverted) < bits:
            problems.append(f"{len(inverted)} of {bits} bits were inverted, not each: raise UPSETS")
    if not before.still_holds(SOURCES):
        problems.append("the RTL, or its environment, changed during the run: run again")
    seconds = time.monotonic() - start
    return UpsetsResult(outcomes, config, bits, seed, seconds, tuple(problems), before)


def write_result(result: UpsetsResult) -> Path:
    """Write the result; InputError where it is none."""
    if result.problems:
        raise InputError(f"upsets: {result.problems[0]}")
    content: dict[str, Any] = {
        "passed": result.passed,
        "problems": [] if result.passed else [f"{len(result.dangerous)} upsets are dangerous"],
        "summary": result.summary,
        "command": f"triaxis prove upsets --seed {result.seed} --upsets {len(result.outcomes)} "
        f"--config {result.config}",
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "config": result.config,
        "bits": result.bits,
        **_row(tally(result.of(Kind.FLIP)), "flips"),
        "in_runs": _bounded(tally(result.of(Kind.FLIP, running=True))),
        "between_runs": _bounded(tally(result.of(Kind.FLIP, running=False))),
        "blocks": {name: _row(of, "flips") for name, of in by_module(result.of(Kind.FLIP)).items()},
        "stuck": _blocks(result.of(*STUCK)),
        "missed_edges": _blocks(result.of(Kind.MISSED_EDGE)),
        "examples": [_described(one) for one in result.dangerous[:_DESCRIBED]],
        **asdict(result.valid_for),
    }
    return write_evidence(RESULT, content, SOURCES)


def _described(one: Outcome) -> dict[str, Any]:
    return {
        **asdict(one.upset), "kind": one.upset.kind.name, "module": one.module, "fate": one.fate,
        "how": one.how,
    }  # fmt: skip


def _row(of: Tally, name: str = "upsets") -> dict[str, int]:
    row = asdict(of)
    return {name: row.pop("upsets"), **row}


def _bounded(of: Tally) -> dict[str, float]:
    return {**_row(of, "flips"), "dangerous_share_at_most": of.bound}


def _blocks(outcomes: Sequence[Outcome]) -> dict[str, Any]:
    blocks = {name: _row(of) for name, of in by_module(outcomes).items()}
    return {**_row(tally(outcomes)), "blocks": blocks}


def _lines(file: Path) -> list[str]:
    """Return the lines that are whole."""
    return file.read_text().split("\n")[:-1] if file.exists() else []
