"""``triaxis mutate``: faults put into dut/ one by one, each of which must be found out."""

import argparse
from collections.abc import Mapping

from rich.console import Console
from rich.table import Table

from triaxis.golden.errors import InputError
from triaxis.host.cli.progress import progress_bar
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.result import (
    Fate,
    MutationResult,
    Tally,
    grouped,
    store_result,
    tally,
    write_result,
)
from triaxis.verif.mutation.run import mutate

KILLED, SURVIVED = 0, 1
_SHOWN = 40


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "mutate",
        help="put small faults into dut/, and see each found out or proved to change nothing",
        description="Generate mutants of every file of dut/, play them with short directed runs and those "
        "that survive with volume, and prove those listed in verif/mutation/equivalents.toml equivalent. "
        "Writes build/mutation/mutation.json; a full run at 100 % is kept as verif/mutation/result.json.",
        epilog="Exit codes: 0 every mutant killed or equivalent, 1 not, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.add_argument(
        "--file", metavar="GLOB", help="only mutants of these files, as in 'triaxis_fifo*' or 'mesh/*'"
    )
    parser.add_argument("--mutant", metavar="ID", help="only this mutant, or those that a pattern matches")
    parser.add_argument("--jobs", type=int, default=2, help="processes (2)")
    parser.add_argument("--fresh", action="store_true", help="forget what earlier runs found out")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Play the mutants and print the tables."""
    if options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
    if options.jobs < 1:
        raise InputError(f"jobs {options.jobs}: must be at least 1")
    found = catalogue()
    restricted = options.file is not None or options.mutant is not None
    if restricted:
        found = found.restricted(options.file, options.mutant)
    with progress_bar("mutants", len(found.mutants)) as progress:
        result = mutate(options.seed, jobs=options.jobs, fresh=options.fresh, progress=progress, chosen=found)
    _print(result)
    if not restricted:
        command = f"triaxis mutate --seed {options.seed}"
        print(f"written to {write_result(result, command)}")
        if result.passed:
            print(f"stored in {store_result(result)}")
    elif len(result.fates) == 1:
        _print_one(result.fates[0])
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return KILLED if result.passed else SURVIVED


def _print(result: MutationResult) -> None:
    console = Console(width=110)
    for title in ("file", "operator"):
        console.print(_table(title, grouped(result.fates, title), tally(result.fates)))
    for problem in result.problems[:_SHOWN]:
        print(f"PROBLEM {problem}")
    if len(result.problems) > _SHOWN:
        print(f"PROBLEM .. and {len(result.problems) - _SHOWN} more, all in the JSON file of a full run")


def _print_one(fate: Fate) -> None:
    print(f"{fate.id} ({fate.kind}): {fate.place}")
    print(f"  {fate.original}\n  {fate.changed}")
    if fate.by is not None:
        told = f" after {fate.pairs} pairs" if fate.pairs is not None else ""
        what = f"{fate.test} {fate.family or ''} on {fate.target}"
        print(f"  {fate.fate} by {fate.by}: {what}: {fate.symptom}{told}")
    else:
        print(f"  {fate.fate}")


def _table(title: str, rows: Mapping[str, Tally], total: Tally) -> Table:
    table = Table(title=f"mutants by {title}")
    for heading in (title, "mutants", "run", "assertion", "elaboration", "equivalent", "surviving", "score"):
        table.add_column(heading, justify="left" if heading == title else "right")
    for name, row in (*rows.items(), ("all", total)):
        # Rounded down: 100 means all.
        score = "" if row.score is None else f"{int(row.score * 100) / 100:.2f} %"
        table.add_row(
            name, str(row.mutants), str(row.by_run), str(row.by_assertion), str(row.by_elaboration),
            str(row.equivalent), str(row.surviving + row.absent), score, end_section=name != "all",
        )  # fmt: skip
    return table
