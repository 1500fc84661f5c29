"""Which tests a sign-off runs, in which configurations, on how many pairs; where its results are."""

from collections.abc import Iterator

from triaxis.sim.paths import BUILD
from triaxis.verif.testbench.settings import BURST, PIN, Block, RunSettings
from triaxis.verif.testbench.simulation import run_settings
from triaxis.verif.testbench.table import Entry, Runs, configurations, table

FOLDER = BUILD / "signoff"
RESULT = FOLDER / "signoff.json"
PAGE = FOLDER / "index.html"

# Pairs of the volume runs in all.
VOLUME = 100_000_000
# The share that the golden model judges in volume runs, beside pairs of new kinds.
_VOLUME_JUDGED = 1 << 16


def plan(seed: int, volume: int = VOLUME) -> list[RunSettings]:
    """Return every run of the sign-off, what fails soonest first; ``volume``: pairs of the volume runs."""
    core, engine, board = (
        [entry for entry in table().values() if entry.block is block]
        for block in (Block.CORE, Block.MESH, Block.BOARD)
    )
    runs = list(_directed(board, BURST, seed))
    runs += [run for agent in (PIN, BURST) for run in _directed(engine, agent, seed)]
    runs += [run for agent in (BURST, PIN) for run in _directed(core, agent, seed)]
    for entry in core:
        for share in entry.volume_runs(volume, _VOLUME_JUDGED):
            seeds = range(1000 * seed, 1000 * seed + share.seeds)
            runs += [_settings(entry, share, config, one) for config in share.configs for one in seeds]
    return runs


def _directed(entries: list[Entry], agent: str, seed: int) -> Iterator[RunSettings]:
    """Yield the runs of an agent, one configuration after the other."""
    for config in configurations():
        for entry in entries:
            for runs in entry.runs:
                if runs.signoff and runs.agent == agent and config in runs.configs:
                    yield _settings(entry, runs, config, seed)


def _settings(entry: Entry, runs: Runs, config: str, seed: int) -> RunSettings:
    """Return a run in a folder of the sign-off's own, so that no other run disturbs it."""
    folder = FOLDER / "runs" / f"{entry.name}-{config}-{runs.agent}-{seed}"
    return run_settings(
        entry.name, config, seed, runs.pairs, folder=folder, agent=runs.agent, judged_one_in=runs.judged
    )
