"""``triaxis signoff``: runs every part of a sign-off, and gives its verdict and its page."""

import argparse
from collections import defaultdict
from typing import Any

from filelock import FileLock, Timeout
from rich.console import Console
from rich.table import Table

from triaxis.coverage.stages import STAGES, read_figures
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder
from triaxis.host.cli import DONE, NO
from triaxis.host.cli.arguments import add_seed
from triaxis.host.cli.terminal import print_list, progress_bar, table
from triaxis.sim.toolchain import verilator
from triaxis.verif.core.detector_check import SEED_VECTORS
from triaxis.verif.mutation.result import EVIDENCE as MUTATION
from triaxis.verif.results.database import keep
from triaxis.verif.signoff.plan import PAGE, RESULT, VOLUME
from triaxis.verif.signoff.result import Signoff
from triaxis.verif.signoff.run import signoff, step_count

# Problems that are printed; the page has all.
_SHOWN = 30

Evidence = dict[str, Any]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Lint the RTL, run every test in its configurations, measure coverage, catch known faults, prove,
    account for every mutant (what is recorded of this state is played again in part), and judge. Writes
    build/signoff/.
    """
    add_seed(parser)
    parser.add_argument(
        "--pairs",
        type=int,
        default=VOLUME,
        help=f"pairs of the volume runs ({VOLUME}); a sign-off from fewer fails",
    )
    parser.add_argument(
        "--whole",
        action="store_true",
        help="run the tests in four states and on the netlist first, where build/ holds no result of this "
        "RTL and environment, play every mutant, whatever is recorded, and fail where anything is absent: "
        "needs Coq and Icarus Verilog; hours",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the sign-off, unless one runs already; see `_run`."""
    make_folder(RESULT.parent)
    lock = RESULT.with_suffix(".lock")
    try:
        # Two would write each other's runs and coverage, and the one of other sources would judge them.
        with FileLock(lock, blocking=False):
            return _run(options)
    except Timeout as error:
        raise InputError(f"{lock}: a sign-off of this checkout runs already: wait for its end") from error


def _run(options: argparse.Namespace) -> int:
    """Run the sign-off, print its summary, and write its files."""
    # Matplotlib loads where a page is to come; if it does not, that is told before anything runs.
    from triaxis.verif.signoff.page import write

    # No older answer outlives a sign-off that is refused, or ends early.
    RESULT.unlink(missing_ok=True)
    PAGE.unlink(missing_ok=True)
    if options.pairs < 1000:
        raise InputError(f"pairs {options.pairs}: must be at least 1000")
    print(f"sign-off with Verilator {verilator()}, seed {options.seed}", flush=True)
    with progress_bar("sign-off", step_count(options.seed, options.pairs, options.whole)) as progress:
        result = signoff(options.seed, progress, options.pairs, options.whole, _say)
    page = write(result)
    keep(RESULT)
    if result.parts["mutation"].evidence:
        keep(MUTATION)
    _print(result)
    print(f"written to {RESULT} and {page}")
    return DONE if result.passed else NO


def _say(line: str) -> None:
    print(line, flush=True)


def _print(result: Signoff) -> None:
    console = Console(width=110)
    simulation = result.parts["simulation"].evidence
    if simulation:
        _print_simulation(console, simulation)
    console.print(_parts_table(result))
    console.print(_figures_table(result))
    print_list("PROBLEM", result.problems, _SHOWN, "all on the page")
    print_list("EXCEPTION", result.exceptions)
    if not result.provenance.git_clean:
        print("the checkout has uncommitted changes: no commit holds what was signed off")
    wanted = "" if result.judgement.passed else f", {STAGES[-1]} is wanted"
    verdict = f"{'PASSED' if result.passed else 'FAILED'}: stage {result.judgement.stage or 'none'} reached"
    print(f"{verdict}{wanted}, {result.seconds:.0f} s")


def _print_simulation(console: Console, evidence: Evidence) -> None:
    console.print(_runs_table(evidence["runs"]))
    console.print(_scenes_table(evidence["scenes"] + (evidence["real_meshes"] or [])))
    if evidence["real_meshes"] is None:
        print("real meshes: skipped, none found (set TRIAXIS_DATA to a folder with vmc/*.stl)")
    detector = evidence["detector"]
    print(
        f"CollisionDetector: {detector['seed_vectors_clear']} of {SEED_VECTORS} seed vectors clear; "
        f"{detector['wrong']} of {detector['pairs']} random pairs wrong; golden model: PPL differs on "
        f"{evidence['solvers']['different']} of {evidence['solvers']['pairs']} pairs"
    )
    for failed in (r for r in evidence["runs"] if not r["passed"]):
        print("\n".join(failed["explanation"]))


def _parts_table(result: Signoff) -> Table:
    parts = table("parts of the sign-off", ("part", "verdict", "result", "seconds"), text=3)
    for name, part in result.parts.items():
        found = part.evidence
        text = part.absent or "" if found is None else found["summary"]
        seconds = "" if found is None or found["seconds"] is None else f"{found['seconds']:.0f}"
        parts.add_row(name.replace("_", " "), part.state, text, seconds)
    return parts


def _figures_table(result: Signoff) -> Table:
    figures = table("figures, and the stages whose bounds they meet", ("figure", "measured", *STAGES))
    for figure in read_figures():
        value = result.figures[figure.name]
        met = (
            ("" if stage not in figure.bounds else "met" if figure.is_met(value, stage) else "NOT MET")
            for stage in STAGES
        )
        figures.add_row(figure.meaning, figure.text(value), *met)
    return figures


def _runs_table(runs: list[Evidence]) -> Table:
    headings = ("configuration", "runs", "pairs checked", "clear answers proved", "wrong answers")
    made = table("simulation runs", headings)
    groups: dict[str, list[Evidence]] = defaultdict(list)
    for run_ in runs:
        groups[run_["config"]].append(run_)
    for config, group in groups.items():
        counts = [run_["counts"] or {} for run_ in group]
        passed = sum(run_["passed"] for run_ in group)
        made.add_row(
            config,
            f"{passed} of {len(group)} passed",
            *(
                str(sum(count.get(key, 0) for count in counts))
                for key in ("checked", "clear_claims_rechecked", "failed")
            ),
        )
    return made


def _scenes_table(scenes: list[Evidence]) -> Table:
    counted = ("pairs", "skipped", "tested", "near")
    headings = ("scene", "expected", "found", "golden model agrees", *counted)
    made = table("whole meshes through the RTL", headings)
    for scene in scenes:
        made.add_row(
            scene["name"],
            scene["expected"],
            scene["found"],
            "NO" if not scene["agrees"] else "yes" if scene["tested"] else "boxes decide all",
            *(str(scene[key]) for key in counted),
        )
    return made
