"""Tests whose monitors lie: they must fail, which shows that the scoreboard's checks can."""

from dataclasses import replace
from itertools import cycle
from typing import Any

import numpy as np

from triaxis.verif.mesh.burst_agents import (
    BurstCoreMonitor,
    BurstLoadMonitor,
    BurstNearMonitor,
    BurstSummaryMonitor,
)
from triaxis.verif.mesh.items import CorePairs, Loaded, NearTaken, Summary
from triaxis.verif.mesh.scenes import random_scene
from triaxis.verif.mesh.uvm_tests import MeshVolumeTest
from triaxis.verif.testbench.sabotage import Lie, lie_about

# Which transactions of some kind are falsified: a few in the middle of a test.
_FALSE = range(20, 40)
_COUNTERS = cycle(("group_pairs_opened", "pairs_skipped", "tested", "near", "group_pairs_skipped"))


class _SabotagedTest(MeshVolumeTest):
    """Sends small scenes to a scoreboard that is lied to."""

    honest: type
    falsify: Lie

    def build_phase(self) -> None:
        """Put the liar in the place of the honest monitor."""
        super().build_phase()
        lie_about(self.honest, type(self).falsify, _FALSE)


class MeshNearLostTest(_SabotagedTest):
    """The last of some near pairs is lost on its way to the scoreboard."""

    honest, falsify = BurstNearMonitor, staticmethod(lambda near: [NearTaken(near.pairs[:-1])])


class MeshNearTwiceTest(_SabotagedTest):
    """A near pair reaches the scoreboard twice."""

    honest = BurstNearMonitor
    falsify = staticmethod(lambda near: [NearTaken(np.concatenate([near.pairs, near.pairs[-1:]]))])


class MeshNearOrderTest(_SabotagedTest):
    """Near pairs reach the scoreboard the other way round."""

    honest, falsify = BurstNearMonitor, staticmethod(lambda near: [NearTaken(near.pairs[::-1])])


class MeshUntestedTest(_SabotagedTest):
    """A pair does not reach the core, and nothing proves it clear."""

    honest, falsify = BurstCoreMonitor, staticmethod(lambda seen: [CorePairs(seen.pairs[:-1])])


class MeshOtherMeshTest(_SabotagedTest):
    """The scoreboard is told of another mesh than the engine was given: a point is its last triangle."""

    honest = BurstLoadMonitor

    @staticmethod
    def falsify(datum: Loaded) -> list[Any]:
        """Replace the triangle."""
        triangles = datum.triangles.copy()
        triangles[-1:] = 0
        return [replace(datum, triangles=triangles)]


class MeshLoadLostTest(_SabotagedTest):
    """The scoreboard is not told of a mesh."""

    honest, falsify = BurstLoadMonitor, staticmethod(lambda _: [])


class MeshSummaryLostTest(_SabotagedTest):
    """A summary is lost on its way to the scoreboard."""

    honest, falsify = BurstSummaryMonitor, staticmethod(lambda _: [])


class MeshSummaryTwiceTest(_SabotagedTest):
    """A summary reaches the scoreboard twice."""

    honest, falsify = BurstSummaryMonitor, staticmethod(lambda summary: [summary, summary])


class MeshStatusTest(_SabotagedTest):
    """A summary claims another status: the next one."""

    honest = BurstSummaryMonitor
    falsify = staticmethod(lambda summary: [replace(summary, status=summary.status % 6 + 1)])


class MeshAccountTest(_SabotagedTest):
    """The counters of a summary are each wrong by one, in turn."""

    honest = BurstSummaryMonitor

    @staticmethod
    def falsify(datum: Summary) -> list[Any]:
        """Add one to a counter."""
        name = next(_COUNTERS)
        return [replace(datum, **{name: getattr(datum, name) + 1})]


class MeshNothingTest(MeshVolumeTest):
    """Nothing is sent, so nothing is checked."""

    async def stimulus(self) -> None:
        """Send nothing."""


class MeshOnlyEmptyTest(MeshVolumeTest):
    """Runs are checked, but none with a pair."""

    async def stimulus(self) -> None:
        """Send scenes in which A is empty."""
        for _ in range(10):
            await self.send(random_scene(self.shapes, True, (0, 3)))
