"""What mutants are played with: the environment's own sequences, short and directed first, volume after.

Each play is named by the test that sends such pairs and by the family that they are of.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import coordinate_range
from triaxis.sim.core_engine import Sent, Steps, core_words
from triaxis.sim.detector import detector_inputs
from triaxis.sim.result import NEAR
from triaxis.verif.core.expectation import expected_words
from triaxis.verif.core.kept_cases import load_regressions
from triaxis.verif.core.stimulus.families import FAMILIES, mixed, mixture
from triaxis.verif.core.stimulus.schedules import filling, flowing, resets, stalls
from triaxis.verif.core.stimulus.stimulus import Stimulus
from triaxis.verif.mutation.targets import Target

# Of each family, in a directed run.
PAIRS = 150
# Few corners reach a bound that shows in the verdict.
_SHARES = {"corners": 8}
_FIRST = ("random", "corners")
# Pairs of a burst of the volume.
BURST = 1 << 15

_TESTS = {
    "random": "RandomTest", "shared": "RandomTest", "degenerate": "DegenerateTest", "far": "FarTest",
    "coplanar": "CoplanarTest", "coplanar near-miss": "CoplanarTest", "contained": "CoplanarTest",
    "penetrating": "PenetratingTest", "slivers": "SliversTest", "extremes": "ExtremesTest",
    "corners": "ExtremesTest", "tiny": "TinyTest",
}  # fmt: skip


def test_of(family: str) -> str:
    """Return the name of the test that sends a family."""
    if family.startswith("touching"):
        return "TouchingTest"
    if family.startswith("near-miss"):
        return "NearMissTest"
    return _TESTS[family]


@dataclass(frozen=True)
class Play:
    """Pairs (N, 2, 3, 3) with margins (N,) and tags (N,), sent by a schedule, and what must come back."""

    test: str
    family: str
    target: Target
    pairs: npt.NDArray[np.int64]
    margins: npt.NDArray[np.int64]
    tags: npt.NDArray[np.int64]
    padding: npt.NDArray[np.uint8]
    steps: Steps

    def __len__(self) -> int:
        """Return the number of pairs."""
        return len(self.margins)

    @cached_property
    def expected(self) -> npt.NDArray[np.uint16]:
        """Return the result words (N,), from the exact checker."""
        return expected_words(bulk_facts(self.pairs, self.margins), self.target.configuration)

    @cached_property
    def collides(self) -> npt.NDArray[np.uint8]:
        """Return what the wrapper must answer (N,)."""
        return (self.expected & NEAR != 0).astype(np.uint8)

    @cached_property
    def sent(self) -> Sent:
        """Return the words that are sent."""
        return core_words(
            self.pairs, self.margins, self.tags, self.target.configuration, self.steps, self.padding
        )

    @cached_property
    def inputs(self) -> npt.NDArray[np.int64]:
        """Return the inputs of the wrapper (N, 24): coordinates, and given normals of no meaning."""
        width = self.target.configuration.width
        low, high = coordinate_range(width)
        normals = np.random.default_rng(len(self)).integers(low, high + 1, (len(self), 2, 3))
        return detector_inputs(self.pairs, normals, width)


def _play(
    rng: np.random.Generator, test: str, family: str, target: Target, stimulus: Stimulus, steps: Steps
) -> Play:
    count = len(stimulus)
    return Play(
        test, family, target, stimulus.pairs.astype(np.int64), stimulus.margins.astype(np.int64),
        rng.integers(0, 1 << target.configuration.tag_bits, count), rng.integers(0, 256, count, np.uint8),
        steps,
    )  # fmt: skip


def directed(target: Target, seed: int, pairs: int = PAIRS) -> list[Play]:
    """Return the short runs, the quickest first: each family, kept cases, stalls, resets."""
    rng = np.random.default_rng((seed, 1))
    width, largest = target.configuration.width, target.configuration.max_margin
    plays = [
        _play(
            rng,
            test_of(name),
            name,
            target,
            make(rng, _SHARES.get(name, 1) * pairs, width, largest),
            flowing(),
        )
        for name, make in FAMILIES.items()
    ]
    # What Random leaves are mostly widths, which corners show.
    plays.sort(key=lambda play: play.family not in _FIRST)
    kept = load_regressions(target.configuration)
    if len(kept[1]):
        plays.append(_play(rng, "RegressionsTest", "kept cases", target, _stimulus(kept), flowing()))
    if not target.combinational:
        for test, steps in (
            ("StallsTest", stalls(rng)), ("StallsTest", filling(rng)), ("ResetsTest", resets(rng)),
        ):  # fmt: skip
            pairs_ = mixed(rng, 6 * pairs, width, largest)
            plays.append(_play(rng, test, "all families", target, pairs_, steps))
    return plays


def _stimulus(pairs: tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]) -> Stimulus:
    return Stimulus(pairs[0].astype(np.int32), pairs[1].astype(np.uint32))


def volume(target: Target, seed: int, bursts: int) -> Iterator[Play]:
    """Iterate over bursts of all families; every fourth one with stalls and resets."""
    rng = np.random.default_rng((seed, 2))
    supply = mixture(rng, target.configuration.width, target.configuration.max_margin)
    for number in range(bursts):
        steps = resets(rng) if number % 4 == 3 else flowing()
        yield _play(rng, "VolumeTest", "all families", target, supply.burst(BURST), steps)
