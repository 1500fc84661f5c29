"""The tests by name. Each says what it sends; the environment checks everything everywhere."""

from pathlib import Path

import cocotb
import numpy as np

from triaxis.sim.player import PERIOD_NS
from triaxis.verif.core.base_test import CoreTest
from triaxis.verif.core.failing_pairs import read_failing
from triaxis.verif.core.items import FULL_SPEED, BurstItem, Pace
from triaxis.verif.core.kept_cases import FOUND, REGRESSIONS, load_regressions
from triaxis.verif.core.metamorphic import GROUPS, MetamorphicCheck
from triaxis.verif.core.sequences import (
    ArraySequence,
    AttemptsSequence,
    StimulusSequence,
    item_pairs,
    of_families,
)
from triaxis.verif.core.stimulus.families import FAMILIES, TOUCHING, mixed, mixture
from triaxis.verif.core.stimulus.seed_vectors import seed_vectors
from triaxis.verif.core.stimulus.stimulus import Stimulus
from triaxis.verif.core.stimulus.symmetry import all_orders
from triaxis.verif.testbench.failures import ends_at_first
from triaxis.verif.testbench.settings import PIN
from triaxis.verif.testbench.table import Runs, listed

# The builds that differ in what they elaborate, the fastest to simulate first.
BUILDS = (
    "w16_m0",
    "w8_m8",
    "w16_m16",
    "w13_m4_t1",
    "w16_m0_no_edge_box",
    "w16_m0_ungated",
    "w24_m24",
    "w32_m32",
    "w8_m8_certified",
    "w16_m16_certified",
)
CERTIFIED = ("w8_m8_certified", "w16_m16_certified")
USUAL = ("w16_m0", "w16_m16", "w24_m24", "w32_m32")
# The protocol again, pin by pin, independent of the bus-functional model; everything judged.
_ON_PINS = ("w16_m0", "w13_m4_t1")
# Each family by itself, so that a failure says what it is about; volume sends them all to every build.
_FAMILY = (Runs(("w16_m0", "w16_m16"), 20_000, 10, seeds=3, smoke=("w16_m0",)),)
_FAMILY_SEEDS = (
    "Three: in w16_m0 the second hits 2 to 6 % more coverage bins than the first alone, the third another "
    "1 to 3 %, the fourth no more than that."
)
# Stalls and resets at each depth of the pipeline.
_PROTOCOL = (
    Runs(("w16_m0", "w16_m16", "w13_m4_t1", "w32_m32"), 10_000, 1000, seeds=3, smoke=("w16_m0",)),
    Runs(_ON_PINS, 1000, agent=PIN, seeds=3, smoke=("w16_m0",)),
)
_PROTOCOL_SEEDS = (
    "Three: each draws other stalls and places of resets; the second hits 5 to 8 % more bins, the third 4 %."
)


@listed("V3", Runs(BUILDS, 1, smoke=BUILDS), why_seeds="One: they are the same cases with every seed.")
class RegressionsTest(CoreTest):
    """Counterexamples that were found before and kept: those in verif/core/kept/ and in build/kept/."""

    async def stimulus(self) -> None:
        """Send those that fit the configuration."""
        # What a checkout has found for itself must not decide what becomes of a mutant.
        places = (REGRESSIONS,) if ends_at_first() else (REGRESSIONS, FOUND)
        pairs, margins = load_regressions(self.settings.configuration, *places)
        await self.send(ArraySequence(self.settings, pairs, margins))


class FamilyTest(CoreTest):
    """Sends families of pairs, by name, at full speed and in equal shares."""

    families: tuple[str, ...]

    async def stimulus(self) -> None:
        """Send the families."""
        make = of_families([FAMILIES[name] for name in self.families], self.settings, self.rng)
        await self.send(StimulusSequence(make, self.settings, self.settings.pairs))


@listed("V1", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class RandomTest(FamilyTest):
    """General pairs at all scales, some that share vertices."""

    families = ("random", "shared")


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class DegenerateTest(FamilyTest):
    """Every combination of point, segment and triangle."""

    families = ("degenerate",)


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class CoplanarTest(FamilyTest):
    """Pairs in one plane, axis-aligned and tilted, and those that nearly are; one in the other."""

    families = ("coplanar", "coplanar near-miss", "contained")


@listed("V1", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class PenetratingTest(FamilyTest):
    """Edges through faces."""

    families = ("penetrating",)


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class SliversTest(FamilyTest):
    """Triangles as thin as the width allows."""

    families = ("slivers",)


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class TouchingTest(FamilyTest):
    """Contact of every pair of features, and misses by one step."""

    families = tuple(f"touching {name}" for name in TOUCHING)


@listed(
    "V2",
    Runs(("w16_m0",), 50_000, 100, seeds=2, smoke=("w16_m0",), signoff=False),
    # Where there is little volume to meet them by chance.
    Runs(("w13_m4_t1", "w24_m24", "w32_m32"), 400_000, 1000, seeds=2),
    why_seeds="Two: the second hits no new bin, but with one the golden model judges 31 of the 33 claims.",
)
class NearMissTest(FamilyTest):
    """Lattice near-misses of every kind of axis: the hardest decisions (docs/theory.md, section 7)."""

    families = tuple(name for name in FAMILIES if name.startswith("near-miss"))


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class ExtremesTest(FamilyTest):
    """Coordinates at the limits of the range; corners at which projections are largest."""

    families = ("extremes", "corners")


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class TinyTest(FamilyTest):
    """Coordinates of a few steps: coincidences of every kind."""

    families = ("tiny",)


@listed("V2", *_FAMILY, why_seeds=_FAMILY_SEEDS)
class FarTest(FamilyTest):
    """Pairs that their boxes decide, which the operand gate must pass over."""

    families = ("far",)


@listed(
    "V1",
    Runs(BUILDS, 3000, seeds=3, smoke=BUILDS),
    Runs(_ON_PINS, 1000, agent=PIN, seeds=3, smoke=("w16_m0",)),
    why_seeds="Three: with two the golden model judges no pair of one of the 33 claims (32 axes, and near) "
    "in w16_m0, with three every claim in each; on the pins 28 with one, 32 with two, all with three.",
)
class MixedTest(FamilyTest):
    """All families."""

    families = tuple(FAMILIES)


@listed(
    "V2",
    Runs(("w16_m0",), 1_000_000, 1 << 16, smoke=("w16_m0",), signoff=False, label="short"),
    why_seeds="One of a first million; of the volume as many as the share has runs of moderate length.",
    # Wide cores simulate slowly, and narrow ones have the same structure, so most goes to the default build
    # and to the two with margins that simulate fast; each other build gets what closes its coverage several
    # times over.
    volume={
        "w16_m0": 59.0,
        "w8_m8": 20.0,
        "w16_m16": 10.0,
        "w13_m4_t1": 2.0,
        "w16_m0_no_edge_box": 2.0,
        "w16_m0_ungated": 2.0,
        "w24_m24": 1.5,
        "w32_m32": 0.5,
        "w8_m8_certified": 2.0,
        "w16_m16_certified": 1.0,
    },
)
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


@listed(
    "V2",
    Runs(CERTIFIED, 400_000, 1000, seeds=3, smoke=("w8_m8_certified",)),
    Runs(("w8_m8_certified",), 1000, agent=PIN, seeds=3),
    why_seeds="Three: the first hits every bin of what is tried; the others are for what bins do not tell.",
)
class CertificatesTest(CoreTest):
    """The checks of a certified core, tried: claims of every axis, parity bits, numbers; with stalls."""

    async def stimulus(self) -> None:
        """Send all families, at full speed and with stalls."""
        make = of_families(list(FAMILIES.values()), self.settings, self.rng)
        rng = np.random.default_rng([self.settings.seed, *b"attempts"])
        for stalls in (FULL_SPEED, Pace(8, 3)):
            self.set_stalls(stalls)
            await self.send(AttemptsSequence(make, self.settings, self.settings.pairs // 2, rng))


@listed(
    "V1",
    # In the builds that users start with.
    Runs(USUAL, 15, smoke=("w16_m0",)),
    why_seeds="One: nothing in them is random.",
)
class SeedVectorsTest(CoreTest):
    """The fifteen vectors of the replaced design: all are clear."""

    async def stimulus(self) -> None:
        """Send them at margin 0."""
        pairs = seed_vectors(self.settings.configuration.width)
        await self.send(ArraySequence(self.settings, pairs, np.zeros(len(pairs), np.int64)))


@listed(
    "V2",
    Runs(("w16_m0",), 7200, seeds=3, smoke=("w16_m0",), signoff=False),
    Runs(_ON_PINS, 720, agent=PIN, seeds=3),
    why_seeds="Three: the orders hit 20 % more bins with the second, 6 % with the third.",
)
class OrdersTest(CoreTest):
    """All 72 orders of each pair."""

    async def stimulus(self) -> None:
        """Send whole sets of orders, each set at one margin."""
        configuration = self.settings.configuration
        count = max(1, self.settings.pairs // 72)
        base = mixed(self.rng, count, configuration.width, configuration.max_margin)
        await self.send(ArraySequence(self.settings, all_orders(base.pairs), np.repeat(base.margins, 72)))


@listed(
    "V2",
    Runs(
        ("w16_m0", "w8_m8", "w16_m16", "w16_m0_no_edge_box", "w24_m24"),
        200_000,
        1000,
        seeds=3,
        smoke=("w16_m0",),
    ),
    why_seeds="Three: of the 33 claims the golden model judges 24 with one, 31 with two, all with three.",
)
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


@listed("V1", *_PROTOCOL, why_seeds=_PROTOCOL_SEEDS)
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


@listed("V2", *_PROTOCOL, why_seeds=_PROTOCOL_SEEDS)
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

    def check_phase(self) -> None:
        """Fail also where no reset found a pair in flight."""
        super().check_phase()
        if not self.env.scoreboard.matcher.discarded:
            raise AssertionError("no pair was in flight at a reset: nothing was checked")


@listed("V3")
class ReplayTest(CoreTest):
    """Pairs that failed before, from the file that the scoreboard wrote, each after the pairs before it."""

    async def stimulus(self) -> None:
        """Send what is in the file."""
        failing = read_failing(Path(self.settings.replay), self.settings.configuration)
        streams = [one.stream.preceded_by(one.context) if one.context else one.stream for one in failing]
        pairs = np.concatenate([stream.pairs for stream in streams])
        margins = np.concatenate([stream.margins for stream in streams])
        await self.send(ArraySequence(self.settings, pairs, margins))
