"""``triaxis formal``: proofs of the core and of the mesh engine."""

import argparse
import shlex

from rich.console import Console
from rich.table import Table

from triaxis.host.cli.progress import progress_bar
from triaxis.verif.formal.run import FormalResult, proof_names, prove_all, write_result

PROVED, FAILED = 0, 1
_JOBS = 2


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "formal",
        help="prove the core and the mesh engine: streams, axes, verdicts, widths, skipping, runs",
        description="Prove the core and the mesh engine with yowasp-sby, yices and algebra on the netlist; "
        "about a minute. Writes build/formal/formal.json when all proofs are run.",
        epilog="Exit codes: 0 all hold, 1 one does not, 2 error.",
    )
    parser.add_argument("--proof", default="*", metavar="GLOB", help="only proofs of such names (*)")
    parser.add_argument("--jobs", type=int, default=_JOBS, help=f"proofs at a time ({_JOBS})")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the proofs and print the table."""
    with progress_bar("proofs", len(proof_names())) as progress:
        result = prove_all(progress, only=options.proof, jobs=options.jobs)
    _print(result)
    if result.complete:
        arguments = ["triaxis", "formal", "--jobs", str(options.jobs)]
        print(f"written to {write_result(result, shlex.join(arguments))}")
    else:
        print("a part of the proofs: no result written")
    return PROVED if result.passed else FAILED


def _print(result: FormalResult) -> None:
    table = Table(title="proofs")
    for heading in ("proof", "method", "checked", "seconds", "result"):
        table.add_column(heading, justify="right" if heading == "seconds" else "left")
    for outcome in result.outcomes:
        checked = ", ".join(f"{count} {what}" for what, count in outcome.finding.facts.items())
        table.add_row(
            outcome.proof.name,
            str(outcome.proof.method),
            checked,
            f"{outcome.seconds:.1f}",
            outcome.finding.result if outcome.passed else outcome.finding.result.upper(),
        )
    Console(width=120).print(table)
    for problem in result.problems:
        print(f"FAILED: {problem}")
    print(result.summary)
