"""The tests by name. Each says what it sends; the environment checks everything everywhere."""

from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles

from triaxis.verif.agents.items import Pace
from triaxis.verif.failing_pairs import read_failing_pairs
from triaxis.verif.scenes import mesh_pairs
from triaxis.verif.sequences import families
from triaxis.verif.sequences.pair_sequence import ArraySequence, FamilySequence
from triaxis.verif.sequences.seed_vectors import seed_vectors
from triaxis.verif.testlist.base_test import CoreTest


class FamilyTest(CoreTest):
    """Sends one family of pairs at full speed."""

    family: families.Family

    async def stimulus(self) -> None:
        """Send the family."""
        await self.send(FamilySequence(type(self).family, self.settings, self.rng, self.settings.pairs))


class RandomTest(FamilyTest):
    """General pairs at all scales."""

    family = families.random_pairs


class DegenerateTest(FamilyTest):
    """Every combination of point, segment and triangle."""

    family = families.degenerate_pairs


class CoplanarTest(FamilyTest):
    """Pairs in one plane, axis-aligned and tilted."""

    family = families.coplanar_pairs


class ExtremesTest(FamilyTest):
    """Coordinates at the limits of the range."""

    family = families.extreme_pairs


class TouchingTest(FamilyTest):
    """Shared vertices, edges and points, and misses by one step."""

    family = families.touching_pairs


class TinyTest(FamilyTest):
    """Coordinates of a few steps: coincidences of every kind."""

    family = families.tiny_pairs


class FarTest(FamilyTest):
    """Pairs that their boxes decide, which the operand gate must pass over."""

    family = families.far_pairs


class SeedVectorsTest(CoreTest):
    """The fifteen vectors of the replaced design: all are clear."""

    async def stimulus(self) -> None:
        """Send them at margin 0."""
        pairs = seed_vectors(self.settings.configuration.width)
        await self.send(ArraySequence(pairs, np.zeros(len(pairs), np.int64)))


class OrdersTest(CoreTest):
    """All 72 orders of each pair."""

    async def stimulus(self) -> None:
        """Send whole sets of orders, each set at one margin."""
        configuration = self.settings.configuration
        count = max(1, self.settings.pairs // 72)
        pairs = families.mixed_pairs(self.rng, count, configuration.width)
        margins = families.random_margins(self.rng, pairs, configuration.max_margin)
        await self.send(ArraySequence(families.all_orders(pairs), np.repeat(margins, 72)))


class MeshTest(CoreTest):
    """Facet pairs of real solids that come close: tool holder and end mill, vise and workpiece."""

    async def stimulus(self) -> None:
        """Send facet pairs, the near ones first, at random margins."""
        configuration = self.settings.configuration
        pairs = mesh_pairs(self.rng, self.settings.pairs, configuration.width)
        margins = families.random_margins(self.rng, pairs, configuration.max_margin)
        await self.send(ArraySequence(pairs, margins))


class StallsTest(CoreTest):
    """Gaps in the input and back-pressure on the output, in all mixtures of pace."""

    paces = (Pace(1, 0), Pace(1, 1), Pace(1, 12), Pace(8, 3), Pace(40, 40), Pace(3, 60))

    async def stimulus(self) -> None:
        """Send mixed pairs at every pair of paces."""
        count = max(1, self.settings.pairs // len(self.paces) ** 2)
        for ready in self.paces:
            self.env.sink.ready.pace = ready
            for valid in self.paces:
                await self.send(FamilySequence(families.mixed_pairs, self.settings, self.rng, count, valid))


class ResetsTest(CoreTest):
    """Resets at any moment, with pairs in flight and results waiting."""

    async def stimulus(self) -> None:
        """Send mixed pairs while resets strike; end with undisturbed traffic."""
        self.env.sink.ready.pace = Pace(6, 6)
        traffic = cocotb.start_soon(
            self.send(
                FamilySequence(families.mixed_pairs, self.settings, self.rng, self.settings.pairs, Pace(9, 4))
            )
        )
        while not traffic.done():
            await ClockCycles(self.dut.clk_i, int(self.rng.integers(1, 200)))
            if not traffic.done():
                await self.reset(int(self.rng.integers(1, 4)))
        await self.send(FamilySequence(families.mixed_pairs, self.settings, self.rng, 64))


class ReplayTest(CoreTest):
    """Pairs that failed before, from the file that the scoreboard wrote."""

    async def stimulus(self) -> None:
        """Send the pairs in the file."""
        pairs, margins = read_failing_pairs(Path(self.settings.replay), self.settings.configuration)
        await self.send(ArraySequence(pairs, margins))
