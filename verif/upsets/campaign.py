"""Upsets of the whole board, counted by what comes of them, module by module."""

import json
import time
from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, dataclass
from functools import cached_property
from math import exp, lgamma, log
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.sim.board_parameters import parse_board_configuration
from triaxis.sim.build import rtl_hash
from triaxis.sim.evidence import write_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Sources
from triaxis.sim.verilate import library
from triaxis.verif.testbench.settings import BOARD_TESTS, BURST, ENTRY
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.upsets.builds import FOLDER, module_of, upset_build
from triaxis.verif.upsets.verdict import Fate, Kind, upset_files

RESULT = FOLDER / "upsets.json"
TEST = "BoardUpsetsTest"
SOURCES = Sources(
    ("triaxis.verif.upsets.campaign", "triaxis.verif.upsets.upset_test", ENTRY, *BOARD_TESTS),
    ("dut/board/*.f", "fpga/nexys4ddr_top.sv"),
)  # fmt: skip
# A board small enough that so many upsets are one of each bit at least, memories and core among them.
CONFIG, UPSETS = "board_w8_m0_d16_g4_l2", 40_000
# Dangerous ones that are described in full.
_DESCRIBED = 50
_CONFIDENCE = 0.95
_POLL_SECONDS = 1.0


@dataclass(frozen=True)
class Outcome:
    """An upset, before which clock of the talk, in which module, and what came of it; how that showed."""

    kind: Kind
    module: str
    register: str
    element: int
    bit: int
    clock: int
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
    """What came of all upsets. ``problems``: of the run itself."""

    outcomes: tuple[Outcome, ...]
    config: str
    seed: int
    seconds: float
    problems: tuple[str, ...]

    @cached_property
    def kinds(self) -> dict[Kind, Tally]:
        """Return the totals of each kind."""
        return {kind: tally([one for one in self.outcomes if one.kind is kind]) for kind in Kind}

    def blocks(self, kind: Kind) -> dict[str, Tally]:
        """Return the totals of a kind in each module."""
        groups: dict[str, list[Outcome]] = {}
        for one in self.outcomes:
            if one.kind is kind:
                groups.setdefault(one.module, []).append(one)
        return {module: tally(groups[module]) for module in sorted(groups)}

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
        flips, others = self.kinds[Kind.FLIP], (self.kinds[Kind.STICK], self.kinds[Kind.MISS])
        return (
            f"{flips.upsets} bits inverted: {flips.dangerous} dangerous (with 95 % confidence at most "
            f"{100 * flips.bound:.3f} %), {flips.detected} detected, {flips.false_stops} false stops; "
            f"{others[0].dangerous} of {others[0].upsets} that stick and {others[1].dangerous} of "
            f"{others[1].upsets} edges that are missed are dangerous"
        )


def upset_board(
    progress: Callable[[int], None], seed: int = 1, upsets: int = UPSETS, config: str = CONFIG
) -> UpsetsResult:
    """Upset the board so many times; ``progress`` is told how many more are done."""
    start, rtl = time.monotonic(), rtl_hash(DUT)
    built = library(upset_build(parse_board_configuration(config)))
    settings = run_settings(TEST, config, seed, upsets, folder=FOLDER / "run", agent=BURST)
    done = 0
    with ThreadPoolExecutor(1) as pool:
        running = pool.submit(run, settings, model=built)
        while True:
            try:
                result = running.result(_POLL_SECONDS)
                break
            except TimeoutError:
                lines = sum(len(_lines(file)) for file in upset_files(Path(settings.folder)))
                progress(lines - done)
                done = lines
    outcomes = tuple(
        Outcome(Kind[kind], module_of(register), register, element, bit, clock, Fate(fate), how)
        for file in upset_files(Path(settings.folder))
        for kind, register, element, bit, clock, fate, how in map(json.loads, _lines(file))
    )
    progress(len(outcomes) - done)
    problems = [] if result.passed else [line.strip() for line in result.explain().splitlines()]
    if result.passed and len(outcomes) != upsets:
        problems.append(f"{len(outcomes)} upsets of {upsets} came to an end")
    if rtl_hash(DUT) != rtl:
        problems.append("the RTL changed during the run: run again")
    return UpsetsResult(outcomes, config, seed, time.monotonic() - start, tuple(problems))


def _counts(result: UpsetsResult, kind: Kind) -> dict[str, Any]:
    total = result.kinds[kind]
    blocks = {module: _row(of) for module, of in result.blocks(kind).items()}
    return {**_row(total), "dangerous_share_at_most": total.bound, "blocks": blocks}


def _row(of: Tally) -> dict[str, int]:
    row = asdict(of)
    return {"flips": row.pop("upsets"), **row}


def _lines(file: Path) -> list[str]:
    """Return the lines that are whole."""
    return file.read_text().split("\n")[:-1] if file.exists() else []


def write_result(result: UpsetsResult) -> Path:
    """Write the result; InputError where it is none."""
    if result.problems:
        raise InputError(f"upsets: {result.problems[0]}")
    content: dict[str, Any] = {
        "passed": result.passed,
        "problems": [] if result.passed else [f"{len(result.dangerous)} upsets are dangerous"],
        "summary": result.summary,
        "command": f"triaxis prove upsets --seed {result.seed} --upsets {len(result.outcomes)}",
        "seconds": round(result.seconds, 1),
        "seed": result.seed,
        "config": result.config,
        **_counts(result, Kind.FLIP),
        "stuck": _counts(result, Kind.STICK),
        "missed_edges": _counts(result, Kind.MISS),
        "examples": [{**asdict(one), "kind": one.kind.name.lower()} for one in result.dangerous[:_DESCRIBED]],
    }
    return write_evidence(RESULT, content, SOURCES)
