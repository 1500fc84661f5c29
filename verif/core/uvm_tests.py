"""The tests by name. Each says what it sends; the environment checks everything everywhere."""

from pathlib import Path

import cocotb
import numpy as np

from triaxis.host.scenes import mesh_pairs
from triaxis.sim.clocking import PERIOD_NS
from triaxis.verif.core.base_test import CoreTest
from triaxis.verif.core.failing_pairs import read_failing_pairs
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace
from triaxis.verif.core.kept_cases import load_regressions
from triaxis.verif.core.metamorphic import GROUPS, MetamorphicCheck
from triaxis.verif.core.sequences import (
    ArraySequence,
    StimulusSequence,
    item_pairs,
    of_families,
)
from triaxis.verif.core.stimulus.families import (
    FAMILIES,
    TOUCHING,
    mixed,
    mixture,
)
from triaxis.verif.core.stimulus.margins import at_any_margin
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors
from triaxis.verif.core.stimulus.stimulus import Stimulus
from triaxis.verif.core.stimulus.symmetry import all_orders


class FamilyTest(CoreTest):
    """Sends families of pairs, by name, at full speed and in equal shares."""

    families: tuple[str, ...]

    async def stimulus(self) -> None:
        """Send the families."""
        make = of_families([FAMILIES[name] for name in self.families], self.settings, self.rng)
        await self.send(StimulusSequence(make, self.settings, self.settings.pairs))


class RandomTest(FamilyTest):
    """General pairs at all scales, some that share vertices."""

    families = ("random", "shared")


class DegenerateTest(FamilyTest):
    """Every combination of point, segment and triangle."""

    families = ("degenerate",)


class CoplanarTest(FamilyTest):
    """Pairs in one plane, axis-aligned and tilted, and those that nearly are; one in the other."""

    families = ("coplanar", "coplanar near-miss", "contained")


class PenetratingTest(FamilyTest):
    """Edges through faces."""

    families = ("penetrating",)


class SliversTest(FamilyTest):
    """Triangles as thin as the width allows."""

    families = ("slivers",)


class TouchingTest(FamilyTest):
    """Contact of every pair of features, and misses by one step."""

    families = tuple(f"touching {name}" for name in TOUCHING)


class NearMissTest(FamilyTest):
    """Lattice near-misses of every kind of axis: the hardest decisions (docs/theory.md, section 7)."""

    families = tuple(name for name in FAMILIES if name.startswith("near-miss"))


class ExtremesTest(FamilyTest):
    """Coordinates at the limits of the range; corners at which projections are largest."""

    families = ("extremes", "corners")


class TinyTest(FamilyTest):
    """Coordinates of a few steps: coincidences of every kind."""

    families = ("tiny",)


class FarTest(FamilyTest):
    """Pairs that their boxes decide, which the operand gate must pass over."""

    families = ("far",)


class MixedTest(FamilyTest):
    """All families."""

    families = tuple(FAMILIES)


class VolumeTest(CoreTest):
    """The mixture of all families, without end; now and then with gaps and stalls."""

    # Of so many items one comes in small pieces, at every pair of these paces in turn.
    paced_every = 64
    paces = (FULL_SPEED, Pace(1, 1), Pace(1, 12), Pace(8, 3), Pace(40, 40))
    piece = 150

    async def stimulus(self) -> None:
        """Send the mixture."""
        configuration = self.settings.configuration
        make = mixture(self.rng, configuration.width, configuration.max_margin).burst
        step = item_pairs(self.settings)
        whole = self.paced_every * step
        for start in range(0, self.settings.pairs, whole):
            count = min(whole, self.settings.pairs - start)
            await self.send(StimulusSequence(make, self.settings, count))
            await self.send_paced(make(len(self.paces) ** 2 * self.piece))

    async def send_paced(self, stimulus: Stimulus) -> None:
        """Send pieces, one at each combination of paces."""
        combinations = [(gaps, stalls) for gaps in self.paces for stalls in self.paces]
        for number, (gaps, stalls) in enumerate(combinations):
            part = stimulus[slice(number * self.piece, (number + 1) * self.piece)]
            await self.send_item(BurstItem(part.pairs, part.margins, gaps, stalls))
        self.set_stalls(FULL_SPEED)


class SeedVectorsTest(CoreTest):
    """The fifteen vectors of the replaced design: all are clear."""

    async def stimulus(self) -> None:
        """Send them at margin 0."""
        pairs = seed_vectors(self.settings.configuration.width)
        await self.send(ArraySequence(self.settings, pairs, np.zeros(len(pairs), np.int64)))


class OrdersTest(CoreTest):
    """All 72 orders of each pair."""

    async def stimulus(self) -> None:
        """Send whole sets of orders, each set at one margin."""
        configuration = self.settings.configuration
        count = max(1, self.settings.pairs // 72)
        base = mixed(self.rng, count, configuration.width, configuration.max_margin)
        await self.send(ArraySequence(self.settings, all_orders(base.pairs), np.repeat(base.margins, 72)))


class MetamorphicTest(CoreTest):
    """Orders, symmetries of the cube and translations of pairs, which must be answered alike.

    This check needs no golden model: it is made of the core's answers alone.
    """

    def build_phase(self) -> None:
        """Add the check to the environment."""
        super().build_phase()
        self.check = MetamorphicCheck("metamorphic_check", self)

    def connect_phase(self) -> None:
        """Let it see the answers."""
        self.env.scoreboard.checked_port.connect(self.check.analysis_export)

    async def stimulus(self) -> None:
        """Send groups of variants, one kind of group after the other."""
        configuration = self.settings.configuration
        supply = mixture(self.rng, configuration.width, configuration.max_margin)
        for group in GROUPS:
            left = max(1, self.settings.pairs // (len(GROUPS) * group.size))
            while left:
                bases = min(left, max(1, item_pairs(self.settings) // group.size))
                base = supply.burst(bases)
                pairs = group.make(self.rng, base.pairs, configuration.width)
                self.check.expect(group, bases)
                await self.send(ArraySequence(self.settings, pairs, np.repeat(base.margins, group.size)))
                left -= bases


class MeshTest(CoreTest):
    """Facet pairs of real solids that come close: tool holder and end mill, vise and workpiece."""

    async def stimulus(self) -> None:
        """Send facet pairs, the near ones first, at margins of every kind."""
        configuration = self.settings.configuration
        pairs = mesh_pairs(self.rng, self.settings.pairs, configuration.width)
        margins = at_any_margin(self.rng, pairs, configuration.max_margin)
        await self.send(ArraySequence(self.settings, pairs, margins))


class StallsTest(CoreTest):
    """Gaps in the input and back-pressure on the output, in all mixtures of pace."""

    paces = (FULL_SPEED, Pace(1, 1), Pace(1, 12), Pace(8, 3), Pace(40, 40), Pace(3, 60))

    async def stimulus(self) -> None:
        """Send mixed pairs at every pair of paces."""
        count = max(1, self.settings.pairs // len(self.paces) ** 2)
        configuration = self.settings.configuration
        for stalls in self.paces:
            for gaps in self.paces:
                made = mixed(self.rng, count, configuration.width, configuration.max_margin)
                await self.send_item(BurstItem(made.pairs, made.margins, gaps, stalls))


class ResetsTest(CoreTest):
    """Resets at any moment, with pairs in flight and results waiting."""

    async def stimulus(self) -> None:
        """Send mixed pairs while resets strike; end with undisturbed traffic."""
        self.set_stalls(Pace(6, 6))
        # The traffic draws in a thread of its own.
        moments = np.random.default_rng([self.settings.seed, *b"resets"])
        make = of_families([mixed], self.settings, self.rng)
        traffic = cocotb.start_soon(
            self.send(StimulusSequence(make, self.settings, self.settings.pairs, Pace(9, 4)))
        )
        while not traffic.done():
            await self.clocks(int(moments.integers(1, 200)))
            if not traffic.done():
                cycles = int(moments.choice([1, 2, 3, 30]))
                await self.reset(cycles, int(moments.integers(0, PERIOD_NS - 1)))
        await self.send(StimulusSequence(make, self.settings, 64))


class RegressionsTest(CoreTest):
    """Counterexamples that were found before and kept: see verif/core/kept/."""

    async def stimulus(self) -> None:
        """Send those that fit the configuration."""
        pairs, margins = load_regressions(self.settings.configuration)
        await self.send(ArraySequence(self.settings, pairs, margins))


class ReplayTest(CoreTest):
    """Pairs that failed before, from the file that the scoreboard wrote."""

    async def stimulus(self) -> None:
        """Send the pairs in the file."""
        pairs, margins = read_failing_pairs(Path(self.settings.replay), self.settings.configuration)
        await self.send(ArraySequence(self.settings, pairs, margins))
