"""What the pictures show of a family: shares, one number for each setting."""

from collections.abc import Callable
from dataclasses import dataclass

from matplotlib.typing import LineStyleType

from triaxis.bench.stress.measuring import ROUNDING_WIDTH, Measured
from triaxis.bench.stress.orders import METHODS, Method
from triaxis.bench.stress.run import FamilyResult, StressResult
from triaxis.host.figure_style import GAP, WITNESS

# Colours of M. Okabe and K. Ito, "Color Universal Design", 2008, as in triaxis.host.figure_style.
_COLOURS = {"SAT": "#0072B2", "Moller": "#E69F00", "Guigue-Devillers": "#CC79A7"}
_MARKERS = {"SAT": "o", "Moller": "^", "Guigue-Devillers": "s"}
_BAND = "#9A9A9A"


@dataclass(frozen=True)
class Curve:
    """A line of a picture: what it shows of a setting, and its look.

    ``filled``: down to 0. ``counted``: what the legend says of it, from all settings together.
    """

    label: str
    share: Callable[[Measured], float]
    colour: str
    line: LineStyleType = "-"
    marker: str = ""
    width: float = 1.4
    hollow: bool = False
    filled: bool = False
    counted: Callable[[StressResult], str] | None = None

    def shares(self, result: FamilyResult) -> list[float]:
        """Return its share at each setting, in percent."""
        return [100 * self.share(measured) for measured in result.measured]


@dataclass(frozen=True)
class Picture:
    """Curves for every family: ``name`` of its files, and their title."""

    name: str
    title: str
    about: str
    axis: str
    curves: tuple[Curve, ...]


def _of_method(method: Method, share: Callable[[Measured], float]) -> Curve:
    single = method.name.startswith("float32")
    return Curve(
        method.name,
        share,
        _COLOURS[method.title],
        "--" if single else "-",
        _MARKERS[method.title],
        hollow=single,
    )


def _wrong(method: Method) -> Curve:
    return _of_method(method, lambda measured: measured.methods[method.name].rate)


def _changing(method: Method) -> Curve:
    return _of_method(method, lambda measured: measured.methods[method.name].changing_rate)


def _core_wrong(result: StressResult) -> str:
    return f"{result.core.wrong} of {result.core.answers:,} wrong"


def _missed(result: StressResult) -> str:
    return f"{result.no_miss.misses} of {result.no_miss.answers:,}"


def _alarms(result: StressResult) -> str:
    return f"{result.no_miss.false_alarms:,}, {result.beyond_band:,} beyond the band"


def _core_changing(result: StressResult) -> str:
    return f"{result.core.changing_pairs} of {result.core.pairs:,}"


ERRORS = Picture(
    "stress",
    "Wrong answers of triangle tests, as inputs go from easy (left) to impossible (right)",
    "near or clear, in all 72 orders of every pair, against exact verdicts on the coordinates as given; the "
    "core: on what it is given, at its own resolution",
    "wrong answers (%)",
    (
        *(_wrong(method) for method in METHODS),
        Curve("core, as simulated", lambda m: m.core.rate, GAP, width=4.5, counted=_core_wrong),
        Curve(
            f"no-miss mode at {ROUNDING_WIDTH} bits, missed",
            lambda m: m.no_miss.misses / m.no_miss.answers,
            WITNESS,
            ":",
            width=1.8,
            counted=_missed,
        ),
    ),
)
ORDERS = Picture(
    "stress_orders",
    "Pairs whose answer hangs on the order of their vertices and triangles, from easy (left) to impossible",
    "the same pair in all 72 orders (6 x 6 of the vertices, A and B exchanged): not always the same answer",
    "pairs (%)",
    (
        *(_changing(method) for method in METHODS),
        Curve("core, as simulated", lambda m: m.core.changing_rate, GAP, width=4.5, counted=_core_changing),
    ),
)
QUANTISATION = Picture(
    "stress_quantisation",
    f"What rounding to {ROUNDING_WIDTH} bits costs, and what the no-miss mode makes of it, from easy (left) "
    "to impossible",
    "the core on rounded coordinates against exact verdicts on the unrounded ones; the no-miss mode has a "
    "margin of 1 LSB, and its band ends at a distance of 2 LSB",
    "answers (%)",
    (
        Curve(
            "clear pairs at most 2 LSB apart: the band",
            lambda m: m.band_pairs / m.pairs,
            _BAND,
            width=0,
            filled=True,
        ),
        Curve(
            "no-miss mode, false alarms",
            lambda m: m.no_miss.false_alarms / m.no_miss.answers,
            "#0072B2",
            "-",
            "o",
            counted=_alarms,
        ),
        Curve(
            "no-miss mode, missed collisions",
            lambda m: m.no_miss.misses / m.no_miss.answers,
            GAP,
            width=4.5,
            counted=_missed,
        ),
        Curve(
            "without margin, false alarms",
            lambda m: m.rounded.false_alarms / m.rounded.answers,
            "#56B4E9",
            "--",
            "^",
            hollow=True,
        ),
        Curve(
            "without margin, missed collisions",
            lambda m: m.rounded.misses / m.rounded.answers,
            "#D55E00",
            "--",
            "x",
        ),
    ),
)
PICTURES = (ERRORS, ORDERS, QUANTISATION)
