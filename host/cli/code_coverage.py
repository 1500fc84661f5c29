"""``triaxis code-coverage``: line, branch, expression and toggle coverage of dut/."""

import argparse
from collections import Counter

from rich.console import Console
from rich.table import Table

from triaxis.golden.errors import InputError
from triaxis.host.cli.progress import progress_bar
from triaxis.verif.code_coverage.run import CORES, PAIRS, CodeCoverage, measure, write_json

COVERED, UNCOVERED = 0, 1
_SHOWN = 40


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "code-coverage",
        help="measure line, branch, expression and toggle coverage of dut/",
        description="Build the core with coverage counters, play and check it, and set what was not hit "
        "against coverage/waivers.toml. Writes build/coverage/code.json.",
        epilog="Exit codes: 0 all covered, 1 not, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.add_argument("--pairs", type=int, default=PAIRS, help=f"how many for each model ({PAIRS})")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Measure and print the tables."""
    if options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
    if options.pairs < 1:
        raise InputError(f"pairs {options.pairs}: must be at least 1")
    with progress_bar("code coverage", 2 * (len(CORES) + 1)) as progress:
        result = measure(options.seed, options.pairs, progress=progress)
    path = write_json(result, options.seed)
    _print(result)
    print(f"written to {path}")
    return COVERED if result.passed else UNCOVERED


def _print(result: CodeCoverage) -> None:
    console = Console(width=110)
    console.print(_totals(result))
    categories = Counter(waiver.category for waiver in result.waivers)
    named = ", ".join(f"{count} {category}" for category, count in categories.items())
    print(f"{len(result.waivers)} waivers: {named}")
    for model in result.runs:
        print(f"{model.model}: {model.checked} results checked, {model.wrong} wrong, {model.seconds:.0f} s")
    _print_list("NOT COVERED", [str(bin_) for bin_ in result.assessment.uncovered])
    _print_list("PROBLEM", result.problems)
    print(f"{'PASSED' if result.passed else 'FAILED'}: code coverage, {result.seconds:.0f} s")


def _print_list(title: str, lines: list[str]) -> None:
    for line in lines[:_SHOWN]:
        print(f"{title} {line}")
    if len(lines) > _SHOWN:
        print(f"{title} .. and {len(lines) - _SHOWN} more, all in the JSON file")


def _totals(result: CodeCoverage) -> Table:
    table = Table(title="code coverage of dut/, each instance by itself")
    for heading in ("bins", "hit", "waived", "total", "covered"):
        table.add_column(heading, justify="left" if heading == "bins" else "right")
    for kind, total in result.assessment.totals.items():
        percent = "none" if total.percent is None else f"{total.percent:.2f} %"
        table.add_row(kind, str(total.hit), str(total.waived), str(total.total), percent)
    return table
