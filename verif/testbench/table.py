"""The table of the tests: each test says at its class what it runs, where and how often.

The sign-off's plan, the regressions and the lists of names are made of it; the testplan is checked against
it. So a new test is its class, its sequence, and the testpoint that it verifies.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib import import_module
from typing import TypeVar

from triaxis.golden.errors import InputError
from triaxis.verif.testbench.settings import (
    BOARD_TESTS,
    BURST,
    CORE_TESTS,
    MESH_TESTS,
    PIN,
    REPLAY,
    Block,
    block_of,
)

# Pairs of one volume run at most: what fails is replayed by running it again from its start.
_LONGEST_RUN = 8_000_000

Test = TypeVar("Test", bound=type)


@dataclass(frozen=True)
class Runs:
    """Runs of a test that differ only in configuration and seed: each checks so many pairs.

    ``judged``: the golden model judges one pair in so many, and the first of each new kind; 1: all.
    ``seeds``: how many the nightly regression runs in each configuration, 0: none. ``smoke``: the
    configurations in which the short regression runs one of them. ``signoff``: the sign-off runs one in each.
    ``label``: tells runs of one test, configuration and agent apart.
    """

    configs: tuple[str, ...]
    pairs: int
    judged: int = 1
    agent: str = BURST
    seeds: int = 1
    smoke: tuple[str, ...] = ()
    signoff: bool = True
    label: str = ""

    def name(self, test: str, config: str) -> str:
        """Return the name of these runs of a test in a configuration."""
        return "_".join(filter(None, (test, config, PIN if self.agent == PIN else "", self.label)))


@dataclass(frozen=True)
class Entry:
    """A test of the table.

    ``stage``: the first stage of the testplan that asks for it; ``why_seeds``: why so many. ``volume``: the
    share of the volume in each configuration, in percent.
    """

    name: str
    purpose: str
    stage: str
    runs: tuple[Runs, ...] = ()
    why_seeds: str = ""
    volume: Mapping[str, float] = field(default_factory=dict)

    @property
    def block(self) -> Block:
        """Return what it is a test of."""
        return next((block_of(config) for runs in self.runs for config in runs.configs), Block.CORE)

    def volume_runs(self, pairs: int, judged: int) -> Iterator[Runs]:
        """Yield runs of that many pairs in all: to each configuration its share, in moderate pieces."""
        for config, share in self.volume.items():
            # Rounded up, so that no pair is lost.
            own = -(-pairs * round(100 * share) // 10_000)
            count = -(-own // _LONGEST_RUN)
            yield Runs((config,), -(-own // count), judged, seeds=count)


def listed(
    stage: str, *runs: Runs, why_seeds: str = "", volume: Mapping[str, float] | None = None
) -> Callable[[Test], Test]:
    """Put a test into the table; its purpose is the first line of its docstring. See `Entry`."""

    def enter(test: Test) -> Test:
        purpose = (test.__doc__ or "").partition("\n")[0]
        if not purpose or (runs and not why_seeds):
            raise ValueError(f"{test.__name__}: says not what it is for, or not why so many seeds")
        # An attribute of the class itself: its heirs are no entries of the table.
        test.entry = Entry(test.__name__, purpose, stage, runs, why_seeds, volume or {})
        return test

    return enter


@cache
def table() -> Mapping[str, Entry]:
    """Return all tests by name, as they stand: those of the core, of the mesh engine, of the board."""
    modules = (*CORE_TESTS, *MESH_TESTS, *BOARD_TESTS)
    classes = [one for module in modules for one in vars(import_module(module)).values()]
    entries = [vars(one)["entry"] for one in classes if isinstance(one, type) and "entry" in vars(one)]
    return {entry.name: entry for entry in entries}


def names_of(block: Block) -> list[str]:
    """Return the names of the tests of a block."""
    return [entry.name for entry in table().values() if entry.block is block]


def planned_tests() -> list[str]:
    """Return the names of all tests but the replay."""
    return [name for name in table() if name != REPLAY]


def configurations() -> list[str]:
    """Return the names of all configurations that a test runs in, in the order of the table."""
    return list(
        dict.fromkeys(
            config
            for entry in table().values()
            for configs in (*(runs.configs for runs in entry.runs), tuple(entry.volume))
            for config in configs
        )
    )


def check_test_name(name: str) -> None:
    """Raise InputError unless there is such a test."""
    if name not in table():
        raise InputError(f"test {name}: unknown; one of: {', '.join(table())}")


def check_test_fits(name: str, config: str) -> None:
    """Raise InputError unless the test is one of what the configuration's name says is under test."""
    block = table()[name].block
    if block is not block_of(config):
        wanted = {
            Block.CORE: "w16_m0",
            Block.MESH: "mesh_w16_m16_d64_g8_l8",
            Block.BOARD: "board_w12_m5_d128_g8_l4",
        }[block]
        raise InputError(f"test {name}: needs another --config than {config}, such as {wanted}")
