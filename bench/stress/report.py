"""``triaxis bench stress``: what is told of wrong answers."""

import argparse
from functools import partial
from typing import Any

from rich.table import Table

from triaxis.bench import harness
from triaxis.bench.harness import Findings, report, told
from triaxis.bench.stress.measuring import (
    ROUNDING_WIDTH,
    STEPS,
    WIDTHS,
    FamilyResult,
    SettingResult,
    StressResult,
    run_stress,
)
from triaxis.bench.stress.orders import METHODS
from triaxis.bench.stress.plot import PICTURES, figure_of
from triaxis.golden.errors import InputError
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import progress_bar, table
from triaxis.verif.core.stimulus.symmetry import NUM_ORDERS

# At each setting. A rate of 0.1 % is 4 of these; with fewer than the least it would hardly ever be seen.
PAIRS, LEAST_PAIRS, MOST_PAIRS = 4000, 100, 100_000
# From this share of wrong answers on, a method is said to fail.
_FAILS = 0.001
_RATES = ("wrong_rate", "changing_rate")


def add_stress(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``bench stress``."""
    parser.description = (
        "Families of pairs with one knob each, turned from easy to impossible: the core as simulated, its "
        "no-miss mode, and three published tests in float32 and float64, in all 72 orders of each pair, "
        f"against exact verdicts. Rounded pairs are for {ROUNDING_WIDTH} bits. Writes "
        "build/bench/stress.json, and pictures of errors, of order-dependence and of rounding."
    )
    add_seed(parser)
    parser.add_argument(
        "--pairs", type=int, default=PAIRS, metavar="N", help=f"pairs at each setting ({PAIRS})"
    )
    parser.set_defaults(run=_stress)


def _stress(options: argparse.Namespace) -> int:
    if not LEAST_PAIRS <= options.pairs <= MOST_PAIRS:
        raise InputError(f"pairs {options.pairs}: must be {LEAST_PAIRS}..{MOST_PAIRS} at each setting")
    return report(harness.FOLDER / "stress.json", partial(_measured, options.seed, options.pairs))


def _measured(seed: int, pairs: int) -> Findings:
    with progress_bar("cores and settings", STEPS) as progress:
        return findings(run_stress(seed, pairs, progress))


def findings(result: StressResult) -> Findings:
    """Return what is told of a result."""
    core, no_miss = result.whole.core, result.whole.no_miss
    content = {
        "seed": result.seed,
        "pairs_a_setting": result.pairs,
        "orders": NUM_ORDERS,
        "core_widths": WIDTHS,
        "families": [_family(family) for family in result.families],
    }
    return Findings(
        f"triaxis bench stress --seed {result.seed} --pairs {result.pairs}",
        f"core: {core.wrong} of {core.answers:,} answers wrong at its own resolution; no-miss mode: "
        f"{no_miss.misses} of {no_miss.answers:,} missed, {no_miss.false_alarms:,} false alarms",
        result.problems,
        content,
        [_wrong_answers(result), _core_answers(result)],
        {picture.name: partial(figure_of, picture, result) for picture in PICTURES},
    )


def _family(result: FamilyResult) -> dict[str, Any]:
    family = result.family
    settings = zip(family.settings, result.measured, strict=True)
    return {
        "name": family.name,
        "knob": family.knob,
        "about": family.about,
        "settings": [_setting(setting.label, measured) for setting, measured in settings],
    }


def _setting(label: str, measured: SettingResult) -> dict[str, Any]:
    return {
        "setting": label,
        "pairs": measured.pairs,
        "near_pairs": measured.near_pairs,
        "judged_pairs": measured.judged_pairs,
        "core_width_as_given": measured.own_width,
        "core_at_its_own_resolution": told(measured.core, *_RATES),
        "methods": {name: told(errors, *_RATES) for name, errors in measured.methods.items()},
        "rounded": {
            "width": ROUNDING_WIDTH,
            "resolution": measured.resolution,
            "without_margin": told(measured.rounded, *_RATES),
            "no_miss": told(measured.no_miss, *_RATES),
            "band_pairs": measured.band_pairs,
            "false_alarms_beyond_band": measured.beyond_band,
            "farthest_false_alarm_lsb": measured.farthest,
        },
    }


def _wrong_answers(result: StressResult) -> Table:
    title = f"wrong answers: the most at any setting, and from which setting on ({_FAILS:.1%})"
    rows = table(title, ("family", *(method.name for method in METHODS)))
    for family in result.families:
        rows.add_row(family.family.name, *(_method_cell(family, method.name) for method in METHODS))
    return rows


def _method_cell(result: FamilyResult, name: str) -> str:
    rates = [measured.methods[name].wrong_rate for measured in result.measured]
    first = next((k for k, rate in enumerate(rates) if rate >= _FAILS), None)
    if first is None:
        return f"{max(rates):.2%}"
    return f"{max(rates):.0%} from {result.family.settings[first].label}"


def _core_answers(result: StressResult) -> Table:
    headings = ("family", "answers", "wrong", "no-miss: answers", "missed", "false alarms", "farthest (LSB)")
    rows = table(f"the core: as simulated, and its no-miss mode at {ROUNDING_WIDTH} bits", headings)
    for family in result.families:
        core, no_miss = family.core, family.no_miss
        rows.add_row(
            family.family.name,
            f"{core.answers:,}",
            f"{core.wrong}",
            f"{no_miss.answers:,}",
            f"{no_miss.misses}",
            f"{no_miss.false_alarms / no_miss.answers:.1%}",
            f"{max(measured.farthest for measured in family.measured):.2f} of 2",
        )
    return rows
