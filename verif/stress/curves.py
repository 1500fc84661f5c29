"""What the pictures show of a family: shares, one number for each setting."""

from collections.abc import Callable
from dataclasses import dataclass

from triaxis.verif.counterexample.style import GAP, WITNESS
from triaxis.verif.stress.measuring import ROUNDING_WIDTH, Measured
from triaxis.verif.stress.orders import METHODS, Method
from triaxis.verif.stress.run import FamilyResult

# Colours of M. Okabe and K. Ito, "Color Universal Design", 2008, as in triaxis.verif.counterexample.style.
_COLOURS = {"SAT": "#0072B2", "Moller": "#E69F00", "Guigue-Devillers": "#CC79A7"}
_MARKERS = {"SAT": "o", "Moller": "^", "Guigue-Devillers": "s"}
_BAND = "#9A9A9A"


@dataclass(frozen=True)
class Curve:
    """A line of a picture: what it shows of a setting, and its look. ``filled``: down to 0."""

    label: str
    share: Callable[[Measured], float]
    colour: str
    line: str = "-"
    marker: str = ""
    width: float = 1.4
    hollow: bool = False
    filled: bool = False

    def shares(self, result: FamilyResult) -> list[float]:
        """Return its share at each setting, in percent."""
        return [100 * self.share(measured) for measured in result.measured]


@dataclass(frozen=True)
class Picture:
    """Curves for every family: ``name`` of its files, and what stands above."""

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


_CORE = f"{GAP}"

ERRORS = Picture(
    "stress",
    "Wrong answers of triangle tests, each knob turned from easy to impossible",
    "near or clear, in all 72 orders of every pair, against exact verdicts on the coordinates as given; the "
    "core on integers of its own width",
    "wrong answers (%)",
    (
        *(_wrong(method) for method in METHODS),
        Curve("core, at its own resolution", lambda m: m.core.rate, _CORE, width=4.5),
        Curve(
            f"no-miss mode, {ROUNDING_WIDTH} bits: missed collisions",
            lambda m: m.no_miss.misses / m.no_miss.answers,
            WITNESS,
            ":",
            width=1.8,
        ),
    ),
)
ORDERS = Picture(
    "stress_orders",
    "Pairs whose answer hangs on the order of their vertices and triangles",
    "the same pair in all 72 orders (6 x 6 of the vertices, A and B exchanged): not always the same answer",
    "pairs (%)",
    (
        *(_changing(method) for method in METHODS),
        Curve("core, at its own resolution", lambda m: m.core.changing_rate, _CORE, width=4.5),
    ),
)
QUANTISATION = Picture(
    "stress_quantisation",
    f"What rounding to {ROUNDING_WIDTH} bits costs the core, and what the no-miss mode makes of it",
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
            "no-miss mode: false alarms",
            lambda m: m.no_miss.false_alarms / m.no_miss.answers,
            "#0072B2",
            "-",
            "o",
        ),
        Curve(
            "no-miss mode: missed collisions",
            lambda m: m.no_miss.misses / m.no_miss.answers,
            _CORE,
            width=4.5,
        ),
        Curve(
            "without margin: false alarms",
            lambda m: m.rounded.false_alarms / m.rounded.answers,
            "#56B4E9",
            "--",
            "^",
            hollow=True,
        ),
        Curve(
            "without margin: missed collisions",
            lambda m: m.rounded.misses / m.rounded.answers,
            "#D55E00",
            "--",
            "x",
        ),
    ),
)
PICTURES = (ERRORS, ORDERS, QUANTISATION)
