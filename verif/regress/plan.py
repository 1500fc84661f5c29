"""Which runs a regression consists of, each with its seed."""

import hashlib

from triaxis.verif.regress.definition import Definition
from triaxis.verif.regress.planned_run import PlannedRun

# Seeds go through SystemVerilog's int.
_SEEDS = 1 << 31


def seed_of(base: int, item: str, number: int) -> int:
    """Return the seed of a run: it follows from the regression's, and no two runs share their stimulus."""
    digest = hashlib.sha256(f"{base} {item} {number}".encode()).digest()
    return int.from_bytes(digest[:8], "big") % _SEEDS


def plan(definition: Definition, name: str, base: int, multiplier: float = 1.0) -> list[PlannedRun]:
    """Return all runs of a regression; ``multiplier`` scales the seeds of each test, at least one is left."""
    regression = definition.regression(name)
    runs: list[PlannedRun] = []
    for item in (definition.items[one] for one in regression.items):
        seeds = max(1, round((regression.seeds or item.seeds) * multiplier))
        runs += [
            PlannedRun(
                item.name,
                item.test,
                item.config,
                seed_of(base, item.name, number),
                item.pairs,
                item.agent,
                item.judged_one_in,
            )
            for number in range(seeds)
        ]
    return runs
