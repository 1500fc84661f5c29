"""How a run must end, if nothing aborts it, and what it tries; whether lists of pairs are what is due."""

import zlib
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
import numpy.typing as npt

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.pairs import coordinate_range
from triaxis.golden.scene import SceneAnswer
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.mesh_engine import Mode, Move, Status, Trial
from triaxis.sim.result import FAULT, NEAR
from triaxis.verif.core.expectation import tried_words
from triaxis.verif.mesh.items import Integers, ObservedRun


def moved(triangles: Integers, translation: Move) -> Integers:
    """Return triangles (N, 3, 3) moved by a translation."""
    return triangles + np.array(translation, np.int64)


def overflows(triangles: Integers, translation: Move, width: int) -> bool:
    """Return whether any coordinate of triangles (N, 3, 3), moved, leaves the width."""
    low, high = coordinate_range(width)
    there = moved(triangles, translation)
    return bool(len(there)) and bool(there.min() < low or there.max() > high)


def expected_status(run: ObservedRun, configuration: MeshConfiguration) -> Status:
    """Return the status that is due; COMPLETE also where mode first may stop earlier."""
    if run.request.mode not in list(Mode):
        return Status.BAD_MODE
    if any(run.overfull):
        return Status.OVERFULL
    if overflows(run.a, run.request.translation, configuration.width):
        return Status.OVERFLOW
    return Status.COMPLETE


def expected_signature(triangles: Integers, width: int) -> int:
    """Return the CRC-32 of triangles (N, 3, 3) as the line carries them, coordinates of whole bytes."""
    octets = triangles.astype("<i8").reshape(-1, 1).view(np.uint8)[:, : (width + 7) // 8]
    return zlib.crc32(octets.tobytes())


class Memory(IntEnum):
    """Memories of which a trial takes the words as broken; memory_e of triaxis_mesh_pkg."""

    GROUPS_A = 0
    GROUPS_B = 1
    BOXES_A = 2
    BOXES_B = 3
    TRIANGLES_A = 4
    TRIANGLES_B = 5


# Of trials of memories: from the one on they are tried where they are scrubbed, from the other on the
# comparisons of the scrub itself, of both meshes: triaxis_mesh_pkg, triaxis_mesh_scrub.
SCRUB, SCRUBBED, SCRUB_COMPARISONS = 8, 16, 14
_SCRUBS = (*range(SCRUB, SCRUB + len(Memory)), *range(SCRUBBED, SCRUBBED + SCRUB_COMPARISONS))


def scrub_finds(run: ObservedRun) -> bool:
    """Return whether what a run tries is found after it, by scrubbing: nothing is in an empty mesh."""
    kind, which = run.request.tries
    if kind != Trial.MEMORY:
        return False
    if which >= SCRUBBED:
        return which < SCRUBBED + SCRUB_COMPARISONS and bool(len(run.a) or len(run.b))
    of_b = (Memory.GROUPS_B, Memory.BOXES_B, Memory.TRIANGLES_B)
    memory = which - SCRUB
    return memory in list(Memory) and bool(len(run.b if memory in of_b else run.a))


ATTEMPTS = (Trial.CLAIM, Trial.PARITY, Trial.NUMBER)


@dataclass(frozen=True)
class Tried:
    """What comes of what a run tries. ``answer``: what the run must give then, None where nothing is run.

    ``fails``: it is a fault; ``may_fail``: it may be one, where the run ends before all is scanned.
    ``comes``: a whole scan comes to it: an attempt needs a pair in a certified core, a memory one that reads
    it; a number that is none of a memory's, a scan.
    """

    answer: SceneAnswer | None
    fails: bool
    may_fail: bool
    comes: bool


def tried(run: ObservedRun, answer: SceneAnswer | None, configuration: MeshConfiguration) -> Tried:
    """Return what comes of what a run tries, where ``answer`` is due otherwise."""
    kind, which = run.request.tries
    if kind in (Trial.WALK, Trial.INTAKE):
        return Tried(answer, fails=True, may_fail=True, comes=True)
    fails = False
    comes = scrub_finds(run)
    if answer is not None and answer.near.size:
        if kind in ATTEMPTS and configuration.certified:
            return _attempted(run, answer, configuration)
        if kind == Trial.MEMORY and which < len(Memory):
            uses = {
                Memory.GROUPS_A: True,
                Memory.GROUPS_B: not answer.rows_apart.all(),
                Memory.BOXES_A: answer.group_pairs_opened > 0,
                Memory.BOXES_B: answer.group_pairs_opened > 0,
                Memory.TRIANGLES_A: answer.tested > 0,
                Memory.TRIANGLES_B: answer.tested > 0,
            }
            comes = fails = bool(uses[Memory(which)])
        elif kind == Trial.MEMORY:
            comes |= which not in _SCRUBS
    return Tried(answer, fails=fails and not run.aborts, may_fail=fails, comes=comes)


def _attempted(run: ObservedRun, answer: SceneAnswer, configuration: MeshConfiguration) -> Tried:
    """Return what comes of an attempt of the core: pairs of which it is a fault are near."""
    i, j = answer.to_be_tested.T
    pairs = np.stack([moved(run.a, run.request.translation)[i], run.b[j]], 1)
    core = Configuration(configuration.width, configuration.margin_bits, certified=True)
    facts = bulk_facts(pairs, np.full(len(pairs), run.request.margin))
    words = np.where(facts.separating == 0, np.uint16(NEAR), np.uint16(0))
    attempts = np.full(len(pairs), run.request.trial, np.int64)
    faults = tried_words(words, facts, attempts, core) & np.uint16(FAULT) != 0
    near = answer.near.copy()
    near[i, j] |= faults
    # A run that stops at its first near pair need not come to a later one.
    first = np.argmax(near[i, j]) if len(i) else 0
    certain = bool(faults.any()) and (run.request.mode != Mode.FIRST or bool(faults[first]))
    return Tried(
        replace(answer, near=near),
        certain and not run.aborts,
        may_fail=bool(faults.any()),
        comes=bool(len(i)),
    )


def walked(answer: SceneAnswer, tested: int) -> dict[str, int]:
    """Return what a walk has counted at least, by counter, that was as far as so many tested pairs."""
    if not tested:
        return dict.fromkeys(("group_pairs_skipped", "group_pairs_opened", "pairs_skipped"), 0)
    i, j = answer.to_be_tested[tested - 1].tolist()
    group, apart = answer.group, answer.groups_apart
    row, column = i // group, j // group
    skipped = int(apart[:row].sum() + apart[row, :column].sum())
    # In groups that are not skipped, up to the pair itself.
    boxes = answer.boxes_apart & ~answer.in_groups_apart
    here = boxes[row * group :, column * group : (column + 1) * group]
    before = boxes[: row * group].sum() + boxes[row * group : (row + 1) * group, : column * group].sum()
    return {
        "group_pairs_skipped": skipped,
        "group_pairs_opened": apart[:row].size + column + 1 - skipped,
        "pairs_skipped": int(before + here[: i % group].sum() + here[i % group, : j % group].sum()),
    }


def begins(whole: Integers, part: Integers) -> bool:
    """Return whether pairs (N, 2) begin with pairs (K, 2)."""
    return len(part) <= len(whole) and bool((whole[: len(part)] == part).all())


def in_order_of(found: Integers, due: Integers) -> Integers:
    """Return pairs (N, 2) that are due in the order in which they were found: those of ``found`` first."""
    places = {pair: number for number, pair in enumerate(map(tuple, found.tolist()))}
    order = sorted(range(len(due)), key=lambda n: places.get(tuple(due[n].tolist()), len(places)))
    return due[np.array(order, np.int64)]


def first_of(mask: npt.NDArray[np.bool_]) -> tuple[int, int]:
    """Return the first pair of a mask (N, M) that is set."""
    i, j = np.argwhere(mask)[0]
    return int(i), int(j)


def difference(found: Integers, due: Integers) -> str:
    """Return where two lists of pairs part, in words."""
    common = min(len(found), len(due))
    unlike = np.flatnonzero((found[:common] != due[:common]).any(1))
    at = int(unlike[0]) if len(unlike) else common
    here = [str(tuple(pairs[at].tolist())) if at < len(pairs) else "none" for pairs in (found, due)]
    return f"number {at} is {here[0]}, {here[1]} is due; {len(found)} and {len(due)} in all"
