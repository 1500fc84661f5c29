"""``triaxis stress``: numerical stability, of the core and of published floating-point tests."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.bench.stress.measuring import ROUNDING_WIDTH
from triaxis.bench.stress.orders import METHODS
from triaxis.bench.stress.results import summary, write_result
from triaxis.bench.stress.run import PAIRS, STEPS, FamilyResult, StressResult, check_options, run_stress
from triaxis.host.cli.progress import progress_bar

REACHED, MISSED = 0, 1

# From this share of wrong answers on, a method is said to fail.
_FAILS = 0.001


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "stress",
        help="turn inputs from easy to impossible, and count wrong answers",
        description="Families of pairs with one knob each, turned from easy to impossible: the core as "
        "simulated, its no-miss mode, and three published tests in float32 and float64, in all 72 orders of "
        f"each pair, against exact verdicts. Rounded pairs are for {ROUNDING_WIDTH} bits. Writes "
        "build/bench/stress.json, and pictures of errors, of order-dependence and of rounding.",
        epilog="Exit codes: 0 the core is right everywhere at its own resolution, the no-miss mode misses "
        "nothing and its false alarms are within their band; 1 not; 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.add_argument(
        "--pairs", type=int, default=PAIRS, metavar="N", help=f"pairs at each setting ({PAIRS})"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure, print, write."""
    check_options(options.seed, options.pairs)
    with progress_bar("cores and settings", STEPS) as progress:
        result = run_stress(options.seed, options.pairs, progress)
    console = Console(width=150)
    console.print(_table(result))
    console.print(_core_table(result))
    for problem in result.problems:
        print(f"PROBLEM {problem}")
    verdict = "FAILED" if result.problems else "PASSED"
    print(f"{verdict}: {summary(result)}, {result.seconds:.0f} s")
    for path in write_result(result):
        print(f"written to {path}")
    return MISSED if result.problems else REACHED


def _table(result: StressResult) -> Table:
    table = Table(title=f"wrong answers: the most at any setting, and from which setting on ({_FAILS:.1%})")
    table.add_column("family")
    for method in METHODS:
        table.add_column(method.name, justify="right")
    for family in result.families:
        table.add_row(family.family.name, *(_method_cell(family, method.name) for method in METHODS))
    return table


def _method_cell(result: FamilyResult, name: str) -> str:
    rates = [measured.methods[name].rate for measured in result.measured]
    first = next((k for k, rate in enumerate(rates) if rate >= _FAILS), None)
    if first is None:
        return f"{max(rates):.2%}"
    return f"{max(rates):.0%} from {result.family.settings[first].label}"


def _core_table(result: StressResult) -> Table:
    table = Table(title=f"the core: as simulated, and its no-miss mode at {ROUNDING_WIDTH} bits")
    headings = ("family", "answers", "wrong", "no-miss: answers", "missed", "false alarms", "farthest (LSB)")
    for heading in headings:
        table.add_column(heading, justify="left" if heading == "family" else "right")
    for family in result.families:
        core, no_miss = family.core, family.no_miss
        table.add_row(
            family.family.name,
            f"{core.answers:,}",
            f"{core.wrong}",
            f"{no_miss.answers:,}",
            f"{no_miss.misses}",
            f"{no_miss.false_alarms / no_miss.answers:.1%}",
            f"{max(measured.farthest for measured in family.measured):.2f} of 2",
        )
    return table
