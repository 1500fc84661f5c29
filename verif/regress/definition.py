"""The regressions as data: their tests, made of the table of tests, their goals, their runs."""

import argparse
import copy
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import hjson

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import ROOT
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.records import PlannedRun, add_options
from triaxis.verif.testbench.settings import width_of
from triaxis.verif.testbench.test_table import Entry, Runs, configurations, table

DEFINITION = Path(__file__).with_name("triaxis_sim_cfg.hjson")
TESTPLAN = ROOT / "coverage" / "testplan.hjson"
# The regression whose outcomes the history keeps, and the pairs of its volume.
NIGHTLY = "nightly"
_VOLUME, _VOLUME_JUDGED = 1_000_000_000, 1 << 16
# Seeds go through SystemVerilog's int.
_SEEDS = 1 << 31
# Of a build: against hanging only. dvsim starts what has the longest limit first; the widest take
# longest.
_LIMIT_MINUTES = 240
# dvsim's word for a testpoint that no simulation is mapped to.
_NO_SIMULATION = ["N/A"]


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
    """Everything. ``content`` is what dvsim is to read, for the files that are made of it."""

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
        """Return a copy of the content in which these keys have these values."""
        return copy.deepcopy(dict(self.content)) | dict(changes)

    def plan(self, name: str, base: int, multiplier: float = 1.0) -> list[PlannedRun]:
        """Return all runs of a regression; ``multiplier`` scales the seeds of each test, one is left."""
        regression = self.regression(name)
        return [
            PlannedRun(i.name, i.test, i.config, seed_of(base, i.name, n), i.pairs, i.agent, i.judged_one_in)
            for i in (self.items[one] for one in regression.items)
            for n in range(max(1, round((regression.seeds or i.seeds) * multiplier)))
        ]


def seed_of(base: int, item: str, number: int) -> int:
    """Return the seed of a run: it follows from the regression's, and no two runs share their stimulus."""
    digest = hashlib.sha256(f"{base} {item} {number}".encode()).digest()
    return int.from_bytes(digest[:8], "big") % _SEEDS


class _Options(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise ValueError(message)


def read_definition(path: Path = DEFINITION) -> Definition:
    """Return what the file defines; one that names no tests has those of the table.

    Raises InputError where it is not readable, or contradicts itself.
    """
    data = read_input(path)
    try:
        content = hjson.loads(data.decode())
        if "tests" not in content:
            content = _with_table(content)
        items = [_item(raw, content) for raw in content["tests"]]
        by_name = {item.name: item for item in items}
        if len(by_name) != len(items):
            raise ValueError("two tests have the same name")
        regressions = _regressions(content, by_name)
    except (hjson.HjsonDecodeError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a definition of regressions: {error!r}") from error
    return Definition(path, content, by_name, regressions)


def _with_table(flow: Mapping[str, Any]) -> dict[str, Any]:
    """Return the flow's keys with the builds, tests and regressions that the table of tests makes."""
    runs = [
        (entry, runs, config)
        for entry in table().values()
        for runs in (*entry.runs, *entry.volume_runs(_VOLUME, _VOLUME_JUDGED))
        if runs.seeds
        for config in runs.configs
    ]
    smoke = [runs.name(entry.name, config) for entry, runs, config in runs if config in runs.smoke]
    return {
        **flow,
        "primary_build_mode": configurations()[0],
        "build_modes": [
            *flow["build_modes"],
            *(_build(config, {r.agent for _, r, c in runs if c == config}) for config in configurations()),
        ],
        "tests": [_test(*one) for one in runs],
        "regressions": [
            # Is anything broken? Every test and every configuration once: more seeds find what is rare.
            {"name": "smoke", "reseed": 1, "tests": smoke},
            {"name": NIGHTLY, "tests": [runs.name(entry.name, config) for entry, runs, config in runs]},
        ],
    }


def _build(config: str, agents: set[str]) -> dict[str, Any]:
    # The number, because dvsim takes builds that differ in nothing but their names for one.
    number = f"--number {configurations().index(config)}"
    options = [f"--config {config}", number, *(f"--agent {agent}" for agent in sorted(agents))]
    minutes = _LIMIT_MINUTES + width_of(config)
    return {"name": config, "build_opts": options, "build_timeout_mins": minutes}


def _test(entry: Entry, runs: Runs, config: str) -> dict[str, Any]:
    return {
        "name": runs.name(entry.name, config),
        "uvm_test": entry.name,
        "build_mode": config,
        "run_opts": [f"--pairs {runs.pairs}", f"--agent {runs.agent}", f"--judged {runs.judged}"],
        "reseed": runs.seeds,
    }


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
    found: dict[str, Regression] = {}
    for name, one in raw.items():
        wanted = set(one["tests"])
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


def write_view(path: Path, items: Sequence[Item], testplan: Path = TESTPLAN) -> None:
    """Write the testplan as dvsim wants it: the tests of a testpoint by their names in the regressions."""
    try:
        content = hjson.loads(read_input(testplan).decode())
        points = [_testpoint(point, items) for point in content["testpoints"]]
    except (hjson.HjsonDecodeError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{testplan}: not a testplan: {error!r}") from error
    write_whole(path, json.dumps({"name": "triaxis", "testpoints": points}, indent=1) + "\n")


def _testpoint(point: Mapping[str, Any], items: Sequence[Item]) -> dict[str, Any]:
    wanted = set(point.get("tests", []))
    names = [item.name for item in items if item.test in wanted]
    return {**{key: point[key] for key in ("name", "desc", "stage")}, "tests": names or _NO_SIMULATION}


def in_checkout(path: Path) -> str:
    """Return a path as it is best shown: relative where it lies in the checkout."""
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)
