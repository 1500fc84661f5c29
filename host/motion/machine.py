"""A machine: its tools, offsets, homes, the objects that it is of, and how its control moves."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property

from triaxis.host.motion.kinematics import Axis, Body
from triaxis.host.motion.moves import Move
from triaxis.host.quantise import NOWHERE, Vector
from triaxis.host.stl import StlMesh

# Degrees of one move.
_MOST_DEGREES = 3600
# What the objects of a machine carry.
TOOL, WORKPIECE, STOCK = CARRIED = ("tool", "workpiece", "stock")
SYSTEMS = ("G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3")


@dataclass(frozen=True)
class Tool:
    """A tool: its mesh, the tip at its origin, and its length; None where that is not known.

    Length and diameter are in millimetres, meshes are in the unit of STL files. ``cutter``, ``body``: what
    cuts, and what does not; neither where nobody said. ``covered``, ``top``: of a cutter of cylinders of
    which none is narrower than the one below: whether the body above it is at least as wide, and where it is
    not, a thin cylinder of its width on top of it (`contact`).
    """

    number: int
    mesh: StlMesh
    name: str
    length: Fraction | None = None
    diameter: Fraction | None = None
    cutter: StlMesh | None = None
    body: StlMesh | None = None
    covered: bool = False
    top: StlMesh | None = None


@dataclass(frozen=True)
class Machine:
    """A machine file. ``straight``: rapids are. ``loaded``, tolerances: None where it does not say.

    ``spindle``, ``table``: the axes that move tool and workpiece; ``nose``: where the spindle's is with all
    axes at 0. ``may_touch``: objects of which two are never looked at. ``assumed``: for a program's notes.
    """

    tools: Mapping[int, Tool] = field(default_factory=dict)
    offsets: Mapping[str, Vector] = field(default_factory=dict)
    homes: Mapping[str, Vector] = field(default_factory=dict)
    straight: bool = False
    tolerance: Fraction | None = None
    loaded: int | None = None
    turn_tolerance: Fraction | None = None
    objects: tuple[Body, ...] = ()
    spindle: tuple[Axis, ...] = ()
    table: tuple[Axis, ...] = ()
    nose: Vector = NOWHERE
    may_touch: frozenset[frozenset[str]] = frozenset()
    axes: tuple[Axis, ...] = ()
    assumed: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def rotary(self) -> frozenset[str]:
        """Return the letters of its axes that turn."""
        return frozenset(axis.letter for axis in self.axes if axis.rotary)

    def turned(self, move: Move, before: Sequence[Move], blended: Fraction) -> Move:
        """Return a move with how far axes that turn may be off; raise ValueError where nobody says it.

        ``blended``: how far, in millimetres, the control may leave the path, and mix it with those before.
        """
        if not self.rotary:
            return move
        if any(abs(b - a) > _MOST_DEGREES for a, b in zip(*move.turns, strict=True)):
            raise ValueError(f"turns by more than {_MOST_DEGREES} degrees: split it")
        turning = move.turning or (before and before[-1].turning)
        if self.turn_tolerance is None and blended and turning:
            raise ValueError(
                "turns axes while the control rounds corners: give turn_tolerance in the machine file, or G61"
            )
        return replace(move, turn_slack=move.turn_slack + (self.turn_tolerance or 0))
