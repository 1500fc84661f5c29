"""``triaxis signoff``: everything against the golden model, and a summary."""

import argparse
from collections import defaultdict

from rich.console import Console
from rich.table import Table

from triaxis.coverage.terminal import coverage_lines, summary_line
from triaxis.golden.errors import InputError
from triaxis.verif.cli.progress import progress_bar
from triaxis.verif.signoff.detector_check import SEED_VECTORS
from triaxis.verif.signoff.plan import VOLUME
from triaxis.verif.signoff.result import SignoffResult, write_json
from triaxis.verif.signoff.run import signoff, step_count
from triaxis.verif.signoff.scene_checks import SceneResult
from triaxis.verif.simulation import RunResult
from triaxis.verif.toolchain import verilator

PASSED, FAILED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "signoff",
        help="run everything against the golden model and print a summary",
        description="Run every test in every configuration of the core. Writes build/signoff/signoff.json.",
        epilog="Exit codes: 0 passed, 1 failed, 2 error.",
    )
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.add_argument(
        "--pairs",
        type=int,
        default=VOLUME,
        help=f"pairs of the volume runs ({VOLUME}); a sign-off from fewer fails",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the sign-off and print the summary."""
    if options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
    if options.pairs < 1000:
        raise InputError(f"pairs {options.pairs}: must be at least 1000")
    print(f"sign-off with Verilator {verilator()}, seed {options.seed}", flush=True)
    with progress_bar("sign-off", step_count(options.seed, options.pairs)) as progress:
        result = signoff(options.seed, progress, options.pairs)
    path = write_json(result, options.seed)
    _print(result)
    print(f"written to {path}")
    return FAILED if result.problems else PASSED


def _print(result: SignoffResult) -> None:
    console = Console(width=110)
    console.print(_runs_table(result.runs))
    console.print(_scenes_table(result.scenes + (result.real_meshes or [])))
    if result.real_meshes is None:
        print("real meshes: skipped, none found (set TRIAXIS_DATA to a folder with vmc/*.stl)")
    detector = result.detector
    print(
        f"CollisionDetector: {detector.seed_vectors_clear} of {SEED_VECTORS} seed vectors clear; "
        f"{detector.wrong} of {detector.pairs} random pairs wrong"
    )
    print(f"functional coverage: {summary_line(result.coverage)}")
    for model in result.coverage:
        for line in coverage_lines(model, everything=False):
            print(f"  {line}")
    for failed in (r for r in result.runs if not r.passed):
        print(failed.explain())
    for problem in result.problems:
        print(f"PROBLEM {problem}")
    verdict = "FAILED" if result.problems else "PASSED"
    if not result.provenance.git_clean:
        print("the checkout is not clean: what was signed off is in no commit")
    print(
        f"{verdict}: {result.checked} pairs checked, {result.judged} of them also judged by the golden "
        f"model, {result.seconds:.0f} s"
    )


def _runs_table(runs: list[RunResult]) -> Table:
    table = Table(title="core against bulk checker and golden model")
    for heading in ("configuration", "tests", "pairs checked", "claims re-checked", "mismatches"):
        table.add_column(heading, justify="left" if heading == "configuration" else "right")
    groups: dict[str, list[RunResult]] = defaultdict(list)
    for result in runs:
        groups[result.settings.config].append(result)
    for config, group in groups.items():
        counts = [result.counts or {} for result in group]
        passed = sum(result.passed for result in group)
        table.add_row(
            config,
            f"{passed} of {len(group)} passed",
            *(
                str(sum(count.get(key, 0) for count in counts))
                for key in ("checked", "clear_claims_rechecked", "failed")
            ),
        )
    return table


def _scenes_table(scenes: list[SceneResult]) -> Table:
    table = Table(title="meshes end to end through the RTL")
    for heading in (
        "scene",
        "expected",
        "found",
        "golden agrees",
        "facet pairs",
        "skipped",
        "tested",
        "near",
    ):
        table.add_column(heading, justify="left" if heading == "scene" else "right")
    for scene in scenes:
        table.add_row(
            scene.name,
            scene.expected,
            scene.found,
            "yes" if scene.agrees else "NO",
            *(str(n) for n in (scene.pairs, scene.skipped, scene.tested, scene.near)),
        )
    return table
