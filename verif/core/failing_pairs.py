"""The file of failing pairs that the scoreboard writes and ReplayTest sends again.

A NumPy ``.npz`` archive with ``pairs``, integers of shape (N, 2, 3, 3), and ``margins`` of shape (N,);
also ``context`` (N, C, 2, 3, 3), ``context_margins`` (N, C) and ``context_counts`` (N,): the last
``context_counts[n]`` of the C rows were sent before pair n, in that order.
"""

import io
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_archive
from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import Pairs, check_pairs
from triaxis.sim.configuration import Configuration
from triaxis.verif.core.checking import Failure
from triaxis.verif.testbench.batches import Integers


def write_failing_pairs(path: Path, failures: Sequence[Failure]) -> None:
    """Write failures that are about pairs, each with the pairs that came before it."""
    contexts = [_context(failure) for failure in failures]
    counts = [len(margins) for _, margins in contexts]
    context = np.zeros((len(failures), max(counts), 2, 3, 3), np.int64)
    context_margins = np.zeros((len(failures), max(counts)), np.int64)
    for row, (pairs, margins) in enumerate(contexts):
        context[row, max(counts) - len(margins) :] = pairs
        context_margins[row, max(counts) - len(margins) :] = margins
    content = io.BytesIO()
    np.savez(
        content,
        pairs=np.array([failure.pair for failure in failures], np.int64),
        margins=np.array([failure.margin for failure in failures], np.int64),
        context=context,
        context_margins=context_margins,
        context_counts=np.array(counts, np.int64),
    )
    write_whole(path, content.getvalue())


def _context(failure: Failure) -> tuple[Integers, Integers]:
    if failure.context is None or failure.context_margins is None:
        return np.zeros((0, 2, 3, 3), np.int64), np.zeros(0, np.int64)
    return failure.context, failure.context_margins


def read_failing_pairs(path: Path, configuration: Configuration) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Read pairs and margins; raise InputError where the file is not one, or does not fit the core."""
    arrays = read_archive(path)
    if not {"pairs", "margins"} <= arrays.keys():
        raise InputError(f"{path}: not a file of failing pairs (.npz with pairs and margins)")
    pairs, margins = check_pairs(arrays["pairs"], configuration.width, str(path)), arrays["margins"]
    if margins.shape != (len(pairs),) or margins.dtype.kind not in "iu":
        raise InputError(f"{path}: margins: must be {len(pairs)} integers")
    if margins.min(initial=0) < 0 or margins.max(initial=0) > configuration.max_margin:
        raise InputError(f"{path}: margins: must be 0..{configuration.max_margin} for {configuration.name}")
    return pairs, margins.astype(np.int64)
