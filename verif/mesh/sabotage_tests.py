"""Tests whose monitors lie: they must fail, which shows that the scoreboard's checks can."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from pyuvm import uvm_analysis_port, uvm_component, uvm_factory

from triaxis.verif.mesh.bare_agents import (
    BareCoreMonitor,
    BareLoadMonitor,
    BareNearMonitor,
    BareSummaryMonitor,
)
from triaxis.verif.mesh.observed import CorePairs, Loaded, NearTaken, Summary
from triaxis.verif.mesh.random_scenes import random_scene
from triaxis.verif.mesh.uvm_tests import MeshVolumeTest

# Which transactions of some kind are falsified: a few in the middle of a test.
_FALSE = range(20, 40)


class Liar(uvm_component):
    """Publishes what `falsify` makes of some transactions."""

    ap: uvm_analysis_port
    falsify: Callable[[Any], list[Any]]

    def build_phase(self) -> None:
        """Put the lie in front of the analysis port."""
        super().build_phase()
        publish, self.seen = self.ap.write, 0

        def write(datum: Any) -> None:
            self.seen += 1
            for told in type(self).falsify(datum) if self.seen in _FALSE else [datum]:
                publish(told)

        self.ap.write = write


def _without_last(pairs: np.ndarray) -> np.ndarray:
    return pairs[:-1]


def _with_last_twice(pairs: np.ndarray) -> np.ndarray:
    return np.concatenate([pairs, pairs[-1:]])


def _turned_round(pairs: np.ndarray) -> np.ndarray:
    return pairs[::-1]


def _lie(monitor: type, falsify: Callable[[Any], list[Any]]) -> type:
    """Return a monitor that lies."""
    return type(f"Lying{monitor.__name__}", (Liar, monitor), {"falsify": staticmethod(falsify)})


class _SabotagedTest(MeshVolumeTest):
    """Sends small scenes to a scoreboard that is lied to."""

    honest: type
    falsify: Callable[[Any], list[Any]]

    def build_phase(self) -> None:
        """Put the liar in the place of the honest monitor."""
        super().build_phase()
        uvm_factory().set_type_override_by_type(self.honest, _lie(self.honest, type(self).falsify))


class MeshNearLostTest(_SabotagedTest):
    """A near pair is lost on its way to the scoreboard."""

    honest = BareNearMonitor

    @staticmethod
    def falsify(datum: NearTaken) -> list[Any]:
        """Leave the last one out."""
        return [NearTaken(_without_last(datum.pairs))]


class MeshNearTwiceTest(_SabotagedTest):
    """A near pair reaches the scoreboard twice."""

    honest = BareNearMonitor

    @staticmethod
    def falsify(datum: NearTaken) -> list[Any]:
        """Repeat the last one."""
        return [NearTaken(_with_last_twice(datum.pairs))]


class MeshNearOrderTest(_SabotagedTest):
    """Near pairs reach the scoreboard in another order."""

    honest = BareNearMonitor

    @staticmethod
    def falsify(datum: NearTaken) -> list[Any]:
        """Turn them round."""
        return [NearTaken(_turned_round(datum.pairs))]


class MeshUntestedTest(_SabotagedTest):
    """A pair does not reach the core, and nothing proves it clear."""

    honest = BareCoreMonitor

    @staticmethod
    def falsify(datum: CorePairs) -> list[Any]:
        """Leave the last one out."""
        return [CorePairs(_without_last(datum.pairs))]


class MeshOtherMeshTest(_SabotagedTest):
    """The scoreboard is told of another mesh than the engine was given."""

    honest = BareLoadMonitor

    @staticmethod
    def falsify(datum: Loaded) -> list[Any]:
        """Put a point in the place of the last triangle."""
        triangles = datum.triangles.copy()
        triangles[-1:] = 0
        return [replace(datum, triangles=triangles)]


class MeshLoadLostTest(_SabotagedTest):
    """The scoreboard is not told of a mesh."""

    honest = BareLoadMonitor

    @staticmethod
    def falsify(datum: Loaded) -> list[Any]:
        """Say nothing."""
        return []


class MeshSummaryLostTest(_SabotagedTest):
    """A summary is lost on its way to the scoreboard."""

    honest = BareSummaryMonitor

    @staticmethod
    def falsify(datum: Summary) -> list[Any]:
        """Say nothing."""
        return []


class MeshSummaryTwiceTest(_SabotagedTest):
    """A summary reaches the scoreboard twice."""

    honest = BareSummaryMonitor

    @staticmethod
    def falsify(datum: Summary) -> list[Any]:
        """Repeat it."""
        return [datum, datum]


class MeshStatusTest(_SabotagedTest):
    """A summary claims another status."""

    honest = BareSummaryMonitor

    @staticmethod
    def falsify(datum: Summary) -> list[Any]:
        """Take the next one."""
        return [replace(datum, status=datum.status % 6 + 1)]


class MeshAccountTest(_SabotagedTest):
    """The counters of a summary are each wrong by one, in turn."""

    honest = BareSummaryMonitor
    number = 0

    @staticmethod
    def falsify(datum: Summary) -> list[Any]:
        """Add one to a counter."""
        names = ("group_pairs_skipped", "group_pairs_opened", "pairs_skipped", "tested", "near")
        MeshAccountTest.number += 1
        name = names[MeshAccountTest.number % len(names)]
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
