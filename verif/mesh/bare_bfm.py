"""The bus-functional model of the bare engine: whole meshes and runs in, what was seen of them out."""

from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np

from triaxis.sim.mesh_engine import MeshEngine, Traffic
from triaxis.verif.core.items import Pace
from triaxis.verif.mesh.items import LoadItem, RunItem
from triaxis.verif.mesh.observed import AbortAsked, CorePairs, Loaded, NearTaken, RunAccepted, Summary

LOAD, RUN, NEAR, CORE, SUMMARY = "load", "run", "near", "core", "summary"


class BareBfm:
    """The one that knows the library; drivers hand it items, monitors say who is told of what."""

    def __init__(self, engine: MeshEngine) -> None:
        """Take the engine; nobody is told of anything yet."""
        self.engine = engine
        self.publish: dict[str, Callable[[Any], None]] = {}
        self._held = [0, 0]

    def load(self, item: LoadItem, random: Random) -> None:
        """Load a mesh."""
        if not item.clear:
            raise ValueError("the bare engine empties a mesh before it loads it")
        held = self.engine.load_unchecked(item.mesh, item.triangles, _traffic(random, (item.gaps,)))
        self._held[item.mesh] = held
        self.publish[LOAD](Loaded(item.mesh, True, item.triangles.astype(np.int64)))

    def run(self, item: RunItem, random: Random) -> None:
        """Run; aborted once at most."""
        request, traffic = item.request, item.traffic
        abort = traffic.aborts[0] if traffic.aborts else -1
        self.publish[RUN](RunAccepted(request))
        stalls = _traffic(random, (traffic.near, traffic.done), abort)
        run = self.engine.run(request.translation, request.margin, request.mode, stalls, reached=True)
        item.clocks = run.cycles
        # Later ones never came: the summary was taken before.
        came = abort < run.cycles or run.cycles == self.engine.configuration.max_cycles
        if traffic.aborts and came:
            self.publish[RUN](AbortAsked(abort))
        assert run.reached is not None
        self.publish[CORE](CorePairs(run.reached))
        self.publish[NEAR](NearTaken(run.near))
        self.publish[SUMMARY](
            Summary(
                run.status,
                run.cycles,
                run.group_pairs_skipped,
                run.group_pairs_opened,
                run.pairs_skipped,
                run.tested,
                run.near_count,
                held=(self._held[0], self._held[1]),
            )
        )


def _traffic(random: Random, paces: tuple[Pace, ...], abort_at: int = -1) -> Traffic:
    """Return stalls that come as often as at the slowest of some paces."""
    off = 1 - min(pace.duty for pace in paces)
    return Traffic(random.randrange(1, 1 << 60), min(250, int(256 * off)), abort_at)
