"""The regressions as data: their tests, made of the table of tests, their goals, their runs."""

import hashlib
import json
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import hjson

from triaxis.coverage.testplan import NOT_SIMULATED, TESTPLAN
from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import ROOT
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.regress.covering import array_runs
from triaxis.verif.regress.records import PlannedRun
from triaxis.verif.testbench.settings import BURST, PIN, width_of
from triaxis.verif.testbench.table import Entry, Runs, configurations, table

DEFINITION = Path(__file__).with_name("triaxis_sim_cfg.hjson")
# The regression whose outcomes the history keeps, and the pairs of its volume.
NIGHTLY = "nightly"
_VOLUME, _VOLUME_JUDGED = 1_000_000_000, 1 << 16
# Seeds go through SystemVerilog's int.
_SEEDS = 1 << 31
# Of a build: against hanging only. dvsim starts what has the longest limit first; the widest take
# longest.
_LIMIT_MINUTES = 240
_GOALS = frozenset({"regression", "pairs", "coverage", "uncovered"})


@dataclass(frozen=True)
class Item:
    """A test as dvsim sees it: a UVM test in a configuration; ``seeds``: how many times it runs.

    ``run``: one of its runs, of no seed yet.
    """

    run: PlannedRun
    seeds: int


@dataclass(frozen=True)
class Regression:
    """Tests by name, in the order of the file. ``seeds``: in place of those of its tests, None: as they say.

    ``least_pairs``: fewer checked fail it; ``all_covered``: so does a coverage bin below its goal, but in
    the configurations of ``uncovered``, which see too few pairs.
    """

    name: str
    items: tuple[str, ...]
    seeds: int | None
    least_pairs: int
    all_covered: bool
    uncovered: frozenset[str] = frozenset()


@dataclass(frozen=True)
class Definition:
    """Everything. ``content`` is what dvsim is to read, for the files that are made of it."""

    content: Mapping[str, Any]
    items: dict[str, Item]
    regressions: dict[str, Regression]

    def regression(self, name: str) -> Regression:
        """Return the regression of that name; raise InputError where there is none."""
        if name not in self.regressions:
            known = ", ".join(self.regressions)
            raise InputError(f"regression {name or repr(name)}: unknown; one of: {known}")
        return self.regressions[name]

    def plan(self, name: str, base: int, multiplier: float = 1.0) -> list[PlannedRun]:
        """Return all runs of a regression; ``multiplier`` scales the seeds of each test, one is left."""
        regression = self.regression(name)
        return [
            replace(item.run, seed=_seed_of(base, item.run.item, n))
            for item in (self.items[one] for one in regression.items)
            for n in range(max(1, round((regression.seeds or item.seeds) * multiplier)))
        ]


def _seed_of(base: int, item: str, number: int) -> int:
    """Return the seed of a run: it follows from the regression's, and no two runs share their stimulus."""
    digest = hashlib.sha256(f"{base} {item} {number}".encode()).digest()
    return int.from_bytes(digest[:8], "big") % _SEEDS


def read_definition(path: Path = DEFINITION) -> Definition:
    """Return what the file defines; one that names no tests has those of the table.

    Raises InputError where it is not readable, or contradicts itself.
    """
    data = read_input(path)
    try:
        content = hjson.loads(data.decode())
        if "tests" not in content:
            content = _with_table(content)
        items = {raw["name"]: _item(raw, content) for raw in content["tests"]}
        if len(items) != len(content["tests"]):
            raise ValueError("two tests have the same name")
        goals = {goal["regression"]: goal for goal in content.get("goals", [])}
        # Of two the last would count alone, and a goal of another name would ask for nothing.
        for listed, key in (("goals", "regression"), ("regressions", "name")):
            counts = Counter(one[key] for one in content.get(listed, []))
            if twice := [name for name, count in counts.items() if count > 1]:
                raise ValueError(f"{listed}: two of {', '.join(twice)}")
        for name, goal in goals.items():
            if unknown := sorted(goal.keys() - _GOALS):
                raise ValueError(
                    f"goals of {name}: {', '.join(unknown)}: one of: {', '.join(sorted(_GOALS))}"
                )
        regressions = {
            raw["name"]: _regression(raw, goals.pop(raw["name"], {}), items) for raw in content["regressions"]
        }
        if goals:
            raise ValueError(f"goals of {', '.join(sorted(goals))}: no such regression")
    except (hjson.HjsonDecodeError, ValueError, KeyError, TypeError) as error:
        raise InputError(f"{path}: not a definition of regressions: {error!r}") from error
    return Definition(content, items, regressions)


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
    runs += [(table()[test], runs, config) for test, runs in array_runs() for config in runs.configs]
    tests = [_test(*one) for one in runs]
    agents: dict[str, set[str]] = defaultdict(set)
    for _, run, config in runs:
        agents[config].add(run.agent)
    builds = [_build(number, *one) for number, one in enumerate(agents.items())]
    uncovered = sorted(agents.keys() - set(configurations()))
    goals = [{**goal, "uncovered": uncovered} for goal in flow.get("goals", [])]
    return {
        **flow,
        "goals": goals,
        "primary_build_mode": configurations()[0],
        "build_modes": [*flow["build_modes"], *builds],
        "tests": tests,
        "regressions": [
            # Is anything broken? Every test and every configuration once: more seeds find what is rare.
            {"name": "smoke", "reseed": 1, "tests": smoke},
            {"name": NIGHTLY, "tests": [test["name"] for test in tests]},
        ],
    }


def _build(number: int, config: str, agents: set[str]) -> dict[str, Any]:
    # The number, because dvsim takes builds that differ in nothing but their names for one.
    options = [f"--config {config}", f"--number {number}", *(f"--agent {agent}" for agent in sorted(agents))]
    minutes = _LIMIT_MINUTES + width_of(config)
    return {"name": config, "build_opts": options, "build_timeout_mins": minutes}


def _test(entry: Entry, runs: Runs, config: str) -> dict[str, Any]:
    name = runs.name(entry.name, config)
    run = PlannedRun(name, entry.name, config, 0, runs.pairs, runs.agent, runs.judged)
    return as_test(name, run, runs.seeds)


def as_test(name: str, run: PlannedRun, seeds: int) -> dict[str, Any]:
    """Return a test as it stands in the Hjson file."""
    return {
        "name": name,
        "uvm_test": run.test,
        "build_mode": run.config,
        "run_opts": list(run.options),
        "reseed": seeds,
    }


def _item(raw: Mapping[str, Any], content: Mapping[str, Any]) -> Item:
    name, config, seeds = raw["name"], raw["build_mode"], raw.get("reseed", content.get("reseed", 1))
    if config not in {mode["name"] for mode in content["build_modes"]}:
        raise ValueError(f"test {name}: no build mode {config}")
    _check_seeds(f"test {name}", seeds)
    model_of(config)
    options = {"--judged": "1", "--agent": BURST} | dict(option.split() for option in raw["run_opts"])
    if options.keys() != {"--pairs", "--judged", "--agent"} or options["--agent"] not in (PIN, BURST):
        wanted = f"must be --pairs N, --judged N, --agent {PIN} or {BURST}"
        raise ValueError(f"test {name}: run_opts {raw['run_opts']}: {wanted}")
    pairs, judged = int(options["--pairs"]), int(options["--judged"])
    if pairs < 1 or judged < 1:
        raise ValueError(f"test {name}: run_opts: --pairs and --judged must be at least 1")
    return Item(PlannedRun(name, raw["uvm_test"], config, 0, pairs, options["--agent"], judged), seeds)


def _check_seeds(what: str, seeds: Any) -> None:
    if not isinstance(seeds, int) or seeds < 1:
        raise ValueError(f"{what}: reseed {seeds}: must be at least 1")


def _regression(raw: Mapping[str, Any], goal: Mapping[str, Any], items: Mapping[str, Item]) -> Regression:
    name, wanted = raw["name"], set(raw["tests"])
    if not wanted:
        raise ValueError(f"regression {name}: it has no tests")
    if missing := wanted - items.keys():
        raise ValueError(f"regression {name}: no test {', '.join(sorted(missing))}")
    if "reseed" in raw:
        _check_seeds(f"regression {name}", raw["reseed"])
    ordered = tuple(item for item in items if item in wanted)
    return Regression(
        name, ordered, raw.get("reseed"), int(goal.get("pairs", 0)), bool(goal.get("coverage", False)),
        frozenset(goal.get("uncovered", ())),
    )  # fmt: skip


def write_view(path: Path, items: Sequence[Item]) -> None:
    """Write the testplan as dvsim wants it: the tests of a testpoint by their names in the regressions."""
    try:
        content = hjson.loads(read_input(TESTPLAN).decode())
        points = [_testpoint(point, items) for point in content["testpoints"]]
    except (hjson.HjsonDecodeError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{TESTPLAN}: not a testplan: {error!r}") from error
    write_whole(path, json.dumps({"name": "triaxis", "testpoints": points}, indent=1) + "\n")


def _testpoint(point: Mapping[str, Any], items: Sequence[Item]) -> dict[str, Any]:
    wanted = set(point.get("tests", []))
    names = [item.run.item for item in items if item.run.test in wanted]
    return {**{key: point[key] for key in ("name", "desc", "stage")}, "tests": names or [NOT_SIMULATED]}


def in_checkout(path: Path) -> str:
    """Return a path as it is best shown: relative where it lies in the checkout."""
    return str(path.relative_to(ROOT)) if path.is_relative_to(ROOT) else str(path)
