"""The machine file, which says what a program does not: tools, offsets, homes, what carries and moves what.

    path_tolerance = 0.01        # mm that a control leaves the path where it rounds corners (G64)
    turn_tolerance = 0.01        # degrees that A, B, C may be off
    rapids = "straight"          # G0 is a straight line; else each axis takes its own time
    loaded = 1                   # the tool in the spindle at the start
    [offsets]                    # machine coordinates of the zero of G54 (WORK.stl's), G55, ..
    G54 = [300.0, 200.0, -150.0]
    [homes]                      # machine coordinates to which G28 and G30 go
    G28 = [0.0, 0.0, 0.0]
    [[tools]]
    number = 1                   # 0: the spindle without a tool
    length = 82.5                # mm from the spindle's nose to the origin of the STL, the tip: what G43 adds
    mesh = "mill.stl"            # or parts, from the tip on
    parts = [{ diameter = 6, length = 20, cuts = true }, { diameter = 20, length = 45 },
             { mesh = "holder.stl" }]
    [[objects]]                  # what the machine is of (`kinematics`), what carries others before them
    name = "table"
    on = "saddle"                # what carries it; left out where it stands still, or moves on that
    axis = "-X"                  # by which it moves there: here against X; A, B, C turn it
    pivot = [0.0, 0.0, 0.0]      # a point of the line about which it turns, for A, B, C
    mesh = "table.stl"           # left out where it has none that could touch anything
    at = [0.0, 80.0, 0.0]        # where the mesh's origin is with all axes at 0
    may_touch = ["saddle"]       # with what it is in contact; also "workpiece", "stock", "tool"
    [spindle]
    on = "head"
    nose = [0.0, 0.0, 150.0]     # where it is with all axes at 0
    [workpiece]
    on = "table"

Parts are in the unit of the STL files. Those that cut may touch a stock while the tool feeds (`contact`).
"""

import re
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from math import cos, pi
from pathlib import Path
from typing import Any

import numpy as np

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.host.motion.kinematics import LINEAR, ROTARY, Axis, Body, signs
from triaxis.host.motion.machine import CARRIED, SYSTEMS, Machine, Tool
from triaxis.host.quantise import NOWHERE, Vector, vector
from triaxis.host.scenes import revolved
from triaxis.host.stl import StlMesh, read_stl

_DIGITS = 15
_DECIMAL = re.compile(rf"[+-]?(?=.{{1,{_DIGITS + 1}}}$)\d*\.?\d*")
# Millimetres, beyond which no machine goes.
_LARGEST = 10**6
# Of a tool's height, what is no difference.
_HEIGHT = 1e-4
# Sides of a prism around a cylinder, which is in it.
_SIDES = 64
# Of what stands in messages, and takes time that grows with its square.
_LONGEST_LINE = 1000
# Parts of its diameter that a cutter's top is thick.
_THIN = 64


def read_machine(path: Path, scale: Fraction = Fraction(1)) -> Machine:
    """Read a machine file and the meshes of its tools; raise InputError at whatever is not understood.

    ``scale``: millimetres per unit of STL files, and of the parts of tools.
    """
    try:
        text = read_input(path).decode("utf-8-sig")
        for number, line in enumerate(text.splitlines(), 1):
            if len(line) > _LONGEST_LINE:
                raise InputError(f"{path}: line {number}: more than {_LONGEST_LINE} characters: shorten it")
        content = tomllib.loads(text, parse_float=_decimal)
    except InputError:
        raise
    except RecursionError as error:
        raise InputError(f"{path}: no TOML: tables or lists in others, too many: write it flat") from error
    except ValueError as error:
        raise InputError(f"{path}: no TOML: {error}") from error
    table = _Table(path, "", content)
    rapids = table.take("rapids", str, "any")
    if rapids not in ("any", "straight"):
        raise table.wrong("rapids", '"straight" or "any"')
    tolerance = table.take("path_tolerance", Fraction, None)
    if tolerance is not None and tolerance < 0:
        raise table.wrong("path_tolerance", "not negative")
    offsets = _places(table, "offsets", SYSTEMS)
    homes = _places(table, "homes", ("G28", "G30"))
    tools: dict[int, Tool] = {}
    for number, entry in enumerate(table.take("tools", list, []), 1):
        tool = _tool(_Table(path, f"tool {number}: ", entry), scale)
        if tool.number in tools:
            raise InputError(f"{path}: tool number {tool.number} stands twice: keep one")
        tools[tool.number] = tool
    if not tools:
        raise table.wrong("tools", "given, one at least")
    loaded = table.take("loaded", int, next(iter(tools)) if len(tools) == 1 else None)
    if loaded is not None and loaded not in tools:
        raise table.wrong("loaded", f"the number of a tool ({', '.join(map(str, tools))})")
    machine = Machine(tools, offsets, homes, rapids == "straight", tolerance, loaded)
    machine = _with_objects(table, machine, scale)
    table.finish()
    return machine


def _decimal(text: str) -> Fraction:
    """Return a number as it stands; raise ValueError where no length of a machine is it."""
    if not _DECIMAL.fullmatch(text):
        raise ValueError(f"{text[:20]}: a decimal number of at most {_DIGITS} digits is needed")
    return Fraction(text)


@dataclass
class _Table:
    """A table of the file, of which entries are taken until none is left."""

    path: Path
    name: str
    content: Any

    def __post_init__(self) -> None:
        if not isinstance(self.content, dict):
            raise InputError(f"{self.path}: {self.name}a table is needed")
        self.content = dict(self.content)

    def take(self, key: str, kind: type, default: Any) -> Any:
        value = self.content.pop(key, default)
        if kind is Fraction and isinstance(value, int) and not isinstance(value, bool):
            value = Fraction(value)
        if isinstance(value, (int, Fraction)) and abs(value) > _LARGEST:
            raise self.wrong(key, f"at most {_LARGEST:g}")
        if value is not default and (
            not isinstance(value, kind) or isinstance(value, bool) != (kind is bool)
        ):
            wanted = {
                Fraction: "a number", int: "a whole number", list: "a list", str: "a text",
                bool: "true or false", dict: "a table",
            }  # fmt: skip
            raise self.wrong(key, wanted[kind])
        return value

    def wrong(self, key: str, wanted: str) -> InputError:
        return InputError(f"{self.path}: {self.name}{key!r}: must be {wanted}: correct it")

    def finish(self) -> None:
        for key in self.content:
            raise InputError(f"{self.path}: {self.name}{key!r}: not known: correct or remove it")


def _place(table: _Table, key: str) -> Vector | None:
    numbers = table.take(key, list, None)
    if numbers is None:
        return None
    fits = [isinstance(x, (int, Fraction)) and not isinstance(x, bool) for x in numbers]
    if len(numbers) != 3 or not all(fits) or max(abs(x) for x in numbers) > _LARGEST:
        raise table.wrong(key, f"three numbers of at most {_LARGEST:g}")
    return vector(map(Fraction, numbers))


def _places(table: _Table, name: str, keys: tuple[str, ...]) -> dict[str, Vector]:
    content = table.take(name, dict, {})
    if dotted := [key for key, value in content.items() if isinstance(value, dict)]:
        raise table.wrong(name, f'of keys in quotes where these have a point, as in "{dotted[0]}.1" = [..]')
    inner = _Table(table.path, f"{name}: ", content)
    found: dict[str, Vector] = {}
    for key in keys:
        place = _place(inner, key)
        if place is not None:
            found[key] = place
    inner.finish()
    return found


def _tool(table: _Table, scale: Fraction) -> Tool:
    number, length = table.take("number", int, None), table.take("length", Fraction, None)
    if number is None or number < 0:
        raise table.wrong("number", "given, and 1 or more, or 0 for an empty spindle")
    if length is not None and (length < 0 or (length and not number)):
        raise table.wrong("length", "not negative, and 0 of an empty spindle")
    parts, mesh = table.take("parts", list, []), table.take("mesh", str, None)
    if bool(parts) == bool(mesh):
        raise table.wrong("mesh", "given, or parts, and not both")
    table.finish()
    name = mesh or f"tool {number}"
    found: list[_Part] = []
    for entry in parts or [{"mesh": mesh}]:
        found.append(_part(_Table(table.path, f"{table.name}parts: ", entry), found))
    whole, cutter, body = (
        _joined([part.mesh for part in found if part.cuts in kinds])
        for kinds in ((False, True), (True,), (False,))
    )
    assert whole is not None
    diameter = next((part.diameter * scale for part in found if part.diameter), None)
    if not any(part.said for part in found):
        body = None
    tool = Tool(number, whole, name, length, diameter, cutter, body)
    if cutter is None or [part.cuts for part in found] != sorted((part.cuts for part in found), reverse=True):
        return tool
    edges = [part for part in found if part.cuts]
    if not all(part.diameter for part in edges) or any(b.diameter < a.diameter for a, b in pairwise(edges)):
        return tool
    above, widest = found[len(edges) :], edges[-1].diameter
    if above and above[0].diameter >= widest:
        return replace(tool, covered=True)
    height = sum((part.height for part in edges), Fraction(0))
    return replace(tool, top=_cylinder(widest, height, widest / _THIN))


@dataclass(frozen=True)
class _Part:
    """A part of a tool; height and diameter are 0 where it is a mesh. ``said``: whether it cuts, that is."""

    mesh: StlMesh
    cuts: bool
    said: bool
    height: Fraction = Fraction(0)
    diameter: Fraction = Fraction(0)


def _part(part: _Table, below: Sequence[_Part]) -> _Part:
    """Return the next part of a tool, on those below it."""
    mesh, cuts = part.take("mesh", str, None), part.take("cuts", bool, None)
    said, cuts = cuts is not None, bool(cuts)
    if mesh is not None:
        if not mesh.isprintable():
            raise part.wrong("mesh", "the name of a file")
        found = _Part(read_stl(part.path.parent / mesh), cuts, said)
    else:
        diameter, tall = (part.take(key, Fraction, Fraction(0)) for key in ("diameter", "length"))
        if diameter <= 0 or tall <= 0:
            raise part.wrong("diameter and length", "positive, or a mesh given")
        if not all(one.height for one in below):
            raise part.wrong("diameter", "of a cylinder below all meshes, whose heights are not known")
        foot = sum((one.height for one in below), Fraction(0))
        found = _Part(_cylinder(diameter, foot, tall), cuts, said, tall, diameter)
    part.finish()
    return found


def _cylinder(diameter: Fraction, foot: Fraction, height: Fraction) -> StlMesh:
    """Return a prism around an upright cylinder."""
    radius = float(diameter) / 2 / cos(pi / _SIDES) * (1 + 1e-6)
    low, high = float(foot), float(foot + height)
    profile = [(0.0, low), (radius, low), (radius, high), (0.0, high)]
    # Heights become float32.
    return StlMesh(revolved(profile, _SIDES).astype(np.float64), (foot + height) / 2**23)


def _joined(meshes: Sequence[StlMesh]) -> StlMesh | None:
    if not meshes:
        return None
    return StlMesh(np.concatenate([one.facets for one in meshes]), max(one.rounding for one in meshes))


def _with_objects(table: _Table, machine: Machine, scale: Fraction) -> Machine:
    """Return the machine with what carries what."""
    tolerance = table.take("turn_tolerance", Fraction, None)
    if tolerance is not None and tolerance < 0:
        raise table.wrong("turn_tolerance", "not negative")
    chains: dict[str, tuple[Axis, ...]] = {}
    bodies, touching = list[Body](), list[tuple[_Table, str, str]]()
    for number, entry in enumerate(table.take("objects", list, []), 1):
        inner = _Table(table.path, f"object {number}: ", entry)
        name = inner.take("name", str, "")
        if not name.isprintable() or not name or name in (*chains, *CARRIED):
            raise inner.wrong("name", "given, and no other's")
        inner.name = f"object {number}, {name}: "
        chain = (*_carried(inner, chains, False), *_axes(inner, name))
        if any(before.rotary and not axis.rotary for before, axis in pairwise(chain)):
            raise inner.wrong("axis", "A, B or C: nothing that turns carries linear axes")
        if len({axis.letter for axis in chain}) < len(chain):
            raise inner.wrong("axis", "another: what carries it moves by this one")
        chains[name] = chain
        mesh, at = inner.take("mesh", str, None), _place(inner, "at")
        if mesh is None and at is not None:
            raise inner.wrong("at", "of a mesh: give that, too")
        if mesh is not None:
            if not mesh.isprintable():
                raise inner.wrong("mesh", "the name of a file")
            file = table.path.parent / mesh
            bodies.append(Body(name, read_stl(file), str(file), at or NOWHERE, chain))
        touching += [(inner, name, other) for other in inner.take("may_touch", list, [])]
        inner.finish()
    spindle, workpiece = (
        _Table(table.path, f"{name}: ", table.take(name, dict, {})) for name in ("spindle", "workpiece")
    )
    carrying = _carried(spindle, chains, bool(chains)), _carried(workpiece, chains, bool(chains))
    nose = _place(spindle, "nose")
    spindle.finish()
    workpiece.finish()
    if bool(chains) != (nose is not None):
        raise spindle.wrong("nose", "given where there are objects, and there alone")
    for inner, name, other in touching:
        if other == name:
            raise inner.wrong("may_touch", "of others")
        if other not in (*chains, *CARRIED):
            raise inner.wrong("may_touch", f"of {', '.join((*chains, *CARRIED))}, not {other!r}")
    pairs = frozenset(frozenset((name, other)) for _, name, other in touching)
    found = replace(
        machine, turn_tolerance=tolerance, objects=tuple(bodies), spindle=carrying[0], table=carrying[1],
        nose=nose or NOWHERE, may_touch=pairs,
        axes=tuple({axis: None for chain in chains.values() for axis in chain}),
    )  # fmt: skip
    if chains:
        _check_axes(table.path, found)
    return replace(found, assumed=_assumed(found, scale))


def _axes(table: _Table, name: str) -> tuple[Axis, ...]:
    """Return the axis that moves an object where it is carried, if one does."""
    axis, pivot = table.take("axis", str, None), _place(table, "pivot")
    if axis is None:
        if pivot is not None:
            raise table.wrong("pivot", "of an axis: give A, B or C")
        return ()
    letter = axis.removeprefix("-")
    if len(letter) != 1 or letter not in LINEAR + ROTARY:
        raise table.wrong("axis", "X, Y, Z, A, B or C, or -X, ..")
    if (letter in ROTARY) != (pivot is not None):
        raise table.wrong("pivot", "given for A, B and C, and for these alone")
    return (Axis(name, letter, -1 if axis.startswith("-") else 1, pivot or NOWHERE),)


def _assumed(machine: Machine, scale: Fraction) -> dict[str, str]:
    """Return what nobody can tell to be wrong: senses of turns, and where tools end."""
    found: dict[str, str] = {}
    hands = {1: "right-handed about", -1: "left-handed about"}
    told = [
        f"{axis.letter} turns the {axis.of} {hands[axis.sign]} {'xyz'[axis.number]}"
        for axis in machine.axes
        if axis.rotary
    ]
    if told:
        start = "from 0 at the start, which is assumed, and by their numbers, no shorter way round"
        found["turned"] = f"{', '.join(told)}; {start}"
    for tool in machine.tools.values() if machine.axes else ():
        top = float(tool.mesh.facets[..., 2].max()) * float(scale)
        # Heights are float32.
        if tool.number and tool.length is not None and abs(top - float(tool.length)) > _HEIGHT * top:
            nose = f"the spindle's nose is at {float(tool.length):g}"
            found[f"tool {tool.number}"] = f"{tool.name}: ends {top:g} mm above its tip, and {nose}"
    return found


def _carried(table: _Table, chains: Mapping[str, tuple[Axis, ...]], needed: bool) -> tuple[Axis, ...]:
    """Return the axes that move what carries something."""
    on = table.take("on", str, None)
    if on is None and not needed:
        return ()
    if on is None or on not in chains:
        raise table.wrong("on", f"an object that stands before it ({', '.join(chains) or 'none does'})")
    return chains[on]


def _check_axes(path: Path, machine: Machine) -> None:
    """Raise InputError unless X, Y and Z move the tool as they should, as the workpiece sees it."""
    for letter, tool, work in zip(LINEAR, signs(machine.spindle), signs(machine.table), strict=True):
        if tool - work != 1:
            raise InputError(
                f"{path}: objects: by {letter} the tool, seen from the workpiece, does not move as the "
                f"program says: give one object on its side the axis {letter}, or one on the other -{letter}"
            )
    if "G54" not in machine.offsets:
        raise InputError(
            f"{path}: objects: where the program's zero is among them, G54 says: give its offset"
        )
    for tool in machine.tools.values():
        if tool.length is None:
            raise InputError(
                f"{path}: tool {tool.number}: with objects the length of each is needed: give it"
            )
