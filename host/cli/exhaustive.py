"""``triaxis exhaustive``: every ordered pair of triangles on a small grid, through the core."""

import argparse
import sys

from triaxis.golden.errors import InputError
from triaxis.host.cli.progress import progress_bar
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

PASSED, FAILED = 0, 1


def add_parser(commands: "argparse._SubParsersAction[argparse.ArgumentParser]") -> None:
    """Add the command."""
    parser = commands.add_parser(
        "exhaustive",
        help="run every ordered pair of triangles on a small grid",
        description="Run every ordered pair of triangles with vertices in {0 .. G-1}^3, degenerate ones "
        "included, at margins 0 and 1: each triangle A up to the symmetries of the cube, each B, in "
        "random orders. Grid 4 takes minutes, 5 hours. An interrupted run is continued by the same "
        "command. Writes build/exhaustive/grid<G>.json.",
        epilog="Exit codes: 0 passed, 1 failed, 2 error.",
    )
    parser.add_argument(
        "--grid", type=int, default=4, metavar="G",
        help=f"points along each coordinate, {SMALLEST}..{LARGEST} (4)",
    )  # fmt: skip
    parser.add_argument("--seed", type=int, default=1, help="what all random choices follow from (1)")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Run the grid, or what is left of it, and print what was found."""
    check_size(options.grid)
    if options.seed < 0:
        raise InputError(f"seed {options.seed}: must not be negative")
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
    _print(outcome)
    return FAILED if outcome.problems else PASSED


def _print(outcome: Outcome) -> None:
    counts, size = outcome.progress.result.counts, outcome.grid.size
    print(
        f"{counts.classes} classes, {counts.pairs} pairs, {counts.runs} runs in "
        f"{outcome.progress.seconds:.1f} s ({1e-6 * outcome.runs_per_second:.2f} M runs/s)"
    )
    print(f"{counts.claims} clear claims proven; {counts.judged} runs judged by the linear program too")
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
