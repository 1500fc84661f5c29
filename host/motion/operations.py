"""The parts of a program through which a machine is followed: one tool, and A, B, C that stand still.

Between them a tool is changed, or axes turn.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import pairwise

from triaxis.golden.errors import InputError
from triaxis.host.enclosure import Enclosure
from triaxis.host.engines import SceneEngine, unwatched
from triaxis.host.motion.contact import Rule, Setup, rules_of
from triaxis.host.motion.follow import DisagreementError, Piece, pieces
from triaxis.host.motion.kinematics import ROTARY
from triaxis.host.motion.machine import Machine, Tool
from triaxis.host.motion.moves import Program
from triaxis.host.motion.path_check import bulk_engine, insides_at
from triaxis.host.motion.path_scene import PathScene, Wanted, prepare_path
from triaxis.host.motion.rule_check import check_rule
from triaxis.host.motion.supervision import Names, Supervision, stands_and_turns
from triaxis.host.quantise import Vector


@dataclass(frozen=True)
class NearTurn:
    """A turn in which two objects come near each other."""

    line: int
    names: Names


def _near_turn(tool: Tool, rules: Sequence[Rule], wanted: Wanted) -> NearTurn | None:
    """Return where a turn is near first, by any of its rules, as `path` finds it; None where it is clear.

    Objects are outside of each other, as they were at the start; raises InputError where nobody knows whether
    something is inside of the stock.
    """
    found = list[NearTurn]()
    for rule in rules:
        checked = check_rule(tool, rule, wanted, bulk_engine, unwatched, not rule.of_stock, False)
        moves, result = rule.program.moves, checked.result
        if checked.near_at is not None:
            found.append(NearTurn(moves[rule.numbers.index(checked.near_at)].line, rule.names))
        elif result.verdict == "unknown":
            at = f" at the start of line {moves[result.asked_at].line}"
            result.insides.refuse_undecided(rule.files, False, at)
    return min(found, key=lambda near: near.line, default=None)


@dataclass(frozen=True)
class Operation:
    """A part of the program with one tool, on which A, B, C stand still, and its pieces.

    ``ends``: the program does: no turn, and no change of the tool, comes after it.
    """

    setup: Setup
    supervised: Supervision
    scene: PathScene
    engine: SceneEngine
    pieces: Sequence[Piece]
    ends: bool = False

    @property
    def tool(self) -> Tool:
        """Return the tool in the spindle."""
        return self.setup.tool

    @property
    def machine(self) -> Machine:
        """Return the machine, with all of its tools."""
        return self.setup.machine

    @property
    def angles(self) -> Vector:
        """Return where A, B, C stand, in degrees."""
        return self.scene.program.moves[0].turns[0]

    def words(self, angles: Vector) -> str:
        """Return angles of the axes that the machine has in words."""
        return " ".join(
            f"{letter}{float(angles[ROTARY.index(letter)]):g}" for letter in sorted(self.machine.rotary)
        )

    def stands(self, angles: Vector) -> bool:
        """Return whether A, B, C are where they are on this part, by the machine's own tolerance."""
        tolerance = self.machine.turn_tolerance or 0
        return all(
            abs(angles[k] - self.angles[k]) <= tolerance for k in map(ROTARY.index, self.machine.rotary)
        )

    def stopped_before(self, near: NearTurn) -> "Operation":
        """Return the same with a machine that is stopped before the place where a turn would be near."""
        *others, last = self.pieces
        if last.near:
            return self
        return replace(self, pieces=(*others, replace(last, near=True, beside=near.names, line=near.line)))

    def insides(self) -> Iterator[tuple[Enclosure, Names, Names]]:
        """Yield whether one of two is inside the other at the start, their files, and their names."""
        sides = self.supervised.tool, self.supervised.work
        files, names = (sides[0].files, sides[1].files), (sides[0].name, sides[1].name)
        yield insides_at(self.scene), files, names
        for beside in self.supervised.beside:
            # Of a stock that is asked where a move begins on which it counts.
            if not beside.rule.of_stock:
                yield beside.insides, beside.rule.files, beside.rule.names

    def near_objects(self, piece: Piece) -> Names:
        """Return two objects that are near in a piece, by the engine that cut it.

        Raises DisagreementError where that finds none.
        """
        if piece.beside is not None:
            return piece.beside
        near = self.engine.run(piece.sample, piece.margin, stop_at_first=True).near
        if not len(near):
            raise DisagreementError(piece.line, "near", "clear")
        a, b = map(int, near[0])
        return self.supervised.tool.named(a), self.supervised.work.named(b)


def check_told_apart(parts: Sequence[Operation]) -> None:
    """Raise InputError where a part begins with the tool and the angles of the one before it.

    What is between them, nothing that positions tell would show.
    """
    for one, other in pairwise(parts):
        apart = 2 * (one.machine.turn_tolerance or 0)
        alike = all(abs(a - b) <= apart for a, b in zip(one.angles, other.angles, strict=True))
        if one.tool.number == other.tool.number and alike:
            raise InputError(
                f"{other.scene.program.path}: line {other.pieces[0].line}: the same tool and angles as "
                "before the changes that come first, so that nothing tells when these are over: move X, Y or "
                "Z between them, or check with path"
            )


def parts_of(
    setup: Setup, stretch: Program, wanted: Wanted, widths: Sequence[Fraction]
) -> Iterator[Operation | NearTurn]:
    """Yield the parts of a program with one tool, in its order; of turns those that are near.

    ``widths``: of zones, from the innermost, in millimetres.
    """
    rules, first = rules_of(setup, stretch, 0), 0
    for part in stands_and_turns(stretch, setup.machine.turn_tolerance or Fraction(0)):
        kept = [one for rule in rules if (one := rule.among(first, len(part.moves))) is not None]
        first += len(part.moves)
        if not part.moves[0].turning:
            yield _operation(setup, part, kept, wanted, widths)
        elif near := _near_turn(setup.tool, kept, wanted):
            yield near


def _operation(
    setup: Setup, program: Program, rules: Sequence[Rule], wanted: Wanted, widths: Sequence[Fraction]
) -> Operation:
    """Cut a part of a program in pieces; ``rules``: what must stay clear of what on its moves."""
    supervised = Supervision.of(setup, program, rules, wanted)
    tool, work, off = supervised.tool, supervised.work, supervised.off
    wider = replace(wanted, clearance=wanted.clearance + off)
    scene = prepare_path(tool.mesh, work.mesh, (tool.files, work.files), program, wider)
    engine = bulk_engine(scene)
    zones = [
        (scene.within(width + off), partial(supervised.within(width).near_beside, scene)) for width in widths
    ]
    beside = partial(supervised.near_beside, scene)
    found = pieces(scene, engine, wanted.step, beside=beside, zones=zones)
    return Operation(setup, supervised, scene, engine, found)
