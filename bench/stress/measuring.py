"""One setting of a knob, measured: the methods, the core at its own resolution, and the no-miss mode.

The core takes whole numbers of its width: as they are where they fit, and rounded to a grid of 16 bits. It
is exact on what it is given, so all that it gets wrong about the unrounded pairs is quantisation. With
resolution R and margin m, near on the grid means at most (m + 1) R in reality (each triangle moves by at most
R / 2), and a distance of 0 is never missed with m = 1: the no-miss mode. Its false alarms are pairs at a
distance in (0, 2 R].

Exact are the verdicts of the bulk checker on 32 bits, of which the judge sees a sample, and of the judge
beyond.
"""

from bisect import bisect_left
from collections.abc import Callable
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, partial, reduce
from operator import add

import numpy as np
import numpy.typing as npt

from triaxis.bench.harness import Progress
from triaxis.bench.stress.families import FAMILIES, Family
from triaxis.bench.stress.orders import METHODS, Answers, Mask, OrderErrors, errors, method_errors
from triaxis.golden.bulk import bulk_facts
from triaxis.golden.judge import judge
from triaxis.golden.processes import in_processes
from triaxis.host.quantise import (
    Grid,
    Steps,
    box_of,
    finest_resolution,
    fits,
    grid_around,
    margin_for,
    quantise,
)
from triaxis.sim.core_engine import RtlEngine, configuration_for
from triaxis.sim.result import NEAR
from triaxis.verif.core.stimulus.stimulus import Ints, Pairs32, chosen_rows
from triaxis.verif.core.stimulus.symmetry import NUM_ORDERS, all_orders

# One in so many of the bulk checker's verdicts is judged again by the linear program.
JUDGED_ONE_IN = 100


class ExactPairs:
    """Pairs (N, 2, 3, 3) whose exact Chebyshev distances can be compared with whole limits.

    ``bulk``: pairs of 32 bits, which are left to the bulk checker; a sample, or else every pair, is judged by
    the linear program, with a certificate that is checked. ``judged``: how many are; ``contradicted``: how
    many of the bulk checker's answers on them it contradicts.
    """

    def __init__(self, pairs: Ints, bulk: bool) -> None:
        """Judge the sample, or all pairs."""
        self._pairs = pairs.astype(np.int32) if bulk else None
        self._sample = np.arange(0, len(pairs), JUDGED_ONE_IN if bulk else 1)
        self._distances = [judge(a, b, 0).distance for a, b in chosen_rows(pairs, self._sample).tolist()]
        self.judged, self.contradicted = len(self._distances), 0

    def within(self, limit: int) -> Mask:
        """Return which pairs are at most ``limit`` units from each other: (N,)."""
        judged = np.array([distance <= limit for distance in self._distances], np.bool_)
        if self._pairs is None:
            return judged
        near = bulk_facts(self._pairs, limit).near
        self.contradicted += int((near[self._sample] != judged).sum())
        return near

    def reach(self, chosen: Mask, most: int) -> int | None:
        """Return the least whole limit, up to ``most``, that all chosen pairs are within; None if none is."""
        found = bisect_left(range(most + 1), True, key=lambda limit: (self.within(limit) | ~chosen).all())
        return found if found <= most else None


# Widths of the simulated cores; a setting's own resolution is the first that holds its pairs as they are.
WIDTHS = (8, 12, 16, 24, 32)
# The core that gets the pairs rounded.
ROUNDING_WIDTH = 16
# No pair at this distance is missed: collision.
CLEARANCE = Fraction(0)

# From a width, pairs of it (N, 2, 3, 3) and a margin: near, (N,).
Core = Callable[[int, Pairs32, int], Mask]


@cache
def core_engine(width: int) -> RtlEngine:
    """Return the Verilated core of a width, built where needed."""
    return RtlEngine(configuration_for(width, 1))


def rtl_core(width: int, pairs: Pairs32, margin: int) -> Mask:
    """Return what the Verilated core of that width says."""
    words, _ = core_engine(width).words(pairs, np.full(len(pairs), margin, np.uint32))
    return (words & NEAR) != 0


@dataclass(frozen=True)
class SettingResult:
    """What was found at one setting; counts are of answers in all 72 orders unless it says pairs.

    pairs, near_pairs: of the unrounded pairs. judged_pairs: of these and of the rounded ones, by the linear
    program, which contradicts ``contradicted`` of the bulk checker's answers. own_width: of the core that
    holds them as they are.
    core: against the exact verdict on what it was given, as they are and rounded, at margins 0 and 1.
    methods: by name. resolution: of the rounding, in units of the pairs. rounded: margin 0 on rounded pairs,
    no_miss: margin 1, both against the unrounded. band_pairs: clear pairs within the band, which may raise
    false alarms; beyond_band: false alarms of the no-miss mode that are not; farthest: the farthest false
    alarm, in LSB, rounded up to a whole unit.
    """

    pairs: int
    near_pairs: int
    judged_pairs: int
    contradicted: int
    own_width: int | None
    core: OrderErrors
    methods: dict[str, OrderErrors]
    resolution: int
    rounded: OrderErrors
    no_miss: OrderErrors
    band_pairs: int
    beyond_band: int
    farthest: float

    @property
    def problems(self) -> list[str]:
        """Return what must not be."""
        found: list[str] = []
        if self.core.wrong or self.core.changing_pairs:
            found.append(f"core: {self.core.wrong} wrong answers at its own resolution")
        if self.no_miss.misses:
            found.append(f"no-miss mode: {self.no_miss.misses} misses")
        if self.beyond_band:
            found.append(f"no-miss mode: {self.beyond_band} false alarms beyond the band")
        if self.contradicted:
            found.append(f"bulk checker: {self.contradicted} verdicts contradicted by the linear program")
        return found


def _own_width(facets: npt.NDArray[np.float64]) -> int | None:
    """Return the first width whose grid of whole units holds the facets, placed around them."""
    boxes = [box_of(facets)]
    return next((w for w in WIDTHS if fits(boxes, grid_around(boxes, Fraction(1), w))), None)


def _rounding_grid(facets: npt.NDArray[np.float64]) -> Grid:
    """Return the finest grid of ROUNDING_WIDTH around the facets whose resolution is a power of 2, or 1."""
    box = box_of(facets)
    finest = finest_resolution(box, ROUNDING_WIDTH, steps=Steps.BINARY)
    return grid_around([box], max(finest, Fraction(1)), ROUNDING_WIDTH)


def _on(grid: Grid, facets: npt.NDArray[np.float64]) -> Pairs32:
    return quantise(facets, grid, "pairs").reshape(-1, 2, 3, 3).astype(np.int32)


def _asked(core: Core, width: int, pairs: Pairs32, margin: int) -> Answers:
    """Return the core's answers in all orders: (72, N)."""
    return core(width, all_orders(pairs), margin).reshape(-1, NUM_ORDERS).T


def measure(pairs: Ints, core: Core = rtl_core, margin: int | None = None) -> SettingResult:
    """Measure everything on pairs (N, 2, 3, 3) of whole numbers below 2^53.

    ``margin``: of the no-miss mode, in LSB, where it shall not be what the theorem says.
    """
    facets = pairs.reshape(-1, 3, 3).astype(np.float64)
    width, grid = _own_width(facets), _rounding_grid(facets)
    wanted = margin_for(CLEARANCE, grid) if margin is None else margin
    rounded = _on(grid, facets)
    at_zero, at_margin = (_asked(core, ROUNDING_WIDTH, rounded, m) for m in (0, wanted))
    on_grid = ExactPairs(rounded.astype(np.int64), bulk=True)
    own = [errors(at_zero, on_grid.within(0)), errors(at_margin, on_grid.within(wanted))]
    # Where a core holds the pairs as they are, so does the bulk checker, about an offset of their own.
    whole = pairs if width is None else _on(grid_around([box_of(facets)], Fraction(1), width), facets)
    exact = ExactPairs(whole.astype(np.int64), bulk=width is not None)
    near = exact.within(0)
    if width is not None:
        own.append(errors(_asked(core, width, whole.astype(np.int32), 0), near))
    resolution = int(grid.resolution)
    limit = (margin_for(CLEARANCE, grid) + 1) * resolution
    in_band = exact.within(limit) & ~near
    alarms = at_margin & ~near
    farthest = exact.reach(alarms.any(0) & in_band, limit)
    return SettingResult(
        pairs=len(pairs),
        near_pairs=int(near.sum()),
        judged_pairs=exact.judged + on_grid.judged,
        contradicted=exact.contradicted + on_grid.contradicted,
        own_width=width,
        core=reduce(add, own),
        methods={method.name: method_errors(method, pairs, near) for method in METHODS},
        resolution=resolution,
        rounded=errors(at_zero, near),
        no_miss=errors(at_margin, near),
        band_pairs=int(in_band.sum()),
        beyond_band=int((alarms & ~in_band).sum()),
        farthest=(farthest or 0) / resolution,
    )


# Of a run: a core to build, a setting to measure.
STEPS = len(WIDTHS) + sum(len(family.settings) for family in FAMILIES)


@dataclass(frozen=True)
class Settings:
    """What was measured at several settings, and sums over them."""

    measured: tuple[SettingResult, ...]

    @property
    def core(self) -> OrderErrors:
        """Return the core's errors at its own resolution."""
        return reduce(add, (one.core for one in self.measured))

    @property
    def no_miss(self) -> OrderErrors:
        """Return the errors of the no-miss mode."""
        return reduce(add, (one.no_miss for one in self.measured))

    @property
    def beyond_band(self) -> int:
        """Return the number of false alarms of the no-miss mode beyond its band."""
        return sum(one.beyond_band for one in self.measured)


@dataclass(frozen=True)
class FamilyResult(Settings):
    """A family, and what was measured at each of its settings."""

    family: Family


@dataclass(frozen=True)
class StressResult:
    """What was measured, with which seed and how many pairs at each setting."""

    seed: int
    pairs: int
    families: tuple[FamilyResult, ...]

    @property
    def whole(self) -> Settings:
        """Return what was measured at the settings of all families."""
        return Settings(tuple(one for family in self.families for one in family.measured))

    @property
    def problems(self) -> list[str]:
        """Return what must not be, anywhere, with the setting."""
        return [
            f"{result.family.name} {setting.label}: {problem}"
            for result in self.families
            for setting, measured in zip(result.family.settings, result.measured, strict=True)
            for problem in measured.problems
        ]


def measure_setting(place: tuple[int, int], seed: int, pairs: int) -> SettingResult:
    """Measure a setting of a family, by their numbers."""
    family = FAMILIES[place[0]]
    rng = np.random.default_rng([seed, place[1], *family.name.encode()])
    return measure(family.settings[place[1]].make(rng, pairs))


def run_stress(seed: int, pairs: int, progress: Progress) -> StressResult:
    """Measure everything; ``progress`` is told of each of STEPS."""
    for width in WIDTHS:
        core_engine(width)
        progress(1)
    places = [(f, s) for f, family in enumerate(FAMILIES) for s in range(len(family.settings))]
    work = partial(measure_setting, seed=seed, pairs=pairs)
    measured = iter(in_processes(work, places, lambda _: progress(1)))
    families = (FamilyResult(tuple(next(measured) for _ in family.settings), family) for family in FAMILIES)
    return StressResult(seed, pairs, tuple(families))
