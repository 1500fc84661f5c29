"""The covering arrays: configurations with all sizes of the parameters, and every pair of kinds of values.

A kind is what the RTL tells apart, as margins of no bits, of some, of as many as coordinates. Of each of its
kinds a configuration takes a value that the fewest before it have. Pairwise libraries stop early where not
all kinds go together, as Lanes above Group: here the rows are chosen from all that are allowed.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from functools import cache
from itertools import combinations, product, zip_longest
from typing import Any

import numpy as np

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.board_parameters import MOST_BOARD_DEPTH, BoardParameters
from triaxis.sim.configuration import FIRST_WIDTHS, MOST_TAG_BITS, TRY_BITS, Configuration
from triaxis.sim.mesh_configuration import (
    LEAST_CYCLE_BITS,
    MOST_CYCLE_BITS,
    MOST_DEPTH,
    MOST_GROUP,
    MOST_LANES,
    MeshConfiguration,
)
from triaxis.verif.testbench.table import Runs

NO_EDGE_BOX, NONE, ALL = "no edge box", "none", "all"
# Margins of some bits, less than coordinates have.
SOME = range(1, MAX_WIDTH)
_SWITCH = (True, False)
Row = tuple[Any, ...]


def _bands(first: Iterable[int], last: int) -> tuple[range, ...]:
    """Return ranges that begin with these numbers, up to the last."""
    begins = list(first)
    return tuple(range(begin, end) for begin, end in zip(begins, [*begins[1:], last + 1], strict=True))


def _powers(most: int) -> tuple[int, ...]:
    return tuple(1 << n for n in range(most.bit_length()))


# Width, margin, tag, gating; every width with every kind of margin and of tag. A margin is multiplied by
# additions, in one piece of either port, of the wider one, or in two pieces.
CORE_KINDS = (
    range(MIN_WIDTH, MAX_WIDTH + 1),
    (NO_EDGE_BOX, NONE, *_bands((1, 5, 18, 25), MAX_WIDTH - 1), ALL),
    _bands(range(1, MOST_TAG_BITS, 16), MOST_TAG_BITS),
    _SWITCH,
)
_DEPTHS = _powers(MOST_DEPTH)[1:]
# Width by latency, margin, depth, group, lanes, cycle bits, gating, certificates.
MESH_KINDS = (
    _bands(FIRST_WIDTHS, MAX_WIDTH),
    (NONE, SOME, ALL),
    tuple(_DEPTHS[n : n + 4] for n in range(0, len(_DEPTHS), 4)),
    _powers(MOST_GROUP),
    _powers(MOST_LANES),
    # Many, so that every number of bits has its turn.
    _bands((LEAST_CYCLE_BITS, *range(9, MOST_CYCLE_BITS, 8)), MOST_CYCLE_BITS),
    _SWITCH,
    _SWITCH,
)
# Width by bytes of a coordinate on the line, margin, depth, group, lanes, certificates: what the engine
# itself makes of each is known from its own array.
_BOARD_DEPTHS = _powers(MOST_BOARD_DEPTH)[1:]
BOARD_KINDS = (
    _bands((MIN_WIDTH, 9, 17, 25), MAX_WIDTH),
    (NONE, SOME, ALL),
    tuple(_BOARD_DEPTHS[n : n + 4] for n in range(0, len(_BOARD_DEPTHS), 4)),
    ((1,), (2, 4, 8), (16, 32, MOST_GROUP)),
    ((1,), (2, 4), (8, 16), (MOST_LANES,)),
    _SWITCH,
)


def core_fits(row: Row) -> bool:
    """Return whether a core can have these kinds."""
    width, margin, *_ = row
    return not isinstance(margin, range) or margin.start < width


def mesh_fits(row: Row) -> bool:
    """Return whether an engine can have these kinds."""
    _, _, depths, group, lanes, *_ = row
    return lanes <= group and group * lanes <= depths[-1]


def _sizes(depths: Iterable[int], groups: Iterable[int], lanes: Iterable[int]) -> list[tuple[int, int, int]]:
    """Return the depths, groups and lanes that go together."""
    every = product(depths, groups, lanes)
    return [(depth, group, lane) for depth, group, lane in every if lane <= group <= depth // lane]


def board_fits(row: Row) -> bool:
    """Return whether a board can have these kinds."""
    return bool(_sizes(*row[2:5]))


def covering_rows(kinds: Sequence[Sequence[Any]], fits: Callable[[Row], bool] = lambda _: True) -> list[Row]:
    """Return rows of kinds that fit, such that each pair in any of these is in one of them."""
    allowed = [row for row in product(*map(range, map(len, kinds))) if fits(_named(kinds, row))]
    columns = np.array(allowed).T
    most = max(map(len, kinds))
    two = enumerate(combinations(columns, 2))
    pairs = np.stack([(n * most + one) * most + other for n, (one, other) in two], 1)
    missing = np.zeros(pairs.max() + 1, np.bool_)
    missing[pairs] = True
    # Of rows that are as good, one of the kinds that were taken least.
    taken = np.zeros((len(kinds), most), np.int64)
    rows: list[Row] = []
    while missing.any():
        spread = taken[np.arange(len(kinds))[:, None], columns].sum(0)
        best = int((missing[pairs].sum(1) * (1 << 20) - spread).argmax())
        missing[pairs[best]] = False
        taken[np.arange(len(kinds)), columns[:, best]] += 1
        rows.append(_named(kinds, allowed[best]))
    return rows


def _named(kinds: Sequence[Sequence[Any]], row: Sequence[int]) -> Row:
    return tuple(kind[n] for kind, n in zip(kinds, row, strict=True))


class _Fewest:
    """Takes of some values the one that was taken least, of those the one that is nearest to an end."""

    def __init__(self, taken: Iterable[int] = ()) -> None:
        self._taken = Counter(taken)

    def __call__(self, values: Sequence[int]) -> int:
        last = len(values) - 1
        _, _, value = min((self._taken[one], min(n, last - n), one) for n, one in enumerate(values))
        self._taken[value] += 1
        return value


def _margin(kind: str | range, width: int, some: _Fewest) -> int:
    if isinstance(kind, range):
        return some(kind[: width - kind.start])
    return width if kind == ALL else 0


# Twice what a counter of sixteen bits holds. Small engines, whose scenes have few pairs each, see fewer of
# all kinds, and as many in small scenes at full speed.
_PAIRS, _PAIRS_OF_DEPTH = 1 << 17, 400
# The golden model judges few: the bulk checker checks every pair.
_JUDGED, _JUDGED_SCENES = 10_000, 16
# Random scenes of meshes so large seldom have a pair for the core that is far down in both.
_DEEP = 8192
# Replies of a board: its sessions as they always are, and a talk.
_TALKS = {"BoardSmokeTest": 20, "BoardMixedTest": 60}
_LABEL = "array"


def array_runs() -> Iterator[tuple[str, Runs]]:
    """Yield the runs of the arrays: the name of the test, the runs in one configuration."""
    for core in core_array():
        yield "VolumeTest", Runs((core.name,), _PAIRS, _JUDGED, label=_LABEL)
    for core in certified_array():
        yield "CertificatesTest", Runs((core.name,), _PAIRS, _JUDGED, label=_LABEL)
    for engine in mesh_array():
        pairs = min(_PAIRS, _PAIRS_OF_DEPTH * engine.depth)
        yield "MeshRandomTest", Runs((f"mesh_{engine.name}",), pairs, _JUDGED_SCENES, label=_LABEL)
        if pairs < _PAIRS:
            yield "MeshVolumeTest", Runs((f"mesh_{engine.name}",), _PAIRS, _JUDGED, label=_LABEL)
        if engine.depth >= _DEEP:
            yield "MeshLimitsTest", Runs((f"mesh_{engine.name}",), 1, _JUDGED_SCENES, label=_LABEL)
    for board in board_array():
        for test, replies in _TALKS.items():
            yield test, Runs((board.name,), replies, label=_LABEL)


@cache
def core_array() -> tuple[Configuration, ...]:
    """Return the configurations of the core."""
    # Margins of all bits are there for every width.
    tags, some = _Fewest(), _Fewest(CORE_KINDS[0])
    return tuple(
        Configuration(width, _margin(margin, width, some), tags(tag), margin != NO_EDGE_BOX, gating)
        for width, margin, tag, gating in covering_rows(CORE_KINDS, core_fits)
    )


@cache
def certified_array() -> tuple[Configuration, ...]:
    """Return the configurations of the certified core: each width with two kinds of margin, other tags.

    Its core has tags of its own, so none of these is one of the core's array.
    """
    margins, tags, some = CORE_KINDS[1][1:], _Fewest(), _Fewest()
    found: list[Configuration] = []
    for width, turn in product(CORE_KINDS[0], range(2)):
        kind = margins[(width + turn * (len(margins) // 2)) % len(margins)]
        margin_bits = _margin(kind if core_fits((width, kind)) else ALL, width, some)
        tag_bits = tags(range(1, MOST_TAG_BITS - TRY_BITS + 1))
        found.append(Configuration(width, margin_bits, tag_bits, certified=True))
    return tuple(found)


@cache
def mesh_array() -> tuple[MeshConfiguration, ...]:
    """Return the configurations of the mesh engine."""
    widths, some, depths, cycles = _Fewest(), _Fewest(), _Fewest(), _Fewest()
    found: list[MeshConfiguration] = []
    for band, margin, depth, group, lanes, *rest in covering_rows(MESH_KINDS, mesh_fits):
        width = widths(band)
        enough = [one for one in depth if one >= group * lanes]
        bits, gating, certified = rest
        sizes = depths(enough), group, lanes, cycles(bits)
        found.append(MeshConfiguration(width, _margin(margin, width, some), *sizes, gating, certified))
    # What had no turn.
    margins = set(range(MAX_WIDTH + 1)) - {one.margin_bits for one in found}
    counts = set(range(LEAST_CYCLE_BITS, MOST_CYCLE_BITS + 1)) - {one.cycle_bits for one in found}
    for margin_bits, cycle_bits in zip_longest(sorted(margins), sorted(counts), fillvalue=MAX_WIDTH):
        found.append(MeshConfiguration(MAX_WIDTH, margin_bits, 64, 8, 8, cycle_bits))
    return tuple(found)


@cache
def board_array() -> tuple[BoardParameters, ...]:
    """Return the configurations of the board."""
    widths, some, taken = _Fewest(), _Fewest(), Counter[tuple[int, int]]()
    found: list[BoardParameters] = []
    for band, margin, *sizes, certify in covering_rows(BOARD_KINDS, board_fits):
        # Of those that go together the ones that were taken least; of these the last, which few others allow.
        best = min(reversed(_sizes(*sizes)), key=lambda one: sum(taken[place] for place in enumerate(one)))
        taken.update(enumerate(best))
        width = widths(band)
        found.append(BoardParameters(width, _margin(margin, width, some), *best, certify=certify))
    # What had no turn.
    depths = set(_BOARD_DEPTHS) - {one.depth for one in found}
    return (*found, *(BoardParameters(MAX_WIDTH, 0, depth, 1, 1, certify=False) for depth in sorted(depths)))
