"""Pairs that failed, each with what the core was sent before it: as streams, and in the scoreboard's file.

Most faults need one pair. Those that leave something behind (operands that are not replaced, a margin
that belongs to the pair before) need the pairs before it too: its context.

The file, which ReplayTest sends again, is a NumPy ``.npz`` archive with ``pairs``, integers of shape
(N, 2, 3, 3), and ``margins`` of shape (N,); also ``context`` (N, C, 2, 3, 3), ``context_margins`` (N, C) and
``context_counts`` (N,): the last ``context_counts[n]`` of the C rows were sent before pair n, in that order.
An archive without context is read too.
"""

import io
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_archive
from triaxis.golden.outputs import write_whole
from triaxis.golden.pairs import Pairs, check_pairs, coordinate_range
from triaxis.sim.configuration import Configuration
from triaxis.verif.core.checking import Failure


@dataclass(frozen=True, eq=False)
class Stream:
    """Pairs (K, 2, 3, 3) and margins (K,), K at least 1, sent one per clock; the last one fails."""

    pairs: Pairs
    margins: npt.NDArray[np.int64]

    def __post_init__(self) -> None:
        """Check the shapes."""
        if self.pairs.shape[1:] != (2, 3, 3) or self.margins.shape != (len(self.pairs),):
            raise ValueError(f"stream: pairs {self.pairs.shape}, margins {self.margins.shape}")
        if not len(self.pairs):
            raise ValueError("stream: no pair")

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.pairs)

    @property
    def pair(self) -> Pairs:
        """Return the pair that fails, (2, 3, 3)."""
        return self.pairs[-1]

    @property
    def margin(self) -> int:
        """Return the margin of the pair that fails."""
        return int(self.margins[-1])

    def fits(self, configuration: Configuration) -> bool:
        """Return whether a core in that configuration can be sent all of it."""
        low, high = coordinate_range(configuration.width)
        return bool(
            self.pairs.min() >= low
            and self.pairs.max() <= high
            and self.margins.min() >= 0
            and self.margins.max() <= configuration.max_margin
        )

    def preceded_by(self, context: "Stream") -> "Stream":
        """Return this stream with another one before it."""
        return Stream(
            np.concatenate([context.pairs, self.pairs]), np.concatenate([context.margins, self.margins])
        )

    def describe(self) -> str:
        """Return the pairs and margins in one line."""
        each = [f"margin {m}, {p.tolist()}" for p, m in zip(self.pairs, self.margins.tolist(), strict=True)]
        return "; then ".join(each)


def write_failing_pairs(path: Path, failures: Sequence[Failure]) -> None:
    """Write failures that are about pairs, each with the pairs that came before it: whole or not at all."""
    counts = [len(failure.context_margins) for failure in failures]
    longest = max(counts)
    context = np.zeros((len(failures), longest, 2, 3, 3), np.int64)
    context_margins = np.zeros((len(failures), longest), np.int64)
    for row, (failure, count) in enumerate(zip(failures, counts, strict=True)):
        context[row, longest - count :] = failure.context
        context_margins[row, longest - count :] = failure.context_margins
    archive = io.BytesIO()
    np.savez(
        archive,
        pairs=np.array([failure.pair for failure in failures], np.int64),
        margins=np.array([failure.margin for failure in failures], np.int64),
        context=context,
        context_margins=context_margins,
        context_counts=np.array(counts, np.int64),
    )
    write_whole(path, archive.getvalue())


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
    rows = [slice(longest - kept, longest) for kept in counts.tolist()]
    streams = [
        Stream(context[n, last].astype(np.int64), margins[n, last].astype(np.int64)) if counts[n] else None
        for n, last in enumerate(rows)
    ]
    for n, stream in enumerate(streams):
        if stream is not None and not stream.fits(configuration):
            low, high = coordinate_range(configuration.width)
            raise InputError(
                f"{path}: context of pair {n}: does not fit {configuration.name}: coordinates must be "
                f"{low}..{high}, margins 0..{configuration.max_margin}"
            )
    return streams
