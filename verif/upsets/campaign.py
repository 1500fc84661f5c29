"""Upsets of the whole board, counted by what comes of them, module by module."""

import json
import time
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, astuple, dataclass
from math import exp, lgamma, log
from pathlib import Path
from threading import Event, Thread
from typing import Any

import numpy as np
from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder, write_whole
from triaxis.sim.board_parameters import parse_board_configuration
from triaxis.sim.evidence import write_evidence
from triaxis.sim.validity import Provenance, Sources, Standing, standing
from triaxis.sim.verilate import library
from triaxis.verif.testbench.settings import BOARD_TESTS, BURST, ENTRY
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.upsets.builds import FOLDER, MEASURES, Measure, module_of, upset_build
from triaxis.verif.upsets.fmeda import BlockCounts, block_of, plot, table
from triaxis.verif.upsets.verdict import Fate, Kind, Upset, upset_files, upset_of, write_upsets

RESULT = FOLDER / "upsets.json"
# The table of failure modes, and what each measure brings.
TABLE, PLOT = FOLDER / "fmeda.md", FOLDER / "measures.svg"
TEST = "BoardUpsetsTest"
SOURCES = Sources(
    ("triaxis.verif.upsets.campaign", "triaxis.verif.upsets.upset_test", ENTRY, *BOARD_TESTS),
    ("verif/upsets/without/*.patch",),
)
# A board small enough that so many upsets invert each flip-flop at least once, and most bits of memories.
CONFIG, UPSETS = "board_w8_m0_d16_g4_l2", 33_000
# Dangerous ones that are described in full.
_DESCRIBED = 50
_CONFIDENCE = 0.95
_POLL_SECONDS = 1.0
# Of so many upsets one is tried again without the measures.
_WITHOUT_ONE_IN = 5
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
    """What came of all upsets of a board. ``problems``: of the run; ``bits``: of the design, by register.

    ``without``: of upsets without all measures; ``left``: how many of those that are dangerous then are left
    with the measures up to this one.
    """

    outcomes: tuple[Outcome, ...]
    without: tuple[Outcome, ...]
    left: dict[str, int]
    config: str
    bits: Mapping[str, int]
    seed: int
    seconds: float
    problems: tuple[str, ...]
    valid_for: Provenance

    def of(self, *kinds: Kind, running: bool | None = None) -> list[Outcome]:
        """Return what came of some kinds, in runs, between them, or at all times."""
        return _of(self.outcomes, *kinds, running=running)

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
            f"are stuck, {missed.dangerous} of {missed.upsets} edges that are missed; without the measures "
            f"{self._without.dangerous} of {self._without.upsets} upsets are dangerous"
        )

    @property
    def _without(self) -> Tally:
        return tally(self.without)


def _of(outcomes: Sequence[Outcome], *kinds: Kind, running: bool | None = None) -> list[Outcome]:
    return [one for one in outcomes if one.upset.kind in kinds and running in (None, one.upset.running)]


def by_module(outcomes: Sequence[Outcome]) -> dict[str, Tally]:
    """Return the totals of each module."""
    groups: dict[str, list[Outcome]] = {}
    for one in outcomes:
        groups.setdefault(one.module, []).append(one)
    return {module: tally(groups[module]) for module in sorted(groups)}


def by_block(result: UpsetsResult) -> dict[str, BlockCounts]:
    """Return the counts of each block of `fmeda.BLOCKS` that there is."""
    bits = Counter[str]()
    for register, count in result.bits.items():
        bits[block_of(register)] += count
    found: dict[str, BlockCounts] = {}
    for name, count in bits.items():
        some, without = (
            tally([one for one in outcomes if block_of(one.upset.register) == name])
            for outcomes in (result.outcomes, result.without)
        )
        noticed = some.detected + some.false_stops
        found[name] = BlockCounts(
            count, some.upsets, some.dangerous, noticed, without.upsets, without.dangerous
        )
    return found


def upset_board(
    progress: Callable[[int], None], seed: int = 1, upsets: int = UPSETS, config: str = CONFIG
) -> UpsetsResult:
    """Upset the board so many times, with its measures, and again some of these times without them.

    What is dangerous without them is tried again with more and more of them. ``progress`` is told how many
    more are done, of ``upsets``. Waits while another process does. Raises InputError for a board whose
    watchdog takes too long.
    """
    if parse_board_configuration(config).watchdog_clocks > _LONGEST:
        raise InputError(
            f"{config}: its watchdog takes more than {_LONGEST} clocks: give one with short times"
        )
    # Before it may wait for another campaign: what is loaded here is of now.
    before = standing(SOURCES)
    make_folder(FOLDER)
    # Two campaigns at once would write each other's runs.
    with FileLock(FOLDER / ".lock"):
        return _upset_board(progress, seed, upsets, config, before)


def _upset_board(
    progress: Callable[[int], None], seed: int, upsets: int, config: str, before: Standing
) -> UpsetsResult:
    start = time.monotonic()
    campaign = _Campaign(config, seed, progress)
    outcomes = campaign.run(upsets)
    some = [one.upset for one in outcomes][::_WITHOUT_ONE_IN]
    without = campaign.run(len(some), MEASURES, some)
    dangerous = [one.upset for one in without if one.fate is Fate.DANGEROUS]
    left = {"none": len(dangerous)}
    for number, measure in enumerate(MEASURES, 1):
        again = campaign.run(len(dangerous), MEASURES[number:], dangerous) if dangerous else ()
        left[measure.name] = tally(again).dangerous
    problems = list(campaign.problems)
    if not dangerous:
        problems.append("nothing is dangerous without the measures: the campaign measures nothing")
    if is_whole(config, upsets) and len(_flips(outcomes)) < campaign.flip_flops:
        problems.append(f"there are {campaign.flip_flops} flip-flops, not each was inverted: raise UPSETS")
    if not before.stands:
        problems.append("the RTL, or its environment, changed during the run: run again")
    seconds = time.monotonic() - start
    return UpsetsResult(
        outcomes, without, left, config, campaign.bits, seed, seconds, tuple(problems), before.valid_for
    )


def is_whole(config: str, upsets: int) -> bool:
    """Return whether a campaign measures what its result in build/ is to say."""
    return config == CONFIG and upsets >= UPSETS


def _flips(outcomes: Sequence[Outcome]) -> list[Upset]:
    return [one.upset for one in outcomes if one.upset.kind is Kind.FLIP]


class _Campaign:
    """Runs of the test on the board, with some measures or all. ``bits``: of the design, by register."""

    def __init__(self, config: str, seed: int, progress: Callable[[int], None]) -> None:
        """Begin with nothing run."""
        self._config, self._seed, self._progress = config, seed, progress
        self.problems: list[str] = []
        self.bits: dict[str, int] = {}
        self.flip_flops = 0

    def run(
        self, count: int, taken_away: Sequence[Measure] = (), upsets: Sequence[Upset] = ()
    ) -> tuple[Outcome, ...]:
        """Return what came of so many upsets, drawn at random unless they are given."""
        built = library(upset_build(parse_board_configuration(self._config), taken_away))
        replay = ""
        if upsets:
            replay = str(FOLDER / "again.jsonl")
            write_upsets(upsets, Path(replay))
        folder = FOLDER / "run"
        settings = run_settings(
            TEST, self._config, self._seed, count, folder=folder, replay=replay, agent=BURST
        )
        over, told = Event(), 0

        def tell() -> None:
            nonlocal told
            while not over.wait(_POLL_SECONDS):
                lines = sum(len(_lines(file)) for file in upset_files(folder))
                self._progress(lines - told)
                told = lines

        # The simulation is in the main thread: who interrupts this ends it.
        telling = Thread(target=tell)
        if not upsets:
            telling.start()
        try:
            result = run(settings, model=built)
        finally:
            over.set()
            if not upsets:
                telling.join()
        outcomes = tuple(
            sorted(
                (
                    Outcome(upset, module_of(upset.register), Fate(fate), how)
                    for file in upset_files(folder)
                    for *row, fate, how in map(json.loads, _lines(file))
                    for upset in (upset_of(row),)
                ),
                key=lambda one: (one.upset.clock, astuple(one.upset)),
            )
        )
        if not upsets:
            self._progress(len(outcomes) - told)
        if not result.passed:
            # No command that repeats it: the test by itself has no upsets.
            self.problems += [f"{TEST} failed", *result.errors, f"log: {result.log}"]
            return outcomes
        with np.load(folder / "undisturbed.npz") as kept:
            names, sizes = kept["names"].tolist(), kept["sizes"]
            self.bits = dict(zip(names, sizes.prod(1).tolist(), strict=True))
            self.flip_flops = int(sizes[sizes[:, 0] == 1, 1].sum())
        if len(outcomes) != count:
            self.problems.append(f"{len(outcomes)} upsets of {count} came to an end")
        return outcomes


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
        "bits": sum(result.bits.values()),
        **_row(tally(result.of(Kind.FLIP)), "flips"),
        "in_runs": _bounded(tally(result.of(Kind.FLIP, running=True))),
        "between_runs": _bounded(tally(result.of(Kind.FLIP, running=False))),
        "blocks": {name: asdict(of) for name, of in by_block(result).items()},
        "modules": {name: _row(of, "flips") for name, of in by_module(result.of(Kind.FLIP)).items()},
        "stuck": _blocks(result.of(*STUCK)),
        "missed_edges": _blocks(result.of(Kind.MISSED_EDGE)),
        "without_measures": {
            **_row(tally(_of(result.without, Kind.FLIP)), "flips"),
            "in_runs": _bounded(tally(_of(result.without, Kind.FLIP, running=True))),
            "between_runs": _bounded(tally(_of(result.without, Kind.FLIP, running=False))),
            "modules": {
                name: _row(of, "flips") for name, of in by_module(_of(result.without, Kind.FLIP)).items()
            },
            "stuck": _blocks(_of(result.without, *STUCK)),
            "missed_edges": _blocks(_of(result.without, Kind.MISSED_EDGE)),
        },
        "dangerous_with_measures_up_to": result.left,
        "examples": [_described(one) for one in result.dangerous[:_DESCRIBED]],
        **asdict(result.valid_for),
    }
    write_whole(TABLE, table(by_block(result)))
    write_whole(PLOT, plot(result.left))
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
