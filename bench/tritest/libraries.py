"""Who can be scored by name, and the text protocol by which they, and any other program, answer.

A program is given a pair a line, 18 whole numbers (x y z of A1 A2 A3 B1 B2 B3), and answers a line each, in
order: 1 where both triangles have a point in common, 0 where not, ? where it cannot tell. It may answer at
any time until its input ends, and then ends itself with exit code 0.
"""

import sys
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from importlib.metadata import version
from itertools import islice
from typing import Any, TextIO

import numpy as np
import numpy.typing as npt

from triaxis.bench.peers import EDGE_PEERS, TRIANGLE_PEERS
from triaxis.bench.peers.peer import Peer, Question, Reals
from triaxis.bench.stress.methods import guigue_devillers, moller, separating_axes
from triaxis.bench.stress.orders import scaled
from triaxis.golden.bulk import bulk_verdicts
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import MAX_WIDTH, check_pairs
from triaxis.sim.core_engine import RtlEngine, configuration_for

CLEAR, COLLIDES, UNTOLD = "0", "1", "?"

# Pairs that a library is asked at a time; those of which one raises an error are asked again, one by one.
_BLOCK = 200
# Up to here float64 holds every whole number.
_LARGEST = 1 << 53

# Pairs (N, 2, 3, 3) of a block, whole numbers that float64 holds: which collide (N,).
_Asked = Callable[[Reals], npt.NDArray[Any]]


def _own_version() -> str:
    return version("triaxis")


@cache
def _core() -> RtlEngine:
    return RtlEngine(configuration_for(MAX_WIDTH, 0))


def _by_verdicts(verdicts: Callable[..., Any], a: Reals, b: Reals) -> Question:
    """Return what asks ours, which takes whole numbers of its width and refuses others."""
    pairs = np.stack([a, b], 1).astype(np.int64)
    return Question(lambda: verdicts(check_pairs(pairs, MAX_WIDTH), np.zeros(len(pairs), np.int64))["near"])


def _by_paper(method: Callable[..., Any], kind: type[np.floating[Any]], a: Reals, b: Reals) -> Question:
    """Return what asks a published test, which wants (vertex, coordinate, pair), and no overflow: scaled."""
    points = scaled(np.stack([a, b], 1)).astype(kind)
    return Question(lambda: method(points[:3], points[3:]))


_PAPERS = {"SAT 1996": separating_axes, "Moller 1997": moller, "Guigue Devillers 2003": guigue_devillers}
OURS = (
    Peer("Triaxis core", "triaxis", "the simulated core, 32 bits", _own_version,
         partial(_by_verdicts, lambda *asked: _core().verdicts(*asked)), batched=True),
    Peer("Triaxis bulk", "triaxis", "the native bulk checker", _own_version,
         partial(_by_verdicts, bulk_verdicts), batched=True),
)  # fmt: skip
PAPERS = tuple(
    Peer(f"{name} {kind.__name__}", "triaxis", f"bench/stress/methods.py, in {kind.__name__}", _own_version,
         partial(_by_paper, method, kind), batched=True)
    for name, method in _PAPERS.items()
    for kind in (np.float32, np.float64)
)  # fmt: skip
LIBRARIES = {
    "-".join(library.name.lower().replace(",", "").split()): library
    for library in (*OURS, *TRIANGLE_PEERS, *EDGE_PEERS, *PAPERS)
}


def named(name: str) -> Peer:
    """Return a library by its name; raise InputError where there is none of it."""
    if name not in LIBRARIES:
        raise InputError(f"{name:.40}: no such library: one of {', '.join(LIBRARIES)}")
    return LIBRARIES[name]


def answer(library: Peer, lines: TextIO, out: TextIO) -> None:
    """Answer pairs for a library, by the protocol."""
    done = 0
    for block in _blocks(lines):
        numbers = [_numbers(line, done + place) for place, line in enumerate(block, 1)]
        pairs, done = np.array(numbers, np.float64).reshape(-1, 2, 3, 3), done + len(block)
        out.write("".join(f"{one}\n" for one in _answers(partial(_ask, library), pairs)))
        out.flush()


def _numbers(line: str, place: int) -> list[int]:
    try:
        numbers = [int(word) for word in line.split()]
    except ValueError:
        numbers = []
    if len(numbers) != 18 or max(map(abs, numbers)) > _LARGEST:
        raise InputError(f"line {place}: {line.strip():.60}: must be 18 whole numbers of at most 2^53")
    return numbers


def _blocks(lines: TextIO) -> Iterator[list[str]]:
    while block := list(islice(lines, _BLOCK)):
        yield block


def _ask(library: Peer, pairs: Reals) -> npt.NDArray[Any]:
    with np.errstate(all="ignore"):
        return library.load(np.ascontiguousarray(pairs[:, 0]), np.ascontiguousarray(pairs[:, 1])).ask()


def _answers(ask: _Asked, pairs: Reals) -> Sequence[str]:
    try:
        return [COLLIDES if near else CLEAR for near in ask(pairs)]
    # Whatever it raises: it does not answer.
    except Exception as error:
        if len(pairs) == 1:
            print(f"{type(error).__name__}: {error}", file=sys.stderr)
            return [UNTOLD]
        return [one for pair in pairs for one in _answers(ask, pair[None])]
