"""Failing pairs as the scoreboard leaves them, each with what the core was sent before it.

What was sent before is in the arrays ``context`` .. of the archive (see `triaxis.verif.core.failing_pairs`);
an archive without them is read too.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_archive
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.verif.core.failing_pairs import read_failing_pairs
from triaxis.verif.core.stream import Stream

_ARRAYS = ("context", "context_margins", "context_counts")


@dataclass(frozen=True)
class FailingPair:
    """A pair that failed: a stream of one; and the stream before it, where anything is known of it."""

    stream: Stream
    context: Stream | None


def read_failing(path: Path, configuration: Configuration) -> list[FailingPair]:
    """Read an archive; raise InputError where it is not one, or does not fit the core.

    Without recorded context, the failing pairs before a pair in the archive are taken for it.
    """
    pairs, margins = read_failing_pairs(path, configuration)
    contexts = _recorded(path, len(pairs), configuration)
    if contexts is None:
        contexts = [Stream(pairs[:n], margins[:n]) if n else None for n in range(len(pairs))]
    streams = [Stream(pairs[n : n + 1], margins[n : n + 1]) for n in range(len(pairs))]
    return [FailingPair(*both) for both in zip(streams, contexts, strict=True)]


def _recorded(path: Path, count: int, configuration: Configuration) -> list[Stream | None] | None:
    """Return the recorded context of each pair, None in all where the archive records none."""
    arrays = read_archive(path)
    present = [name for name in _ARRAYS if name in arrays]
    if not present:
        return None
    if len(present) < len(_ARRAYS):
        raise InputError(f"{path}: {', '.join(_ARRAYS)}: only {', '.join(present)}; run the test again")
    context, margins, counts = (arrays[name] for name in _ARRAYS)
    longest = context.shape[1] if context.ndim == 5 else 0
    shapes = (context.shape, margins.shape, counts.shape)
    if shapes != ((count, longest, 2, 3, 3), (count, longest), (count,)):
        raise InputError(f"{path}: context: shapes {shapes} do not go with {count} failing pairs")
    if any(array.dtype.kind not in "iu" for array in (context, margins, counts)):
        raise InputError(f"{path}: context: must be integers")
    if counts.min(initial=0) < 0 or counts.max(initial=0) > longest:
        raise InputError(f"{path}: context_counts: must be 0..{longest}")
    streams = [_last_rows(context[n], margins[n], int(counts[n])) for n in range(count)]
    for n, stream in enumerate(streams):
        if stream is not None and not stream.fits(configuration):
            low, high = coordinate_range(configuration.width)
            raise InputError(
                f"{path}: context of pair {n}: does not fit {configuration.name}: coordinates must be "
                f"{low}..{high}, margins 0..{configuration.max_margin}"
            )
    return streams


def _last_rows(pairs: np.ndarray, margins: np.ndarray, count: int) -> Stream | None:
    if not count:
        return None
    return Stream(pairs[-count:].astype(np.int64), margins[-count:].astype(np.int64))
