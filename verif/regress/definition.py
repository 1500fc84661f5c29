"""The Hjson file of the regressions as data: its tests, its regressions, their goals."""

import argparse
import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.sim.paths import ROOT
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.planned_run import add_options

DEFINITION = Path(__file__).with_name("triaxis_sim_cfg.hjson")
_INSTALL = "run `make regress`, which installs it"


@dataclass(frozen=True)
class Item:
    """A test as dvsim sees it: a UVM test in a configuration; ``seeds``: how many times it runs."""

    name: str
    test: str
    config: str
    pairs: int
    agent: str
    judged_one_in: int
    seeds: int


@dataclass(frozen=True)
class Regression:
    """Tests by name, in the order of the file. ``seeds``: in place of those of its tests, None: as they say.

    ``least_pairs``: fewer checked fail it; ``all_covered``: so does a coverage bin below its goal.
    """

    name: str
    items: tuple[str, ...]
    seeds: int | None
    least_pairs: int
    all_covered: bool


@dataclass(frozen=True)
class Definition:
    """The whole file. ``content`` is what was read, for the files that are made of it."""

    path: Path
    content: Mapping[str, Any]
    items: dict[str, Item]
    regressions: dict[str, Regression]

    def regression(self, name: str) -> Regression:
        """Return the regression of that name; raise InputError where there is none."""
        if name not in self.regressions:
            known = ", ".join(self.regressions)
            raise InputError(f"regression {name or repr(name)}: unknown; one of: {known}")
        return self.regressions[name]

    def part(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Return a copy of the file's content in which these keys have these values."""
        return copy.deepcopy(dict(self.content)) | dict(changes)


class _Options(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise ValueError(message)


def read_definition(path: Path = DEFINITION) -> Definition:
    """Return what the file defines; raise InputError where it is not readable, or contradicts itself."""
    try:
        import hjson
    except ImportError as error:
        raise InputError(f"hjson: not in this Python environment: {_INSTALL}") from error
    data = read_input(path)
    try:
        content = hjson.loads(data.decode())
        items = [_item(raw, content) for raw in content["tests"]]
        by_name = {item.name: item for item in items}
        if len(by_name) != len(items):
            raise ValueError("two tests have the same name")
        regressions = _regressions(content, by_name)
    except (hjson.HjsonDecodeError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a definition of regressions: {error!r}") from error
    return Definition(path, content, by_name, regressions)


def _item(raw: Mapping[str, Any], content: Mapping[str, Any]) -> Item:
    name, config, seeds = raw["name"], raw["build_mode"], raw.get("reseed", content.get("reseed", 1))
    if config not in {mode["name"] for mode in content["build_modes"]}:
        raise ValueError(f"test {name}: no build mode {config}")
    if not isinstance(seeds, int) or seeds < 1:
        raise ValueError(f"test {name}: reseed {seeds}: must be at least 1")
    model_of(config)
    parser = _Options(add_help=False)
    add_options(parser)
    try:
        options = parser.parse_args(" ".join(raw["run_opts"]).split())
    except ValueError as error:
        raise ValueError(f"test {name}: run_opts: {error}") from error
    return Item(name, raw["uvm_test"], config, options.pairs, options.agent, options.judged, seeds)


def _regressions(content: Mapping[str, Any], items: Mapping[str, Item]) -> dict[str, Regression]:
    raw = {one["name"]: one for one in content["regressions"]}
    goals = {one["regression"]: one for one in content.get("goals", [])}
    if unknown := goals.keys() - raw.keys():
        raise ValueError(f"goals of {', '.join(sorted(unknown))}: no such regression")

    def names(name: str) -> set[str]:
        own = set(raw[name].get("tests", []))
        return own.union(*(names(other) for other in raw[name].get("regressions", [])))

    found: dict[str, Regression] = {}
    for name, one in raw.items():
        wanted = names(name)
        if missing := wanted - items.keys():
            raise ValueError(f"regression {name}: no test {', '.join(sorted(missing))}")
        if not wanted:
            raise ValueError(f"regression {name}: it has no tests")
        goal = goals.get(name, {})
        found[name] = Regression(
            name,
            tuple(item for item in items if item in wanted),
            one.get("reseed"),
            int(goal.get("pairs", 0)),
            bool(goal.get("coverage", False)),
        )
    return found


def in_checkout(path: Path) -> str:
    """Return a path as it is best shown: relative where it lies in the checkout."""
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)
