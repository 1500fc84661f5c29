"""The engine's tests by name. Each says what it sends; the environment checks everything everywhere."""

from dataclasses import replace
from itertools import cycle, product
from pathlib import Path

import cocotb
import numpy as np
from cocotb.task import Task

from triaxis.golden.axes import BOX_AXES
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.mesh_engine import NO_ZONES, Mode, Trial
from triaxis.sim.player import PERIOD_NS
from triaxis.verif.core.items import FULL_SPEED, Pace
from triaxis.verif.mesh.base_test import MeshEngineTest
from triaxis.verif.mesh.expectation import ATTEMPTS, SCRUB, Memory
from triaxis.verif.mesh.items import WHICHES, RunRequest, RunTraffic, Scene
from triaxis.verif.mesh.kept_clocks import FoundClocks
from triaxis.verif.mesh.sampling import PIN_DRIVEN
from triaxis.verif.mesh.scenes import (
    MOST_FULL,
    PACES,
    STALLED,
    clock_scenes,
    extreme_scenes,
    gap_scenes,
    growing_scenes,
    random_scene,
    range_scenes,
    too_many,
    zone_scenes,
)
from triaxis.verif.testbench.settings import PIN
from triaxis.verif.testbench.table import Runs, listed

# A word of lanes to a group and one word of groups; several of each, few clocks counted, no margins; the
# widest; one lane, in the width of the board's finer build; the engine as it stands on the board; narrow;
# wide; a single group; groups of one triangle; a small one whose core is certified.
SQUARE = "mesh_w16_m16_d64_g8_l8"
WORDS = "mesh_w12_m0_d32_g4_l2_c8"
WIDEST = "mesh_w32_m32_d16_g4_l2"
ONE_LANE = "mesh_w24_m1_d16_g4_l1"
BOARD = "mesh_w16_m16_d4096_g8_l8_certified"
NARROW = "mesh_w8_m8_d16_g4_l1"
WIDE = "mesh_w24_m24_d128_g8_l4"
ONE_GROUP = "mesh_w10_m3_d8_g8_l1"
NO_GROUPS = "mesh_w9_m9_d16_g1_l1"
CERTIFIED = "mesh_w8_m8_d16_g4_l2_certified"
_ON_PINS = tuple(f"mesh_{name}" for name in PIN_DRIVEN)

# Triangles of the meshes that are to fill all queues at most; and of so many scenes one has such meshes.
_CROWD, _FULL_ONE_IN = 64, 6
# Resets strike up to two to this power of clocks after a scene begins.
_LAST_RESET = 8.7
# Scenes that are sent at least, whatever number of pairs was asked for.
_LEAST_SCENES = 40
# Scenes until a reset has ended a run, at most.
_MOST_SCENES = 10 * _LEAST_SCENES
# A run of mode all is complete; what is none of them is refused.
_EVERY_MODE = (Mode.ALL, Mode.COUNT, Mode.FIRST, 3)
# Of the attempts of the core, which has a test of its own, one in so many; a reset in place of an
# acknowledgement. Clocks that scrubbing takes, besides one a triangle. Scenes in which much is tested, so
# that the scan has something to do everywhere.
_SOME_OF, _RESET_ONE_IN, _SCRUB_LATENCY = 5, 6, 8
_MIXED = ("in_one_place", "clusters", "cloud", "one_contact")
# Scenes that rows decide, or groups, or boxes: what comes later is not used, and the core is not asked.
_DECIDED_BY = ("rows_apart", "groups_apart", "lattice")
# A triangle in the plane z = x + y, and a point above it: their boxes meet, and the next axis separates.
_APART_BY_NORMAL = np.array([[[[0, 0, 0], [9, 0, 9], [0, 9, 9]]], [[[1, 1, 9]] * 3]])


@listed(
    "V1",
    Runs((SQUARE,), 100_000, 8, seeds=3, smoke=(SQUARE,)),
    Runs((WORDS,), 40_000, 8, seeds=3, smoke=(WORDS,)),
    Runs((ONE_LANE, WIDEST), 20_000, 8, seeds=3, smoke=(ONE_LANE, WIDEST)),
    Runs((NARROW, NO_GROUPS), 20_000, 8, seeds=3, smoke=(NARROW, NO_GROUPS), signoff=False),
    Runs((ONE_GROUP,), 10_000, 8, seeds=3, smoke=(ONE_GROUP,), signoff=False),
    Runs((WIDE,), 200_000, 8, seeds=3, smoke=(WIDE,), signoff=False),
    Runs((BOARD,), 5_000_000, 8, seeds=0),
    Runs((BOARD,), 20_000_000, 8, seeds=3, signoff=False),
    Runs((SQUARE,), 3000, agent=PIN, seeds=3),
    Runs((WORDS,), 1000, agent=PIN, seeds=3, smoke=(WORDS,)),
    why_seeds="Three: a single one meets every bin of its configuration that random scenes are to meet, the "
    "others are further scenes.",
)
class MeshRandomTest(MeshEngineTest):
    """Scenes of all kinds and sizes; stalls, aborts, meshes that stay, runs that are refused."""

    async def stimulus(self) -> None:
        """Send scenes until enough pairs are accounted for."""
        sent = 0
        while self.unfinished or sent < _LEAST_SCENES:
            await self.send(random_scene(self.shapes))
            sent += 1


@listed(
    "V1",
    Runs((SQUARE,), 200_000, 16, seeds=0),
    Runs((SQUARE,), 2_000_000, 64, seeds=8, smoke=(SQUARE,), signoff=False),
    why_seeds="Eight: some million pairs in all.",
)
class MeshVolumeTest(MeshEngineTest):
    """Small scenes in volume, at full speed."""

    async def stimulus(self) -> None:
        """Send scenes, nearly all of them complete."""
        while self.unfinished:
            await self.send(random_scene(self.shapes, calm=True))


@listed(
    "V2",
    Runs((SQUARE,), 1000, 4, seeds=3, smoke=(SQUARE,)),
    Runs((WORDS, ONE_LANE, WIDEST, BOARD), 500, 4, seeds=3),
    Runs((NARROW, WIDE, ONE_GROUP, NO_GROUPS), 500, 4, seeds=3, signoff=False),
    why_seeds="Three: each takes other places and margins.",
)
class MeshGapsTest(MeshEngineTest):
    """Gaps of exactly the margin, and one step more, on each axis and side, of rows, groups, triangles, and
    of each zone.
    """

    async def stimulus(self) -> None:
        """Send all of them, again and again."""
        while True:
            for scene in (*gap_scenes(self.shapes), *zone_scenes(self.shapes)):
                await self.send(scene)
            if not self.unfinished:
                return


@listed(
    "V2",
    Runs((SQUARE, WORDS, ONE_LANE, WIDEST), 1, seeds=2),
    Runs((NARROW, WIDE, ONE_GROUP, NO_GROUPS), 1, seeds=2, signoff=False),
    Runs((BOARD,), 1, 4, seeds=2, smoke=(BOARD,)),
    why_seeds="Two: the sizes are the same with every seed, their scenes are not.",
)
class MeshLimitsTest(MeshEngineTest):
    """The limits of memory, of range, of the scan: up to one triangle too many; first near pairs anywhere."""

    async def stimulus(self) -> None:
        """Send every combination of sizes, then what ends at the ends of the range."""
        group, depth = self.configuration.group, self.configuration.depth
        around = {group // 2, group - 1, group, group + 1, 2 * group + 1}
        sizes = sorted({0, 1, depth} | {size for size in around if size < depth})
        for count_a, count_b in product([*sizes, depth + 1], repeat=2):
            await self.send(self.of_sizes(count_a, count_b))
        for scenes in (range_scenes, extreme_scenes, growing_scenes):
            for scene in scenes(self.shapes):
                await self.send(scene)
        await self.full_again()
        for place in (0, 1, 2, 5):
            await self.first_at(place)
        await self.last_of_all()

    def of_sizes(self, count_a: int, count_b: int) -> Scene:
        """Return a scene of these sizes, one more than fits among them."""
        depth = self.configuration.depth
        scene = random_scene(self.shapes, True, (min(count_a, depth), min(count_b, depth)))
        if count_a > depth:
            scene = replace(scene, a=too_many(self.shapes))
        return replace(scene, b=too_many(self.shapes)) if count_b > depth else scene

    async def first_at(self, place: int) -> None:
        """Send a scene whose first near pair comes after so many that only the core can tell are clear."""
        size = self.shapes.reach // 2
        # A tilted triangle; one step aside the boxes overlap, and the planes are apart.
        a = np.array([[[0, 0, 0], [size, -size, 0], [0, size, -size]]])
        b = np.concatenate([np.repeat(a + 1, place, 0), a])
        await self.send(Scene(a, b, ((RunRequest(mode=Mode.FIRST), RunTraffic()),)))

    async def last_of_all(self) -> None:
        """Have the last triangle of a full mesh alone reach the core: of A, of B."""
        depth = self.configuration.depth
        triangle = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]])
        aside = np.array([self.shapes.reach - 2, 0, 0])
        for counts in ((depth, 2), (2, depth)):
            # The others are on either side of where these two are.
            a, b = (
                np.repeat(triangle[None] + way * aside, n, 0) for way, n in zip((1, -1), counts, strict=True)
            )
            a[-1] = b[-1] = triangle
            runs = tuple((RunRequest(mode=mode), RunTraffic()) for mode in Mode)
            await self.send(Scene(a, b, runs))

    async def full_again(self) -> None:
        """Fill both meshes in one place, where all is near; then see them emptied by loading less."""
        depth = self.configuration.depth
        low, high = coordinate_range(self.configuration.width)
        count = min(depth, MOST_FULL)
        triangle = np.array([[low, low, low], [high, high, high], [low, high, 0]])
        full = np.repeat(triangle[None], count, 0)
        runs = tuple((RunRequest((0, 0, 0), 0, mode), RunTraffic()) for mode in _EVERY_MODE)
        await self.send(Scene(too_many(self.shapes), full, runs))
        await self.send(Scene(full, full, runs))
        await self.send(Scene(full[:1], None, runs))
        await self.send(Scene(None, full[:0], runs))
        await self.send(Scene(None, full[:1], runs))


@listed(
    "V2",
    Runs((SQUARE,), 10_000, 16, seeds=3, smoke=(SQUARE,)),
    Runs((WORDS, BOARD), 5000, 16, seeds=3),
    Runs((ONE_LANE, WIDEST), 3000, 16, seeds=3),
    Runs((NARROW,), 3000, 16, seeds=3, signoff=False),
    Runs((WIDE,), 10_000, 16, seeds=3, signoff=False),
    Runs((ONE_GROUP, NO_GROUPS), 1000, 16, seeds=3, signoff=False),
    Runs(_ON_PINS, 1000, agent=PIN, seeds=3),
    why_seeds="Three: each sweeps other scenes.",
)
class MeshAbortTest(MeshEngineTest):
    """An abort at every clock of short runs, and at places all over long ones; the next run is whole."""

    # Scenes that fill all queues.
    crowded = ("in_one_place", "clusters", "late_contacts", "every_other")

    async def stimulus(self) -> None:
        """Find out how long a run takes, then abort it everywhere."""
        while True:
            await self.sweep()
            await self.crowd()
            if not self.unfinished:
                return

    async def sweep(self) -> None:
        """Abort one scene in each mode, the refused one too."""
        group, depth = self.configuration.group, self.configuration.depth
        scene = random_scene(self.shapes, True, (min(group + 1, depth), min(2 * group, depth)), _MIXED)
        request = scene.runs[0][0]
        for mode in _EVERY_MODE:
            asked = replace(request, mode=int(mode))
            plain = (asked, RunTraffic())
            length = (await self.send(replace(scene, runs=(plain,)))).runs[0].clocks
            for at in self.moments(length, 100 if mode == Mode.ALL else 40):
                await self.send(Scene(None, None, (self.aborted(asked, at), plain)))

    async def crowd(self) -> None:
        """Abort a run on full meshes while near pairs are held back, at every clock until nothing moves."""
        depth = min(self.configuration.depth, _CROWD)
        scene = random_scene(self.shapes, True, (depth, depth), self.crowded)
        request = scene.runs[0][0]
        await self.send(scene)
        held = Pace(1, 300)
        for at in range(0, 6 if self.on_pins else 80):
            await self.send(Scene(None, None, ((request, RunTraffic(held, aborts=(at,))),)))
        await self.send(Scene(None, None, ((request, RunTraffic()),)))

    def moments(self, length: int, most: int) -> list[int]:
        """Return the clocks at which to abort: all or so many, a few on the pins."""
        most = 6 if self.on_pins else most
        if length < most:
            return list(range(length + 1))
        some = self.rng.integers(0, length + 1, most).tolist()
        return sorted({0, 1, 2, 3, length - 2, length - 1, *some})

    def aborted(self, request: RunRequest, at: int) -> tuple[RunRequest, RunTraffic]:
        """Return the run with an abort, now and then with several, and one before it."""
        stalled = Pace(1, int(self.rng.choice([0, 0, 3, 12])))
        aborts = (at, at + 1, at + int(self.rng.integers(2, 12)))
        traffic = RunTraffic(stalled, stalled, aborts if self.rng.integers(2) else (at,), True)
        return request, traffic


@listed(
    "V1",
    Runs(_ON_PINS, 1000, agent=PIN, seeds=3, smoke=(SQUARE,)),
    Runs((*_ON_PINS, ONE_LANE), 5000, 8, seeds=3, smoke=(WORDS,)),
    Runs((NARROW,), 5000, 8, seeds=3, signoff=False),
    why_seeds="Three: other scenes and stalls.",
)
class MeshStallsTest(MeshEngineTest):
    """Gaps on loading, back-pressure on near pairs and summaries, runs and meshes offered too early."""

    # The last is for runs that are not on the pins: near pairs wait while all that can goes on.
    paces = (*PACES, Pace(1, 40), Pace(64, 400))

    async def stimulus(self) -> None:
        """Send scenes with near pairs at every combination of paces, the next mesh offered during a run."""
        paces = self.paces[:-1] if self.on_pins else self.paces
        before: Task[None] | None = None
        for number, (near, done) in enumerate(cycle(product(paces, repeat=2))):
            if number >= len(paces) ** 2 and not self.unfinished:
                break
            gaps = (FULL_SPEED, Pace(1, 6))[int(self.rng.integers(2))]
            sequence = self.sequence(self.stalled(gaps, RunTraffic(near, done)))
            going = cocotb.start_soon(sequence.start())
            await sequence.loaded.wait()
            if before:
                await before
            if self.rng.integers(2):
                await going
            before = going
        if before:
            await before

    def stalled(self, gaps: Pace, traffic: RunTraffic) -> Scene:
        """Return a small scene; now and then, but on the pins, one that fills all queues."""
        depth = self.configuration.depth
        counts = self.rng.integers(1, min(depth, 3 * self.configuration.group) + 1, 2).tolist()
        if not self.on_pins and self.rng.integers(_FULL_ONE_IN) == 0:
            counts = [min(depth, _CROWD)] * 2
        scene = random_scene(self.shapes, True, (counts[0], counts[1]))
        request = replace(scene.runs[0][0], mode=int(self.rng.choice([Mode.FIRST, Mode.ALL, Mode.ALL])))
        early, chained = (bool(self.rng.integers(2)) for _ in range(2))
        return replace(scene, runs=((request, traffic),) * 2, gaps=gaps, early=early, chained=chained)


@listed(
    "V2",
    Runs(_ON_PINS, 1000, agent=PIN, seeds=3, smoke=(SQUARE,)),
    Runs((*_ON_PINS, ONE_LANE), 5000, 8, seeds=3),
    Runs((NARROW,), 5000, 8, seeds=3, signoff=False),
    why_seeds="Three: other scenes and places of resets.",
)
class MeshResetsTest(MeshEngineTest):
    """Resets at any moment, while meshes are loaded and while runs go on."""

    async def stimulus(self) -> None:
        """Send scenes while resets strike; end with undisturbed ones."""
        moments = np.random.default_rng([self.settings.seed, *b"resets"])
        sent = 0
        matcher = self.env.scoreboard.matcher
        while self.unfinished or sent < (_LEAST_SCENES if matcher.ended_by_reset else _MOST_SCENES):
            sent += 2
            traffic = cocotb.start_soon(self.send(random_scene(self.shapes)))
            await self.between_edges()
            await self.clocks(int(2 ** moments.uniform(0, _LAST_RESET)))
            struck = not traffic.done()
            if struck:
                late = int(moments.integers(0, PERIOD_NS - 1))
                await self.reset(int(moments.choice([1, 2, 3, 30])), late)
            await traffic
            await self.send(self.afterwards(struck))

    def afterwards(self, struck: bool) -> Scene:
        """Return a scene; after a reset, at times one that empties no mesh, but relies on what it finds."""
        scene = random_scene(self.shapes, calm=True)
        return replace(scene, append=struck and bool(self.rng.integers(2)))

    def check_phase(self) -> None:
        """Fail also where no reset has ended a run."""
        super().check_phase()
        if not self.env.scoreboard.matcher.ended_by_reset:
            raise AssertionError("no reset has ended a run: nothing was checked")


@listed(
    "V2",
    Runs((SQUARE, WORDS, ONE_LANE, WIDEST, BOARD), 1, 8, seeds=3),
    Runs((NARROW, WIDE, ONE_GROUP, NO_GROUPS, CERTIFIED), 1, 8, seeds=3, smoke=(CERTIFIED,), signoff=False),
    Runs((WORDS,), 1, 8, agent=PIN, seeds=1),
    why_seeds="Three: other scenes; what is tried is the same.",
)
class MeshTrialsTest(MeshEngineTest):
    """Each check is tried: a fault, which stays until it is acknowledged, or a reset comes."""

    async def stimulus(self) -> None:
        """Try everything in turn; see the fault stay, and end. Then in runs that do not use all there is."""
        every = [
            *product((Trial.WALK, Trial.INTAKE), range(WHICHES)),
            *product((Trial.MEMORY,), (*range(WHICHES), *Memory, *Memory, *Memory)),
            *product((Trial.CLAIM, Trial.PARITY, Trial.NUMBER), range(0, WHICHES, _SOME_OF)),
            (Trial.BOARD, 0),
            (Trial.NOTHING, WHICHES - 1),
        ]
        modes = cycle((*Mode, 3))
        for number in self.rng.permutation(len(every)).tolist():
            for mode in (Mode.ALL, next(modes)):
                await self.attempt(every[number], int(mode))
        used = [*product((Trial.MEMORY,), Memory), *product(ATTEMPTS, (0,))]
        for tries, kind in product(used, _DECIDED_BY):
            await self.attempt(tries, int(Mode.ALL), kind)
        # A claim that holds is none of the faults that are looked for.
        holds = RunRequest(tries=(Trial.CLAIM, BOX_AXES))
        a, b = _APART_BY_NORMAL
        await self.send(Scene(a, b, ((holds, RunTraffic()),)))

    async def attempt(self, tries: tuple[int, int], mode: int, decided_by: str = "") -> None:
        """Send a scene with a run that tries something, and runs after it; ``decided_by``: its kind."""
        most = min(self.configuration.depth, 2 * self.configuration.group + 1)
        counts = [most, most] if decided_by else self.rng.integers(1, most + 1, 2).tolist()
        kinds = (decided_by,) if decided_by else _MIXED
        scene = random_scene(self.shapes, True, (counts[0], counts[1]), kinds)
        plain = replace(scene.runs[0][0], mode=mode)
        aborts = (int(self.rng.integers(0, 40)),) if self.rng.integers(4) == 0 else ()
        # What comes of an attempt depends on how the core is asked, and with zones that on the moment. And
        # what boxes decide at the margin, a wider zone may leave to the core.
        zones = NO_ZONES if decided_by or tries[0] in ATTEMPTS else plain.zones
        asked = replace(plain, tries=tries, zones=zones)
        await self.send(replace(scene, runs=((asked, RunTraffic(aborts=aborts)),)))
        if tries[0] == Trial.MEMORY and tries[1] >= SCRUB:
            if mode != Mode.ALL and self.rng.integers(_RESET_ONE_IN) == 0:
                # What was to be found is forgotten with all the rest.
                await self.between_edges()
                await self.reset(1, 0)
                await self.send(replace(scene, runs=((plain, RunTraffic()),)))
                return
            await self.clocks(self.configuration.depth + _SCRUB_LATENCY)
            await self.between_edges()
        there = replace(scene, a=None, b=None) if self.rng.integers(2) else scene
        await self.send(replace(there, runs=((plain, RunTraffic()),)))
        after = RunTraffic(acknowledge=True)
        if self.rng.integers(_RESET_ONE_IN) == 0:
            await self.between_edges()
            await self.reset(1, 0)
            after = RunTraffic()
        await self.send(replace(scene, runs=((plain, after), (plain, RunTraffic()))))


@listed(
    "V2",
    Runs((SQUARE, WORDS, ONE_LANE, WIDEST, BOARD), 1, 16, seeds=1),
    Runs((NARROW,), 1, 16, seeds=1, smoke=(NARROW,), signoff=False),
    why_seeds="One: the scenes are the same with every seed.",
)
class MeshClocksTest(MeshEngineTest):
    """The clocks of fixed scenes are those that are kept: no engine gets slower unseen.

    On the pins those without stalls: where in its pattern a stall begins is not the same there.
    """

    async def stimulus(self) -> None:
        """Send them, and compare what loading and runs take."""
        clocks = FoundClocks(self.settings.config, Path(self.settings.folder))
        left_out = STALLED if self.on_pins else ""
        for name, scene in clock_scenes(self.configuration):
            if left_out and name.startswith(left_out):
                break
            sent = await self.send(scene)
            clocks.add(name, [item.clocks for item in (*sent.loads, *sent.runs)])
        clocks.check(left_out)
