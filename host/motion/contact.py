"""What must stay clear of what while a program runs: cutting is allowed, crashing is not.

Without a stock, the tool must stay clear of the workpiece, always. With one, the workpiece is what nothing
may touch, and

    the tool            stays clear of the workpiece on all moves,
    the tool's body     (what does not cut: shank, holder) of the stock on all moves,
    the cutter          of the stock on rapids, but for those that go where nothing can be left.

The stock is taken as it is before the operation; what was cut away is not tracked. So a rapid out of a cut
begins within the stock, and the rule for it is one of geometry alone. Say that a tool has *been* at a
position when it came there by moves that all keep these rules; then the material that its cutter would touch
there is gone, or never was. Where an operation begins it has not been: nobody checked how it came there, and
its first rapid must be clear.

Straight up. With C the cutter, let S be a solid that holds every point of C moved up by t, 0 < t <= s, that
is not in C, for some s > 0. Where S keeps clear of the stock on all of the way up, C does not meet material
on it: what C enters when it rises by t, S had left clear. Where no cylinder of the cutter is narrower than
the one below, S is any cylinder on top of it that is at least as wide: the body's, if it has one there,
which stays clear by the second rule; else a thin one of the cutter's own width, which is checked in its
place.

Straight down. To where the tool has been since it came to this X and Y: to no less than the lowest Z that it
had there.

What a control may leave the path by (G64) is no part of this: by as much it may touch the stock.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.host.motion.machine import Tool
from triaxis.host.motion.moves import Move, Program
from triaxis.host.quantise import Vector
from triaxis.host.stl import StlMesh

NOT_TRACKED = (
    "the stock is as it is before the operation: what is cut away is not tracked, and whether the spindle "
    "turns is not known"
)


@dataclass(frozen=True)
class Rule:
    """Two objects, what they are called, and the moves on which they must stay clear of each other.

    ``numbers``: of these moves in the whole program.
    """

    names: tuple[str, str]
    a: StlMesh
    b: StlMesh
    files: tuple[str, str]
    program: Program
    numbers: Sequence[int]

    def until(self, last: int) -> "Rule | None":
        """Return the rule for the moves up to one of the whole program; None where there is none."""
        count = sum(number <= last for number in self.numbers)
        moves = self.program.moves[:count]
        return replace(self, program=replace(self.program, moves=moves)) if moves else None


def rules_of(
    tool: Tool, work: tuple[StlMesh, Path], stock: tuple[StlMesh, Path] | None, program: Program, first: int
) -> list[Rule]:
    """Return what is to be checked of a part of a program with one tool, of which ``first`` moves precede.

    Raises InputError where there is a stock and nobody said what of the tool cuts.
    """

    def rule(what: str, mesh: StlMesh, of: str, other: tuple[StlMesh, Path], kept: Sequence[int]) -> Rule:
        moves, numbers = tuple(program.moves[k] for k in kept), [first + k for k in kept]
        part = replace(program, moves=moves)
        return Rule((what, of), mesh, other[0], (tool.name, str(other[1])), part, numbers)

    everything = range(len(program.moves))
    found = [rule("the tool", tool.mesh, "the workpiece", work, everything)]
    if stock is None:
        return found
    if tool.cutter is None and tool.body is None:
        raise InputError(
            f"{tool.name}: --stock: nobody said what of it cuts: give its parts in a machine file, with "
            "cuts = true for those that do, or cuts = false"
        )
    if tool.body is not None:
        found.append(rule("the tool's body", tool.body, "the stock", stock, everything))
    if tool.cutter is None:
        return found
    rising, others = _rapids_into_stock(program.moves)
    if tool.top is not None:
        found.append(rule("the cutter's top", tool.top, "the stock", stock, rising))
    elif not tool.covered:
        others = sorted([*rising, *others])
    found.append(rule("the cutter", tool.cutter, "the stock", stock, others))
    return [one for one in found if one.numbers]


def _rapids_into_stock(moves: Sequence[Move]) -> tuple[list[int], list[int]]:
    """Return the rapids that go straight up, and all others but those to where the tool has been."""
    rising, others = list[int](), list[int]()
    here: Vector | None = None
    # The lowest Z at which the tool has been since it came to this X and Y; none yet where it begins.
    low: Fraction | None = None
    for number, move in enumerate(moves):
        if move.start != here:
            low = None
        upright = move.curve is None and move.start[:2] == move.end[:2]
        if move.rapid and upright and low is not None and move.end[2] >= move.start[2]:
            rising.append(number)
        elif move.rapid and not (upright and low is not None and move.end[2] >= low):
            others.append(number)
        low = min(move.start[2] if low is None else low, move.end[2]) if upright else move.end[2]
        here = move.end
    return rising, others
