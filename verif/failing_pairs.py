"""The file of failing pairs that the scoreboard writes and ReplayTest sends again.

A NumPy ``.npz`` archive with ``pairs``, integers of shape (N, 2, 3, 3), and ``margins`` of shape (N,).
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.pairs import Pairs, check_pairs
from triaxis.verif.configuration import Configuration


def write_failing_pairs(path: Path, pairs: Sequence[Pairs], margins: Sequence[int]) -> None:
    """Write pairs (2, 3, 3) each, and their margins."""
    np.savez(path, pairs=np.array(pairs, np.int64), margins=np.array(margins, np.int64))


def read_failing_pairs(path: Path, configuration: Configuration) -> tuple[Pairs, npt.NDArray[np.int64]]:
    """Read pairs and margins; raise InputError where the file is not one, or does not fit the core."""
    try:
        with np.load(path, allow_pickle=False) as file:
            pairs, margins = file["pairs"], file["margins"]
    except FileNotFoundError as error:
        raise InputError(f"{path}: no such file") from error
    # A damaged archive makes NumPy raise almost anything.
    except Exception as error:
        raise InputError(f"{path}: not a file of failing pairs (.npz with pairs and margins)") from error
    pairs = check_pairs(pairs, configuration.width, str(path))
    if margins.shape != (len(pairs),) or margins.dtype.kind not in "iu":
        raise InputError(f"{path}: margins: must be {len(pairs)} integers")
    if margins.min(initial=0) < 0 or margins.max(initial=0) > configuration.max_margin:
        raise InputError(f"{path}: margins: must be 0..{configuration.max_margin} for {configuration.name}")
    return pairs, margins.astype(np.int64)
