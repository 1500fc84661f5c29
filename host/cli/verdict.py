"""``triaxis verdict``: verdicts on a file of pairs, by the core, the bulk checker or the golden model."""

import argparse
from pathlib import Path

import numpy as np

from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.judge import judge_in_parallel
from triaxis.golden.pairs import check_margin, check_width, read_pairs, write_verdicts
from triaxis.host.cli import DONE
from triaxis.host.cli.terminal import progress_bar
from triaxis.sim.core_engine import RtlEngine, configuration_for


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Decide pairs of triangles: near(A, B, margin) is true exactly when the Chebyshev distance of A and
    B is at most the margin.
    """
    parser.add_argument(
        "pairs", type=Path, metavar="PAIRS.npy",
        help="integers of shape (N, 2, 3, 3): pair; A then B; vertex; coordinate",
    )  # fmt: skip
    parser.add_argument("--engine", choices=("rtl", "bulk", "golden"), required=True, help="who decides")
    parser.add_argument("--width", type=int, default=16, metavar="W", help="coordinate bits, 8..32 (16)")
    parser.add_argument("--margin", type=int, default=0, metavar="M", help="margin in LSB (0)")
    parser.add_argument(
        "--out", type=Path, required=True, metavar="OUT.npy",
        help="structured array: near, axis (-1: none), coplanar, degenerate_a, degenerate_b",
    )  # fmt: skip
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> int:
    """Decide the pairs and write the verdicts."""
    check_width(options.width)
    check_margin(options.margin, options.width)
    pairs = read_pairs(options.pairs, options.width)
    margins = np.full(len(pairs), options.margin, np.int64)
    with progress_bar(f"{options.engine} verdicts", len(pairs)) as progress:
        if options.engine == "rtl":
            engine = RtlEngine(configuration_for(options.width, options.margin))
            verdicts = engine.verdicts(pairs, margins, progress)
        elif options.engine == "bulk":
            verdicts = bulk_verdicts(pairs, margins, progress)
        else:
            verdicts = judge_in_parallel(pairs, margins, progress)
    near = int(verdicts["near"].sum())
    print(f"{len(pairs)} pairs: {near} near, {len(pairs) - near} clear", flush=True)
    write_verdicts(options.out, verdicts)
    return DONE
