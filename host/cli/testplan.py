"""``triaxis testplan``: the testplan as a table, and what its linter says of it."""

import argparse
from pathlib import Path

from rich.console import Console
from rich.table import Table

from triaxis.coverage.testplan import RUNS, TESTPLAN, Testplan, Testpoint
from triaxis.coverage.testplan_inventory import Inventory
from triaxis.verif.signoff.plan_check import check_plan, inventory

CLEAN, REFUSED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "testplan",
        help="print the testplan and check that nothing is missing in it",
        description="Print each testpoint with its stage, what runs for it, and how many coverage bins, "
        "assertions and mutants it owns; then everything that the linter refuses.",
        epilog="Exit codes: 0 clean, 1 refused, 2 error.",
    )
    parser.add_argument("plan", nargs="?", type=Path, default=TESTPLAN, help="the testplan (the project's)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Print the plan and what is wrong with it."""
    plan, problems = check_plan(options.plan)
    known = inventory()
    Console(width=140).print(_table(plan, known))
    sizes = (
        f"{len(known.tests)} tests, {len(known.proofs)} proofs, {len(known.faults)} faults, "
        f"{len(known.checks)} checks, {sum(map(len, known.bins.values()))} bins in {len(known.bins)} "
        f"configurations, {len(known.assertions)} assertions, {len(known.mutants)} mutants"
    )
    print(f"{len(plan.testpoints)} testpoints; {sizes}")
    for problem in problems:
        print(f"PROBLEM {problem}")
    print("REFUSED" if problems else "clean: nothing unknown, nothing without a testpoint")
    return REFUSED if problems else CLEAN


def _table(plan: Testplan, known: Inventory) -> Table:
    table = Table(title=f"testplan {plan.name}")
    for heading in ("stage", "testpoint", "what runs"):
        table.add_column(heading)
    for heading in ("bins", "assertions", "mutants"):
        table.add_column(heading, justify="right")
    for testpoint in sorted(plan.testpoints, key=lambda testpoint: testpoint.stage):
        table.add_row(
            testpoint.stage,
            testpoint.name,
            _runs(testpoint),
            str(_bin_count(testpoint, known)),
            *(str(len(known.owned(testpoint, kind))) for kind in ("assertions", "mutants")),
        )
    return table


def _runs(testpoint: Testpoint) -> str:
    lines = [f"{kind}: {', '.join(testpoint.entries(kind))}" for kind in RUNS if testpoint.entries(kind)]
    return "\n".join(lines)


def _bin_count(testpoint: Testpoint, known: Inventory) -> int:
    """Return how many bins with goals it owns, over all configurations."""
    owned = known.owned(testpoint, "bins")
    return sum(len(owned & bins) for bins in known.bins.values())
