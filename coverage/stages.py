"""The stages of a sign-off, and what each asks of the figures: read from stages.toml.

The one place that turns measured figures into a verdict; the gate asks it again before a bitstream.
"""

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import isfinite
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input

STAGES = ("V1", "V2", "V3")
STAGES_FILE = Path(__file__).with_name("stages.toml")
_KEYS = ({"meaning", "unit", "at_least"}, {"meaning", "unit", "at_most"})

Values = Mapping[str, float | int | None]


@dataclass(frozen=True)
class Figure:
    """A figure and its bound at each stage; ``is_most``: the bound is an upper one."""

    name: str
    meaning: str
    unit: str
    bounds: Mapping[str, float]
    is_most: bool

    def is_met(self, value: float | None, stage: str) -> bool:
        """Return whether a value, None where it was not measured, is enough for a stage."""
        if stage not in self.bounds:
            return True
        if value is None:
            return False
        return value <= self.bounds[stage] if self.is_most else value >= self.bounds[stage]

    def text(self, value: float | None) -> str:
        """Return a value as people read it; no rounding may lift a value to its bound."""
        if value is None:
            return "not measured"
        number = f"{int(value) if value == int(value) else value:,}"
        return f"{number} {self.unit}".rstrip()

    def shortfall(self, value: float | None, stage: str) -> str:
        """Return what is wanted, in a line."""
        wanted = "at most" if self.is_most else "at least"
        return f"{stage}: {self.meaning}: {self.text(value)}, wanted {wanted} {self.text(self.bounds[stage])}"


@dataclass(frozen=True)
class Judgement:
    """The stage reached, None where not even the first, and what the last stage still lacks."""

    stage: str | None
    shortfalls: tuple[str, ...]

    @property
    def passed(self) -> bool:
        """Return whether the last stage is reached."""
        return self.stage == STAGES[-1]


def share(part: int, whole: int) -> float | None:
    """Return a share in percent, rounded down to two decimals: 100 means all. None: a share of nothing."""
    return part * 10_000 // whole / 100 if whole else None


def judge(figures: Sequence[Figure], values: Values) -> Judgement:
    """Return how far the values go; raise InputError where they are not those of the figures."""
    names = {figure.name for figure in figures}
    if names != set(values):
        odd = ", ".join(sorted(names ^ set(values)))
        raise InputError(
            f"figures of a sign-off: {odd}: measured without a bound in stages.toml, or bounded there and "
            "not measured"
        )
    reached = None
    for stage in STAGES:
        if not all(figure.is_met(values[figure.name], stage) for figure in figures):
            break
        reached = stage
    last = STAGES[-1]
    missing = [f.shortfall(values[f.name], last) for f in figures if not f.is_met(values[f.name], last)]
    return Judgement(reached, tuple(missing))


def read_figures(path: Path = STAGES_FILE) -> tuple[Figure, ...]:
    """Return the figures with their bounds; raise InputError where the file is wrong."""
    data = read_input(path)
    try:
        content = tomllib.loads(data.decode())
    except ValueError as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    if not content:
        raise InputError(f"{path}: holds no figure: a sign-off that asks for nothing would pass")
    return tuple(_figure(name, entry, path) for name, entry in content.items())


def _figure(name: str, entry: Any, path: Path) -> Figure:
    where = f"{path}: {name}"
    if not isinstance(entry, dict) or set(entry) not in _KEYS:
        raise InputError(f"{where}: must hold meaning, unit, and one of at_least and at_most")
    is_most = "at_most" in entry
    bounds = entry["at_most" if is_most else "at_least"]
    good = isinstance(bounds, dict) and all(
        stage in STAGES and type(bound) in (int, float) and isfinite(bound) for stage, bound in bounds.items()
    )
    if not good or STAGES[-1] not in bounds:
        raise InputError(f"{where}: bounds must be numbers for {', '.join(STAGES)}; {STAGES[-1]} needs one")
    ordered = [bounds[stage] for stage in STAGES if stage in bounds]
    if ordered != sorted(ordered, reverse=is_most):
        raise InputError(f"{where}: a later stage asks for less than an earlier one")
    return Figure(name, str(entry["meaning"]), str(entry["unit"]), dict(bounds), is_most)
