"""Whether two objects stay clear of each other on a part of a program: the pieces of it, checked in turn.

A part of a turn is cut in halves where it is near, until no point is off by more than half a step.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from triaxis.golden.errors import InputError
from triaxis.host.enclosure import State
from triaxis.host.engines import Progress, SceneEngine, unwatched
from triaxis.host.euclidean import ROOT_3
from triaxis.host.motion.contact import Rule
from triaxis.host.motion.kinematics import Piece
from triaxis.host.motion.machine import Tool
from triaxis.host.motion.path_check import PathResult, bulk_engine, check_path, near_moves
from triaxis.host.motion.path_scene import PathScene, Wanted
from triaxis.host.scene import AUTOMATIC_WIDTHS

# Bits of the grid's width that a part of a turn takes at most, less than all.
_COARSE_BITS = 4
# Of one move between two objects: against a check that does not end.
_MOST_PIECES = 20_000
# A zone is looked at in pieces no longer than this part of its width.
_PART_OF_ZONE = 16


@dataclass(frozen=True)
class RuleCheck:
    """What must stay clear of what on a part of the program with one tool, and what came of it.

    ``scene``: of the last of its pieces; ``band``: how far beyond the clearance a false alarm can be, in
    millimetres.
    """

    tool: Tool
    rule: Rule
    result: PathResult
    scene: PathScene
    band: Fraction

    @property
    def near_at(self) -> int | None:
        """Return the move of the whole program where it is near, if it is."""
        near, inside = self.result.near, self.result.insides.state == State.INSIDE
        found = [self.result.asked_at] * inside + ([] if near is None else [near.move])
        return self.rule.numbers[min(found)] if found else None

    def place_near(self) -> tuple[int, Fraction]:
        """Return the move of the whole program where it is near, and which part of it is behind there."""
        move, near = self.near_at, self.result.near
        assert move is not None
        within = near is not None and self.rule.numbers[near.move] == move
        return move, near.part_of_move if near is not None and within else Fraction(0)


def check_rule(
    tool: Tool, rule: Rule, wanted: Wanted, engine_of: Callable[[PathScene], SceneEngine], progress: Progress,
    surfaces_only: bool, asked_again: bool,
) -> RuleCheck:  # fmt: skip
    """Check all pieces of a path, as far as the first that is not clear.

    ``surfaces_only``, ``asked_again``: see `check_path`. Raises InputError where a turn stays undecided.
    """
    step = wanted.step
    whole, turned, checked, pieces, band = PathResult(), -1, None, 0, Fraction(0)
    for found in rule.pieces(_coarse(wanted)):
        pieces = pieces if found.first == turned else 0
        pending = [found]
        while pending:
            piece = pending.pop()
            scene = rule.scene(piece, wanted)
            watched = unwatched if piece.swept else progress
            result = check_path(scene, engine_of(scene), watched, surfaces_only, asked_again)
            pieces += 1
            if pieces > _MOST_PIECES:
                raise InputError(
                    f"{rule.program.path}: line {piece.program[0].line}: undecided after {_MOST_PIECES} "
                    'parts of its turn: give rapids = "straight" in the machine file, or a coarser --step'
                )
            undecided = result.near is not None or result.verdict == "unknown"
            if undecided and piece.swept > step / 2:
                whole.effort.join(result.effort)
                pending += reversed(piece.halves())
                continue
            near = result.near and piece.found(result.near)
            whole.join(replace(result, near=near), piece.first)
            # Nothing near counts where points are off by more than half a step: that is cut in halves.
            less = max(Fraction(0), piece.swept - step / 2) * (ROOT_3 if wanted.euclidean else 1)
            band = max(band, scene.band - less)
            checked = RuleCheck(tool, rule, whole, scene, band)
            if result.verdict != "clear":
                return checked
        if found.swept and found.first != turned:
            progress(1)
            turned = found.first
    assert checked is not None
    return checked


def moves_within(
    rule: Rule, wanted: Wanted, widths: Sequence[Fraction], progress: Progress = unwatched
) -> list[set[int]]:
    """Return the moves of the whole program that are not shown to be beyond zones, by Chebyshev's distance.

    ``widths``: of the zones in millimetres, from the innermost on; so are the answers. The bulk checker
    decides. A turn that stays undecided is in a zone.
    """
    found = [set[int]() for _ in widths]
    step = max(wanted.step, widths[0] / _PART_OF_ZONE)
    widest = replace(wanted, clearance=widths[-1], step=step, width=None, euclidean=False, margin_bits=None)
    turned, pieces = -1, 0
    for piece in rule.pieces(_coarse(widest)):
        if not piece.swept:
            _add_within(rule, piece, widest, widths, found, progress)
            continue
        if piece.first != turned:
            progress(1)
            turned, pieces = piece.first, 0
        pending = [piece]
        while pending and rule.numbers[turned] not in found[0]:
            part = pending.pop()
            pieces += 1
            inside = [set[int]() for _ in widths]
            _add_within(rule, part, widest, widths, inside, unwatched)
            # What was found counts where points are off by less than half a step, or where nothing is new.
            if part.swept <= step / 2 or pieces > _MOST_PIECES or all(map(set.__le__, inside, found)):
                for zone, more in zip(found, inside, strict=True):
                    zone |= more
            else:
                pending += reversed(part.halves())
    return found


def _add_within(
    rule: Rule, piece: Piece, widest: Wanted, widths: Sequence[Fraction], found: list[set[int]],
    progress: Progress,
) -> None:  # fmt: skip
    """Add the moves of a piece to the zones that they are not shown to be beyond."""
    scene = rule.scene(piece, widest)
    engine, left = bulk_engine(scene), [*range(len(piece.moves))]
    for width, moves in zip(reversed(widths), reversed(found), strict=True):
        # What is beyond a zone is beyond those within.
        program = replace(scene.program, moves=tuple(piece.moves[number] for number in left))
        zone = replace(scene.within(width), program=program)
        left = [left[number] for number in near_moves(zone, engine, progress)]
        moves.update(rule.numbers[piece.first + number] for number in left)
        if not left:
            break
        progress = unwatched


def _coarse(wanted: Wanted) -> Fraction:
    """Return how far points may be off in the parts of a turn that are looked at first, in millimetres."""
    bits = (wanted.width or AUTOMATIC_WIDTHS[0]) - _COARSE_BITS
    return max(wanted.step / 2, wanted.resolution * (1 << bits))
