"""``triaxis faults``: the catalogue of faults, each put in and caught."""

import argparse

from rich.console import Console
from rich.table import Table

from triaxis.golden.errors import InputError
from triaxis.host.cli.progress import progress_bar
from triaxis.verif.faults.catalogue import FAULTS, Fault, faults_of
from triaxis.verif.faults.result import FaultsResult, Outcome, write_json
from triaxis.verif.faults.run import catch_all

CAUGHT, NOT_CAUGHT = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "faults",
        help="put known faults into the core, and see each caught",
        description="Put the faults of the replaced design, F1 to F10, into copies of the core, its wrapper "
        "and its environment, and let the environment's own tests catch them. Writes "
        "build/faults/faults.json, unless only some are asked for.",
        epilog="Exit codes: 0 all caught, 1 not, 2 error.",
    )
    parser.add_argument(
        "--fault", action="append", metavar="NAME",
        help="only this one; F1 stands for all its variants; may be given several times",
    )  # fmt: skip
    parser.add_argument("--all", action="store_true", help="the further faults of the catalogue too")
    parser.add_argument("--list", action="store_true", help="list the catalogue, and run nothing")
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the catalogue, or what was asked for of it, and print the table."""
    if options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
    if options.all and options.fault:
        raise InputError("--all and --fault: give one of them")
    console = Console(width=110)
    chosen = _chosen(options)
    if options.list:
        console.print(_list_of(chosen if options.fault else FAULTS))
        return CAUGHT
    with progress_bar("faults", len(chosen)) as progress:
        result = catch_all(progress, options.seed, chosen)
    for outcome in result.outcomes:
        _print_example(console, outcome)
    console.print(_table(result))
    for problem in result.problems:
        print(f"PROBLEM {problem}")
    verdict = "PASSED" if result.passed else "FAILED"
    print(f"{verdict}: {result.summary}, {result.seconds:.0f} s")
    if result.complete:
        print(f"written to {write_json(result)}")
    return CAUGHT if result.passed else NOT_CAUGHT


def _chosen(options: argparse.Namespace) -> tuple[Fault, ...]:
    if options.fault:
        wanted = [fault for name in options.fault for fault in faults_of(name)]
        return tuple(dict.fromkeys(wanted))
    return tuple(fault for fault in FAULTS if fault.replaced or options.all)


def _list_of(faults: tuple[Fault, ...]) -> Table:
    table = Table("fault", "of", "build", "what it is")
    for fault in faults:
        table.add_row(fault.name, fault.kind.name.lower(), fault.config, fault.story)
    return table


def _print_example(console: Console, outcome: Outcome) -> None:
    """Print the counterexample as found and as small as it gets."""
    example = outcome.example
    if example is None:
        return
    lines = [
        f"{outcome.fault.name}: {example.meaning}",
        f"  before: {example.before}",
        f"  after:  {example.after}",
        f"  said {example.core_said}, right is {example.right}",
        *([f"  drawn: {example.picture}"] if example.picture else []),
    ]
    console.print("\n".join(lines), markup=False, highlight=False, soft_wrap=True)


def _table(result: FaultsResult) -> Table:
    table = Table(title="faults, and what caught them")
    for heading in ("fault", "what it is", "caught by", "pairs", "before it", "how"):
        table.add_column(heading, justify="right" if heading in ("pairs", "before it") else "left")
    for outcome in result.outcomes:
        catch = outcome.catch
        cells = ("NOT CAUGHT", "", "", outcome.reason or "")
        if catch:
            pairs = "" if catch.pairs is None else str(catch.pairs)
            cells = (catch.test, pairs, str(catch.pairs_before or ""), _how(outcome))
        table.add_row(outcome.fault.name, outcome.fault.title, *cells)
    return table


def _how(outcome: Outcome) -> str:
    """Return in what way it showed."""
    if outcome.example:
        return outcome.example.meaning
    assert outcome.catch
    after = "" if outcome.catch.clocks is None else f" (clock {outcome.catch.clocks})"
    return outcome.catch.message + after
