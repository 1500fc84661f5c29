"""What must stay clear of what while a program runs: cutting is allowed, crashing is not.

Without a stock, the tool must stay clear of the workpiece, always. With one, the workpiece is what nothing
may touch, and

    the tool            stays clear of the workpiece on all moves,
    the tool's body     (what does not cut: shank, holder) of the stock on all moves,
    the cutter          of the stock on rapids, but for those that go where nothing can be left.

The stock is taken as it is before the operation; what was cut away is not tracked. So a rapid out of a cut
begins within the stock, and the rule for it is one of geometry alone. Say that a tool has *been* at a
position when it came there by moves that all keep these rules; then the material that its cutter would touch
there is gone, or never was. Where an operation begins, or a tool was changed, for another or the same, it has
not been: nobody checked how it came there, and its first rapid must be clear.

Straight up. With C the cutter, let S be a solid that holds every point of C moved up by t, 0 < t <= s, that
is not in C, for some s > 0. Where S keeps clear of the stock on all of the way up, C does not meet material
on it: what C enters when it rises by t, S had left clear. Where no cylinder of the cutter is narrower than
the one below, S is any cylinder on top of it that is at least as wide: the body's, if it has one there,
which stays clear by the second rule; else a thin one of the cutter's own width, which is checked in its
place.

Straight down. To where the tool has been since it came to this X and Y: to no less than the lowest Z that it
had there.

What a control may leave the path by (G64) is no part of this: by as much it may touch the stock.

Where axes turn. A turn is straight neither up nor down, and after one the tool has been where it is then, and
nowhere else. A tool that its own axes have turned does not rise along itself: its rapids must be clear.

Of the objects of a machine file each two that move against each other must stay clear, always, but for those
that it says may touch; so must tool, workpiece and stock of each of them.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import combinations
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.host.motion.kinematics import Body, Meeting, Piece
from triaxis.host.motion.machine import STOCK, TOOL, WORKPIECE, Machine, Tool
from triaxis.host.motion.moves import Move, Program
from triaxis.host.motion.path_scene import PathScene, Wanted, prepare_path
from triaxis.host.quantise import NOWHERE, Vector, added, vector
from triaxis.host.stl import StlMesh

# What is checked of a tool: all of it, what does not cut, what does, and what is on top of that.
PARTS_OF_TOOL = ("the tool", "the tool's body", "the cutter", "the cutter's top")
NOT_TRACKED = (
    "the stock is as it is before the operation: what is cut away is not tracked, and whether the spindle "
    "turns is not known"
)


@dataclass(frozen=True)
class Rule:
    """Two objects, what they are called, and the moves on which they must stay clear of each other.

    ``numbers``: of these moves in the whole program. ``meeting``: how they move, where it is not that B stays
    where it is and A is where the program says; ``of_machine``: whether one is an object of a machine file.
    """

    names: tuple[str, str]
    a: StlMesh
    b: StlMesh
    files: tuple[str, str]
    program: Program
    numbers: Sequence[int]
    meeting: Meeting | None = None
    of_machine: bool = False

    @property
    def of_stock(self) -> bool:
        """Return whether it is what the tool must keep of the stock: its moves may begin within that."""
        return self.names[1] == f"the {STOCK}" and not self.of_machine

    def pieces(self, coarse: Fraction) -> Iterator[Piece]:
        """Yield the moves in pieces, as `Meeting.pieces` does."""
        moves = self.program.moves
        return (
            self.meeting.pieces(moves, coarse)
            if self.meeting
            else iter((Piece(self.a, self.b, moves, moves, 0),))
        )

    def scene(self, piece: Piece, wanted: Wanted) -> PathScene:
        """Return a piece on the grid; raise InputError where it does not fit."""
        program = replace(self.program, moves=piece.moves)
        return prepare_path(piece.a, piece.b, self.files, program, wanted)

    def standing(self, moves: tuple[Move, ...]) -> Iterator[Piece]:
        """Yield moves that stay where they are, instead of its own, in pieces between which nothing turns."""
        return replace(self, program=replace(self.program, moves=moves)).pieces(Fraction(0))

    def until(self, last: int) -> "Rule | None":
        """Return the rule for the moves up to one of the whole program; None where there is none."""
        count = sum(number <= last for number in self.numbers)
        moves = self.program.moves[:count]
        part = replace(self.program, moves=moves)
        return replace(self, program=part, numbers=self.numbers[:count]) if moves else None

    def among(self, first: int, count: int) -> "Rule | None":
        """Return the rule for so many moves, of which the first gets number 0; None where there is none."""
        chosen = [
            (number - first, move)
            for number, move in zip(self.numbers, self.program.moves, strict=True)
            if first <= number < first + count
        ]
        if not chosen:
            return None
        numbers, moves = zip(*chosen, strict=True)
        return replace(self, program=replace(self.program, moves=moves), numbers=numbers)


@dataclass(frozen=True)
class Setup:
    """What a part of a program is run with: one tool, in a machine, at millimetres per unit of STL files."""

    tool: Tool
    work: tuple[StlMesh, Path]
    stock: tuple[StlMesh, Path] | None = None
    machine: Machine = Machine()  # noqa: RUF009
    scale: Fraction = Fraction(1)

    def carried(self, name: str, mesh: StlMesh, file: str) -> Body:
        """Return a part of the tool, workpiece or stock as an object of the machine."""
        machine, nose = self.machine, self.machine.nose
        if name in (WORKPIECE, STOCK):
            return Body(name, mesh, file, added(nose, machine.offsets.get("G54", NOWHERE)), machine.table)
        tip = vector((nose[0], nose[1], nose[2] - (self.tool.length or 0)))
        return Body(name, mesh, file, tip, machine.spindle)

    def meeting(self, a: Body, b: Body) -> Meeting:
        """Return how two objects of the machine move against each other."""
        return Meeting.of(a, b, self.base, self.scale)

    @property
    def bodies(self) -> list[Body]:
        """Return the objects of the machine, and tool, workpiece and stock as such."""
        tool, work, stock = self.tool, self.work, self.stock
        carried = [self.carried(TOOL, tool.mesh, tool.name), self.carried(WORKPIECE, work[0], str(work[1]))]
        if stock is not None:
            carried.append(self.carried(STOCK, stock[0], str(stock[1])))
        return [*self.machine.objects, *carried]

    @property
    def base(self) -> Vector:
        """Return what the machine's coordinates are beyond those of the program."""
        zero = self.machine.offsets.get("G54", NOWHERE)
        return vector((zero[0], zero[1], zero[2] + (self.tool.length or 0)))

    def rules(self, program: Program, first: int) -> Iterator[Rule]:
        """Yield what must hold, on moves from the one with number ``first`` on, of objects of the machine.

        Of each two, and each and what they carry, that move against each other, but for those that may touch.
        """
        numbers = range(first, first + len(program.moves))
        for a, b in combinations(self.bodies, 2):
            meeting, may_touch = self.meeting(a, b), {a.name, b.name} in self.machine.may_touch
            if a in self.machine.objects and meeting.moving and not may_touch:
                names = f"the {a.name}", f"the {b.name}"
                yield Rule(names, a.mesh, b.mesh, (a.file, b.file), program, numbers, meeting, True)


def rules_of(setup: Setup, program: Program, first: int) -> list[Rule]:
    """Return what is to be checked of a part of a program, of which ``first`` moves precede.

    Raises InputError where there is a stock and nobody said what of the tool cuts.
    """
    tool, work, stock = setup.tool, setup.work, setup.stock

    def rule(what: str, mesh: StlMesh, of: str, other: tuple[StlMesh, Path], kept: Sequence[int]) -> Rule:
        moves, numbers = tuple(program.moves[k] for k in kept), [first + k for k in kept]
        part, files = replace(program, moves=moves), (tool.name, str(other[1]))
        meeting = None
        if setup.machine.rotary:
            bodies = setup.carried(TOOL, mesh, files[0]), setup.carried(of, other[0], files[1])
            meeting = setup.meeting(*bodies)
        return Rule((what, f"the {of}"), mesh, other[0], files, part, numbers, meeting)

    everything = range(len(program.moves))
    whole, body, cutter, top = PARTS_OF_TOOL
    found = [rule(whole, tool.mesh, WORKPIECE, work, everything)]
    found += setup.rules(program, first)
    if stock is None:
        return found
    if tool.cutter is None and tool.body is None:
        raise InputError(
            f"{tool.name}: --stock: nobody said what of it cuts: give its parts in a machine file, with "
            "cuts = true for those that do, or cuts = false"
        )
    if tool.body is not None:
        found.append(rule(body, tool.body, STOCK, stock, everything))
    if tool.cutter is None:
        return found
    rising, others = _rapids_into_stock(
        program.moves, [axis.number for axis in setup.machine.spindle if axis.rotary]
    )
    if tool.top is not None:
        found.append(rule(top, tool.top, STOCK, stock, rising))
    elif not tool.covered:
        others = sorted([*rising, *others])
    found.append(rule(cutter, tool.cutter, STOCK, stock, others))
    return [one for one in found if one.numbers]


def _rapids_into_stock(moves: Sequence[Move], tilting: Sequence[int]) -> tuple[list[int], list[int]]:
    """Return the rapids that go straight up, and all others but those to where the tool has been.

    ``tilting``: the axes that turn the tool.
    """
    rising, others = list[int](), list[int]()
    here: Vector | None = None
    # The lowest Z at which the tool has been since it came to this X and Y; none yet where it begins.
    low: Fraction | None = None
    changes = 0
    for number, move in enumerate(moves):
        if move.start != here or move.changes != changes:
            low = None
        changes = move.changes
        upright = move.curve is None and move.start[:2] == move.end[:2] and not move.turning
        upright = upright and not any(move.turns[0][k] for k in tilting)
        if move.rapid and upright and low is not None and move.end[2] >= move.start[2]:
            rising.append(number)
        elif move.rapid and not (upright and low is not None and move.end[2] >= low):
            others.append(number)
        # Where a feed begins the tool has been only where it is known how it came there.
        been = () if not upright else (low,) if low is not None else (move.start[2],) if move.rapid else ()
        low = min((*been, move.end[2]))
        here = move.end
    return rising, others
