"""Programs read by LinuxCNC's own interpreter: all that it understands, as moves of a tool.

``rs274`` (Debian's linuxcnc-uspace) runs a program and prints what a machine would be told, with four
decimals in the unit in force, which the slack of each move covers. Each line is given its number as N word,
so that moves know theirs. It thinks in inches: so do the offsets and the tool table that it is given. Where
a line changes the tool and its compensation it forgets the new tool's length until Z moves: as both are done
in turn, such a line is given as two. Comments of the program that print become plain ones. Numbered
parameters are given as named ones: of these it tells when one is read that has no value yet, where it would
take a number for what the last program left, or for 0.
"""

import math
import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.input_file import Place, read_input
from triaxis.host.engines import Progress, unwatched
from triaxis.host.motion.curves import SLACK, Curve, Turned, arc
from triaxis.host.motion.expression import ARGUMENTS, NO_VALUE, number
from triaxis.host.motion.gcode import AFTER_THE_END, BOTH_PLACES, CARRIAGE_RETURN, LINE_END
from triaxis.host.motion.interpreter import PALLET, RESTORES
from triaxis.host.motion.kinematics import ROTARY
from triaxis.host.motion.machine import SYSTEMS, Machine
from triaxis.host.motion.moves import Move, Program, assumed_start, assumed_state
from triaxis.host.motion.program import TOLD_AFTER, read_program
from triaxis.host.quantise import NOWHERE, Vector, added, vector

_PROGRAM = "rs274"
_INCH = Rational(254, 10)
# Seconds of the processor, and bytes printed: against loops without an end alone.
_LONGEST, _MOST_BYTES = 3600, 1 << 30
_NUMBER = re.compile(r"^(\s*/?)\s*(?:[Nn]\s*\d+)?", re.ASCII)
# Six digits of a line leave no blank before the call.
_CALL = re.compile(r"\s*\d+ N(\d+|\.+)\s*([A-Z][\w.]*)\((.*)\)\s*", re.ASCII)
# What it prints, by the names of files.
_PRINTED, _ERRORS = "printed.txt", "errors.txt"
_ENDLESS = (-signal.SIGXCPU, -signal.SIGXFSZ, -signal.SIGKILL)
_MOTION = re.compile(r"\b(STRAIGHT_|ARC_FEED|NURBS_FEED|RIGID_TAP)")
_ERROR = re.compile(r"^(?!executing|File ended).*\S", re.MULTILINE)
# Of the last decimal that is printed.
_HALF = Rational(1, 20000)
# The same of degrees, in radians and more.
_HALF_ANGLE = Rational(9, 10**7)
_NOT_TURNED = (
    "turns an axis that is none of the machine's: objects of a machine file say what A, B and C turn"
)
_OFFSETS = ("system", "shift", "compensation")
_PLANES = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
_REFUSED = {
    "STRAIGHT_PROBE": "ends where the part is, which nobody knows before: what follows cannot be checked",
    "ORIENT_SPINDLE": "orients the spindle, and so turns the tool, which is not followed",
}
_IGNORED = re.compile(
    r"(ENABLE|DISABLE|START|STOP|SET_(FEED|SPINDLE|AUX|TOOL|G54|MOTION_OUTPUT)|CLEAR|FLOOD|MIST|LOG|"
    r"TURN_PROBE|USE_SPINDLE)\w*|COMMENT|MESSAGE|DWELL|ON_RESET|PROGRAM_\w+|"
    r"OPTIONAL_PROGRAM_STOP|FINISH"
)


class _SplineError(Exception):
    """Of a spline the interpreter prints the end alone."""


@dataclass
class _Told:
    """What the interpreter has told: offsets, units, tool; and the moves that follow, in millimetres."""

    path: Path
    machine: Machine
    loaded: int | None = None
    unit: Fraction = Rational(1)  # noqa: RUF009
    # Zero of the system, G92, length compensation; and how far each printed number may be off.
    offsets: dict[str, Vector] = field(default_factory=lambda: dict.fromkeys(_OFFSETS, NOWHERE))
    errors: dict[str, Fraction] = field(default_factory=lambda: dict.fromkeys(_OFFSETS, Fraction(0)))
    angle: float = 0.0
    plane: str = "XY"
    tolerance: Fraction = Fraction(0)
    joined: Fraction = Fraction(0)
    blended: Fraction = Fraction(0)
    position: Vector | None = None
    # Of A, B and C, and their offsets: of the system, and G92.
    turned: Vector = NOWHERE
    turned_by: dict[str, Vector] = field(default_factory=dict[str, Vector])
    # Whether the program may turn systems; how far from their zero anything was, in X and Y together.
    turns: bool = False
    farthest: Fraction = Fraction(0)
    # The line of the last change of a tool; whether compensation has changed since the last move of Z.
    changed: int = -1
    numbered: bool = True
    stale: bool = False
    # How often a tool was changed; whether a T has been told.
    changes: int = 0
    chosen: bool = False
    # Lines that were given as two.
    split: frozenset[int] = frozenset()
    moves: list[Move] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)

    def told(self, line: int, call: str, text: str, numbered: bool) -> None:
        """Take a call; raise ValueError where it is not understood.

        ``line``: of the program, or of the call of another file, whose lines are not ``numbered``.
        """
        self.numbered = numbered
        if call == "NURBS_FEED":
            raise _SplineError
        if call in _REFUSED:
            raise ValueError(_REFUSED[call])
        if call == "USE_LENGTH_UNITS":
            self._set_unit(line, _INCH if "INCH" in text else Rational(1))
        elif call == "SELECT_PLANE":
            self.plane = text.rsplit("_", 1)[-1]
        elif call == "SET_XY_ROTATION":
            self.angle = math.radians(float(text))
        elif call == "SET_MOTION_CONTROL_MODE":
            self._path_mode(line, text)
        elif call == "SELECT_TOOL":
            self.chosen |= line > 0
        elif call == "PALLET_SHUTTLE":
            self.notes["pallet"] = f"line {line}: {PALLET}"
        elif call == "PROGRAM_END":
            # M30 changes the pallet, too, and nothing comes after it.
            if self.notes.get("pallet", "").startswith(f"line {line}: "):
                del self.notes["pallet"]
        elif call in ("CHANGE_TOOL", "CHANGE_TOOL_NUMBER"):
            if line and self.machine.tools and not self.chosen and call == "CHANGE_TOOL":
                raise ValueError("changes to the tool that the control has selected: give T before it")
            self.changes += call == "CHANGE_TOOL"
            self._change_tool(line, int(text))
        elif call in _CALLS:
            numbers = [
                number(part) if "-" not in part else -number(part[1:]) for part in re.split(r"[,\s]+", text)
            ]
            _CALLS[call](self, line, [value * self.unit for value in numbers], numbers)
        elif not _IGNORED.fullmatch(call):
            raise ValueError(f"{call} is not understood: see what it does, and whether it moves anything")

    def _set_unit(self, line: int, unit: Fraction) -> None:
        if unit != self.unit and any(self.offsets["compensation"]):
            raise ValueError("a change of units while G43 is in force, which it mistakes: give G49 before it")
        self.unit = unit
        if line and not self.moves:
            self.notes["units"] = ""

    def _path_mode(self, line: int, text: str) -> None:
        mode, *tolerance = text.split(", ")
        self.tolerance = Fraction(0)
        if all(move.rapid for move in self.moves):
            self.notes["path mode"] = ""
        if mode == "CANON_CONTINUOUS":
            given = number(tolerance[0])
            self.tolerance = (given + _HALF) * self.unit if given else given
            if not self.tolerance and self.machine.tolerance is None:
                raise ValueError(
                    "lets the control round corners: give P, or path_tolerance in a machine file"
                )
            self.tolerance = self.tolerance or self.machine.tolerance or Fraction(0)

    def _change_tool(self, line: int, row: int) -> None:
        """Take the row of the tool table, from 1 on, of the tool that is in the spindle now."""
        # Of moves with an empty spindle nothing is known, but by a tool 0.
        tools = [0 if 0 in self.machine.tools else None, *filter(None, self.machine.tools)]
        if self.machine.tools and not 0 <= row < len(tools):
            raise ValueError("changes to a tool that the machine file does not have: add it")
        tool = tools[row] if self.machine.tools else row
        if not self.machine.tools and (self.moves or "tool" in self.notes):
            raise ValueError("changes the tool, and so its shape: give a machine file with tools")
        if self.stale:
            why = "a change of the tool, after G43 or G49, without a move of Z between"
            raise ValueError(f"{why}: the interpreter mistakes where the tool is then; give one before it")
        taken = "how the machine moves to change tools is not checked"
        note = taken if self.machine.tools else "the tool is taken to be the one given"
        # Before its first position it is told what the machine file says.
        if self.position is not None:
            self.notes["tool"] = f"line {line}: {note}" if line else note
        self.loaded, self.changed = tool, line if self.numbered else -1

    def _set(self, name: str, line: int, values: list[Fraction], numbers: list[Fraction]) -> None:
        new = vector(values[:3])
        if name == "compensation" and any(numbers[3:]):
            raise ValueError("length compensation of more than X, Y and Z is not followed")
        if name == "compensation" and any(new) and self.machine.tools and not self.loaded:
            raise ValueError("compensation of an empty spindle, for which it takes the tool before: give G49")
        if name != "compensation":
            self.turned_by[name] = self._angles(numbers[3:])
        if name == "compensation":
            if line and self.numbered and line == self.changed and line not in self.split:
                raise ValueError("on a line with a change of the tool, which it mistakes: give the next line")
            self.stale |= new != self.offsets[name]
        self.offsets[name], self.errors[name] = new, _HALF * self.unit

    def _set_system(self, line: int, values: list[Fraction], numbers: list[Fraction]) -> None:
        system = SYSTEMS[int(numbers[0]) - 1]
        if system != "G54" and system not in self.machine.offsets:
            raise ValueError(f"where {system} has its zero, only the machine knows: give a machine file")
        self._set("system", line, values[1:], numbers[1:])

    def _joined(self, values: list[Fraction]) -> None:
        self.joined = values[0] + _HALF * self.unit if values[0] else values[0]

    def _place(self, position: list[Fraction], is_there: bool = True) -> Vector:
        """Return where the spindle's nose is, in the frame of WORK.stl, or where it never is."""
        x, y, z = (p + s for p, s in zip(position, self.offsets["shift"], strict=True))
        self.farthest = max(self.farthest, (abs(x) + abs(y)) * is_there)
        if self.angle:
            cos, sin = Fraction(math.cos(self.angle)), Fraction(math.sin(self.angle))
            x, y = (Rational(round(v * 10**9), 10**9) for v in (x * cos - y * sin, x * sin + y * cos))
        return vector(Rational(p + o) for p, o in zip((x, y, z), self._origin(), strict=True))

    def _straight(self, line: int, values: list[Fraction], numbers: list[Fraction], rapid: bool) -> None:
        self._go(line, self._place(values[:3]), rapid, turned=self._turned(numbers[3:]))

    def _turned(self, numbers: list[Fraction]) -> Vector:
        """Return A, B and C of the machine: as they were, where they differ by what is not printed alone."""
        new = added(self._angles(numbers), *self.turned_by.values())
        return vector(b if abs(a - b) <= 3 * _HALF else a for a, b in zip(new, self.turned, strict=True))

    def _angles(self, numbers: list[Fraction]) -> Vector:
        """Return A, B and C, which follow the other coordinates."""
        moving = [axis for axis, value in zip(ROTARY, numbers, strict=True) if value]
        if not self.machine.rotary.issuperset(moving):
            raise ValueError(_NOT_TURNED)
        return vector(numbers[:3])

    def _arc(self, line: int, values: list[Fraction], numbers: list[Fraction]) -> None:
        if self._turned(numbers[6:]) != self.turned:
            raise ValueError("an arc on which axes turn: write straight moves")
        axes = _PLANES[self.plane]
        end, centre = [Fraction(0)] * 3, [Fraction(0)] * 3
        for k, value in zip(axes, (values[0], values[1], values[5]), strict=True):
            end[k] = value
        for k, value in zip(axes, (values[2], values[3], values[5]), strict=True):
            centre[k] = value
        target, turns = self._place(end), int(numbers[4])
        assert self.position is not None
        # An arc in XY stays one when it is turned about z; of another what is turned is the arc.
        turned = self.angle if self.plane != "XY" else 0.0
        start, stop, middle = self.position, target, self._place(centre, False)
        if turned:
            start = self._before_turning(start)
            stop, middle = (added(vector(place), self.offsets["shift"]) for place in (end, centre))
        about = middle[axes[0]], middle[axes[1]]
        curve: Curve = arc(start, stop, axes, about, turns < 0, abs(turns), 4 * self._error())
        if turned:
            slack = curve.slack + 2 * SLACK
            curve = Turned(self.position, target, curve.bend, slack, curve, turned, self._origin())
        self._reach(curve)
        self._go(line, target, False, curve)

    def _reach(self, curve: Curve) -> None:
        """Take how far from the zero a curve comes, which its centre does not tell."""
        ends = [
            [abs(c - o) for c, o in zip(corner, self._origin(), strict=True)] for corner in curve.extent()
        ]
        self.farthest = max(self.farthest, *(x + y for x, _, _ in ends for _, y, _ in ends))

    def _origin(self) -> Vector:
        """Return where the zero of a system is that is turned, in the frame of WORK.stl."""
        zero = self.machine.offsets.get("G54", NOWHERE)
        parts = zip(self.offsets["system"], self.offsets["compensation"], zero, strict=True)
        return vector(Rational(s + c - o) for s, c, o in parts)

    def _before_turning(self, place: Vector) -> Vector:
        """Return a place of the frame of WORK.stl as a system sees it that is turned."""
        x, y, z = (float(p - o) for p, o in zip(place, self._origin(), strict=True))
        cos, sin = math.cos(self.angle), math.sin(self.angle)
        return vector(Fraction(round(c * 2**30), 2**30) for c in (x * cos + y * sin, y * cos - x * sin, z))

    def _tap(self, line: int, values: list[Fraction]) -> None:
        """Go down, and up again."""
        start = self.position
        self._go(line, self._place(values[:3]), False)
        assert start is not None
        self._go(line, start, False)

    def _error(self) -> Fraction:
        """Return how far a position may be off, for what was printed of it, of offsets and of an angle."""
        error = _HALF * self.unit + sum(self.errors.values(), Fraction(0))
        return error + self.farthest * _HALF_ANGLE if self.turns else error

    def _go(
        self, line: int, target: Vector, rapid: bool, curve: Curve | None = None, turned: Vector | None = None
    ) -> None:
        start, self.position = self.position, target
        turns = self.turned, turned or self.turned
        self.turned = turns[1]
        # The first goes to where the program begins.
        if start is None:
            return
        tools = self.machine.tools
        if tools and self.loaded is None:
            raise ValueError("no tool is in the spindle: change to one, or give `loaded` in the machine file")
        self.stale &= start[2] == target[2]
        tool = None if self.loaded is None else tools.get(self.loaded)
        length = tool.length if tool else None
        if length is None and any(self.offsets["compensation"]):
            raise ValueError("a move with length compensation, of a tool whose length is not known: give it")
        below = vector((Rational(0), Rational(0), -Rational(length or 0)))
        start, end = (added(p, below) for p in (start, target))
        # The centre of an arc moves all of it.
        printed = self._error() * (1 if curve is None else 3)
        tolerance = self.tolerance + self.joined
        blended, self.blended = max(tolerance, self.blended), tolerance
        slack = blended + printed + (curve.slack if curve is not None else 0)
        straight = curve is None and (not rapid or self.machine.straight)
        moved = curve.moved(below) if curve is not None else None
        move = Move(
            line, start, end, rapid, straight, moved, slack, self.loaded or 0, turns, 6 * _HALF, self.changes
        )  # fmt: skip
        self.moves.append(self.machine.turned(move, self.moves, blended))


_CALLS: dict[str, Callable[[_Told, int, list[Fraction], list[Fraction]], None]] = {
    "STRAIGHT_TRAVERSE": lambda to, line, values, numbers: to._straight(line, values, numbers, True),
    "STRAIGHT_FEED": lambda to, line, values, numbers: to._straight(line, values, numbers, False),
    "RIGID_TAP": lambda to, line, values, _: to._tap(line, values),
    "ARC_FEED": lambda to, line, values, numbers: to._arc(line, values, numbers),
    "SET_G5X_OFFSET": lambda to, line, values, numbers: to._set_system(line, values, numbers),
    "SET_G92_OFFSET": lambda to, line, values, numbers: to._set("shift", line, values, numbers),
    "USE_TOOL_LENGTH_OFFSET": lambda to, line, values, numbers: to._set(
        "compensation", line, values, numbers
    ),
    "SET_NAIVECAM_TOLERANCE": lambda to, _, values, __: to._joined(values),
}


def completes(path: Path, machine: Machine, seconds: int) -> bool:
    """Return whether the interpreter comes to the end of a program as it is, and moves anything.

    ``seconds`` of the processor that it takes at most; raises InputError where it is not installed.
    """
    _check_installed()
    with tempfile.TemporaryDirectory() as name:
        folder, given = Path(name), path.resolve()
        if _interpret(folder, machine, False, given, given.parent, seconds):
            return False
        with (folder / _PRINTED).open(errors="replace") as lines:
            return any(_MOTION.search(line) for line in lines)


def _check_installed() -> None:
    if shutil.which(_PROGRAM) is None:
        raise InputError(f"{_PROGRAM} is not installed: install linuxcnc-uspace, or leave --reader out")


def _interpret(
    folder: Path, machine: Machine, skip_optional: bool, given: Path, called: Path, seconds: int
) -> int:
    """Run the interpreter in a folder of its own, on what it is given; return its exit code.

    ``called``: where subroutines are. What it prints is in the folder.
    """
    (folder / "tools.tbl").write_text(_tool_table(machine))
    (folder / "offsets.var").write_text(_offsets(machine))
    (folder / "rs274.ini").write_text(f"[RS274NGC]\nSUBROUTINE_PATH = {called}\n")
    words = ["-b"] * skip_optional + ["-i", "rs274.ini", "-t", "tools.tbl", "-v", "offsets.var", str(given)]
    limits = [f"--cpu={seconds}:{seconds + 5}", f"--fsize={_MOST_BYTES}"]
    # It keeps its tools in the user's home, which a control that runs there, or another program that
    # is read, would share with it.
    with (folder / _PRINTED).open("w") as told, (folder / _ERRORS).open("w") as errors:
        return subprocess.run(
            ["prlimit", *limits, _PROGRAM, "-g", *words], cwd=folder, stdout=told, stderr=errors,
            check=False, env={**os.environ, "HOME": str(folder)},
        ).returncode  # fmt: skip


def read_by_rs274(
    path: Path, start: Vector | None, skip_optional: bool, machine: Machine, progress: Progress = unwatched
) -> Program:
    """Read a program as `program.read_program` does; raise InputError where the interpreter refuses it."""
    lines = _lines_of(path)
    _check_installed()
    turns, files = _refuse_unknown(path, lines, machine)
    named = _with_names({path: lines, **{file: _lines_of(file) for file in files}})
    lines = named.pop(path)
    x, y, z = (float(c) for c in start or NOWHERE)
    # Where it begins, with which tool; then no motion is in force. What waits at the end goes with M2.
    first = [f"N0 T{machine.loaded} M6"] if machine.loaded is not None else []
    first += [f"N0 G21 G90 G0 X{x:.9f} Y{y:.9f} Z{z:.9f}", "N0 G80"]
    given = [_split(_PRINTING.sub(r"\1-", line)) for line in lines]
    numbered = [
        _NUMBER.sub(rf"\g<1>N{count} ", line, count=1) if line.strip() else line
        for count, parts in enumerate(given, 1)
        # What another file holds has no numbers: a comment that is printed tells that it is called.
        for line in (*(["(MSG,)"] if _CALLED.search(_bare(parts[0])) else []), *_read_before(parts), *parts)
    ]
    body = [line for line in numbered if _PERCENT.fullmatch(line) is None]
    program = ["%", *first, *body, "N0 M2", "%", ""]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "called").mkdir()
        (folder / "program.ngc").write_text("\n".join(program))
        for file, text in named.items():
            bare = [part for line in text for part in (*_read_before([line]), line)]
            bare = [_NUMBER.sub(r"\g<1>", line, count=1) for line in bare]
            (folder / "called" / file.name).write_text("\n".join(bare))
        done = _interpret(folder, machine, skip_optional, Path("program.ngc"), Path("called"), _LONGEST)
        if done in _ENDLESS:
            most = f"within {_LONGEST} s, or {_MOST_BYTES >> 30} GB of moves"
            raise InputError(f"{path}: {_PROGRAM} did not end {most}: correct its loops")
        if done:
            raise _refusal(path, (folder / _ERRORS).read_text(errors="replace"))
        split = frozenset(count for count, parts in enumerate(given, 1) if len(parts) > 1)
        state = _Told(path, machine, machine.loaded, tolerance=machine.tolerance or Fraction(0), split=split)
        state.turns = turns
        with (folder / _PRINTED).open(errors="replace") as calls:
            spline = _take(state, calls, progress)
    if spline is not None:
        program = read_program(path, start, skip_optional, machine)
        note = f"line {spline}: a spline, which it does not print: the program was read without rs274"
        return replace(program, notes=(*program.notes, note))
    if not state.moves:
        raise InputError(f"{path}: no moves: a program with at least one G0 or G1 move is needed")
    if start is None:
        state.notes["start"] = assumed_start(state.moves)
    if any(line.lstrip().startswith("/") for line in lines):
        told = "left out" if skip_optional else "run"
        state.notes["optional"] = f"lines that begin with / are {told}"
    state.notes["state"] = assumed_state(_lines_of(path), state.moves)
    state.notes |= machine.assumed
    line = state.moves[0].line
    state.notes.setdefault("units", f"line {line}: no G20 or G21 before it: millimetres assumed")
    if machine.tolerance is None and not all(move.rapid for move in state.moves):
        told = "without G61 or G64 the path is taken for exactly followed"
        state.notes.setdefault("path mode", f"line {line}: {told}")
    changes = (state.loaded or 0) != state.moves[-1].tool
    return Program(path, tuple(state.moves), tuple(filter(None, state.notes.values())), changes)


def _refusal(path: Path, errors: str) -> InputError:
    """Return what the interpreter says of a program that it does not run to its end."""
    if (unset := _UNSET.search(errors)) is not None:
        name = f"#{unset[2] or unset[1]}"
        if unset[3]:
            return Place(path, int(unset[3])).error(name, NO_VALUE)
        return InputError(f"{path}: {name} {NO_VALUE}")
    told = _ERROR.findall(errors)
    return InputError(f"{path}: {_PROGRAM} refuses it: {' / '.join(told[-3:]) or 'no reason given'}")


def _take(state: _Told, calls: Iterable[str], progress: Progress) -> int | None:
    """Take calls, a line each; return the program's line of the first that is a spline, which ends it.

    ``progress`` is told of the program's lines. Raises InputError where a call is not understood.
    """
    line = done = 0
    for told in calls:
        match = _CALL.fullmatch(told)
        if match is None:
            if told.strip():
                what = f"{_PROGRAM} says {told.strip()[:40]!r}, which is not understood"
                raise InputError(f"{state.path}: {what}")
            continue
        # What stands in another file has no number: it is of the line before, which is that of the call.
        numbered = match[1].isdigit()
        line = int(match[1]) if numbered else line
        if line >= done + TOLD_AFTER:
            progress(line - done)
            done = line
        try:
            state.told(line, match[2], match[3], numbered)
        except ValueError as error:
            raise Place(state.path, line).error(match[2], str(error)) from error
        except _SplineError:
            return line
    return None


# What the interpreter would take for 0, in words that say that it is needed: of lines without blanks.
_ANY_WORD, _END = r"[gm][\[#]", r"(\.0*)?(?![\d.])"
# None of the patterns below knows a number that is written so, and nobody needs to.
_FUNCTION = "abs|acos|asin|atan|cos|exists|exp|fix|fup|ln|round|sin|sqrt|tan"
_SIGNED = re.compile(rf"[gml](?:[+-]|(?:{_FUNCTION})\[)")
_MACHINE_WORDS = re.compile(rf"g0*(53|28|30){_END}|g0*10{_END}(?=.*l0*2{_END}|.*l[\[#])|{_ANY_WORD}")
_HOMES = {name: re.compile(rf"g0*{name[1:]}{_END}|{_ANY_WORD}") for name in ("G28", "G30")}
_LENGTH_WORDS = re.compile(rf"g0*43(\.0*[12]?)?(?!\d)|g0*10{_END}(?=.*l0*1{_END}|.*l[\[#])|{_ANY_WORD}")
_RADIUS_WORDS = re.compile(rf"g0*4[12](\.0*1?)?(?!\d)|{_ANY_WORD}")
_ANY_HOME, _BY_LINEAR = re.compile(rf"g0*(28|30){_END}"), re.compile(r"(?!.*[abc])(?=.*[xyz]).*")
_CHANGES, _COMPENSATES = (re.compile(rf"{word}{_END}|{_ANY_WORD}") for word in ("m0*6", "g0*4[39]"))
_LOADING = re.compile(rf"m0*61{_END}|m[\[#]")
_BY_FIXTURE = re.compile(rf"g0*10{_END}(?=.*l0*11{_END}|.*l[\[#])|{_ANY_WORD}")
_SET_CONTROLS = re.compile(r"#(\d+)=")
# Lines of a program that is called by M98, which begin with its number; and what ends one.
_NUMBERED_PROGRAM, _ENDS_PROGRAM = re.compile(r"(?:n\d+)?o\d+$"), re.compile(rf"m0*99{_END}|m[\[#]")
_ENDS_ALL = re.compile(rf"m0*(2|30){_END}")
_RESTORING, _SHIFTING = re.compile(r"g0*92\.30*(?!\d)|g[\[#]"), re.compile(rf"g0*(92(\.10*)?|52){_END}")
_TURNS = re.compile(rf"g0*10{_END}|{_ANY_WORD}")
_READ_NAME = re.compile(r"#<[^>]*>(?!=)")
_READ, _SET_NAME = re.compile(r"#(\d+|<[^>]*>)(?!\d*=)"), re.compile(r"#(<[^>]*>)=")
# From which number on parameters are the control's; in a line without blanks, and in any line.
_CONTROLS, _NUMBERED = 5000, re.compile(r"#((?:\s*\d)+)", re.ASCII)
# Whether a name exists that all programs share hangs on those before; where it has a value it does.
_WORD_EXISTS = r"\s*".join("exists")
_EXISTS = re.compile(rf"{_WORD_EXISTS}\s*\[\s*(#\s*<\s*_[^>]*>)\s*\]", re.IGNORECASE)
# A number always does.
_EXISTS_NUMBER = re.compile(rf"{_WORD_EXISTS}\s*\[\s*#[\d\s]*\]", re.IGNORECASE | re.ASCII)
_FLOW = r"(?:n\d+)?o(?:<[^>]*>|\d+)"
_BOUNDS, _NO_BOUNDS = re.compile(rf"{_FLOW}(sub|endsub)"), re.compile(rf"^/{_FLOW}(sub|endsub)")
# An O word whose name is neither of letters nor plain digits.
_COMPUTED = re.compile(r"^/?(?:n\d+)?o(?!<[^>]*>|\d+(?:[a-z]|$))")
_NAME = re.compile(r"#<[^>]*>")
_FANUC = re.compile(rf"m(0*98{_END}|[\[#])")
_WHOSE = "an argument, in a program with M98 and O sub: of which call is not known: use #31 or more"
# What the interpreter says of a name without a value: the name, its number where it stands for one, the line.
_UNSET = re.compile(r"Named parameter #(<(?:_p+(\d+))?[^>]*>) not defined\s*(?:N(\d+) )?")
_INDIRECT = re.compile(r"#(?![\d<])|#\d+\.")
_ANY_FLOW = re.compile(r"/?(?:n\d+)?o")
_CALLED, _DEFINED = re.compile(r"o(<[^>]*>|\d+|[\[#]).*?call"), re.compile(r"o(<[^>]*>|\d+)sub")
# Of names that begin with _, those that mean the same on each machine; the others are the control's.
_NAMES = ("x", "y", "z", "metric", "imperial", "absolute", "incremental")
# Those of the control that no program can set, though a line may try (LinuxCNC's manual, G code: overview).
_SYSTEM_NAMES = (
    "vmajor vminor line motion_mode plane ccomp ijk_absolute_mode lathe_diameter_mode lathe_radius_mode "
    "inverse_time units_per_minute units_per_rev coord_system tool_offset retract_r_plane retract_old_z "
    "spindle_rpm_mode spindle_css_mode spindle_on spindle_cw mist flood speed_override feed_override "
    "adaptive_feed feed_hold feed rpm a b c u v w abs_x abs_y abs_z abs_a abs_b abs_c abs_u abs_v abs_w "
    "current_tool current_pocket selected_tool selected_pocket value value_returned task call_level "
    "remap_level"
)
_OTHERS = frozenset(f"<_{name}>" for name in _SYSTEM_NAMES.split())
_MEANT = frozenset(f"<_{name}>" for name in _NAMES)
# Words without expressions, after / and N; of these what changes the tool, and what sets compensation.
_VALUE = r"(?:[+-]?[\d.]+|#\d+|#<[^>]*>)"
_PLAIN = re.compile(rf"(\s*/?\s*)(?:[Nn]\s*\d+)?((?:\s*[A-Za-z]\s*{_VALUE})*)\s*", re.ASCII)
_WORD = re.compile(rf"[A-Za-z]\s*{_VALUE}", re.ASCII)
_CHANGE = re.compile(r"[Tt].*|[Mm]\s*0*6", re.ASCII)
_COMPENSATION = re.compile(r"[Gg]\s*0*4(3|9)", re.ASCII)
_PRINTING = re.compile(r"([(;]\s*)(?=print|debug|log|probe)", re.IGNORECASE)
_COMMENT, _PERCENT = re.compile(r"\([^)]*\)|;.*"), re.compile(r"\s*(?:N\d+\s*)?%\s*")


def _bare(line: str) -> str:
    """Return a line without comments and blanks, which the interpreter passes over within numbers, too."""
    return "".join(_COMMENT.sub("", line).split()).lower()


def _refuse_unknown(path: Path, lines: Sequence[str], machine: Machine) -> tuple[bool, list[Path]]:
    """Raise InputError at words for which the interpreter would take what it is not told for 0, and others
    that it mistakes; return whether any line may turn a system, and the files that are called.
    """
    tools = machine.tools.values()
    needed = [
        (_MACHINE_WORDS, "G54" not in machine.offsets,
         "needs machine coordinates: give the offset of G54 in a machine file"),
        *((words, name not in machine.homes, f"goes home: give {name} in a machine file")
          for name, words in _HOMES.items()),
        (_LENGTH_WORDS, not tools or any(tool.length is None for tool in tools),
         "needs the length of each tool: give all in a machine file"),
        (_RADIUS_WORDS, not tools or any(tool.diameter is None for tool in tools),
         "needs the diameter of each tool: give parts with diameters in a machine file"),
        (_LOADING, True, "its tool is not known to the interpreter: change tools with M6"),
        (_BY_FIXTURE, not {"G54", "G59.3"} <= machine.offsets.keys(),
         "sets a tool by the zero of G59.3: give the offsets of G54 and G59.3 in a machine file"),
        (_INDIRECT, True, "may be any parameter: name it, or leave --reader out"),
        (_COMPUTED, True, "an O word whose name is computed: name it, or leave --reader out"),
        (_NO_BOUNDS, True, "a subroutine that may be left out: begin its lines without /"),
    ]  # fmt: skip
    files, texts = [path], {path: [_bare(line) for line in lines]}
    for file in files:
        files += [more for more in _called(file, texts[file]) if more not in texts]
        texts |= {more: list(map(_bare, _lines_of(more))) for more in files if more not in texts}
    set_names = {name for text in texts.values() for line in text for name in _SET_NAME.findall(line)}
    for file, text in texts.items():
        shift_known = called = any_flow = False
        for count, line in enumerate(text, 1):
            words = _NAME.sub("#", line)
            if match := _SIGNED.search(re.sub("<[^>]*>", "<>", words)):
                why = "a number with a sign, or of a function, that says what is done: write the number alone"
                raise Place(file, count).error(match[0], why)
            for key in map(int, _SET_CONTROLS.findall(line)):
                if key >= _CONTROLS:
                    why = "sets what is the control's: say it by G10, or in a machine file"
                    raise Place(file, count).error(f"#{key}", why)
            if _RESTORING.search(words) and not shift_known:
                raise Place(file, count).error("G92.3", RESTORES)
            any_flow |= _ANY_FLOW.match(line) is not None
            # What a branch, a call or / may leave out says nothing.
            plain = file == path and not any_flow and line[:1] != "/"
            shift_known |= plain and _SHIFTING.search(words) is not None
            called |= "call" in line or file != path
            if file != path and _CHANGES.search(line) and _COMPENSATES.search(line):
                why = "with a change of the tool, in a file of its own, which it mistakes: give two lines"
                raise Place(file, count).error("G43", why)
            if machine.rotary and (home := _ANY_HOME.search(line)) and not _BY_LINEAR.fullmatch(line):
                why = "turns axes to where only the machine knows: name X, Y or Z, and no other"
                raise Place(file, count).error(home[0], why)
            for pattern, missing, why in needed:
                if missing and (match := pattern.search(line)):
                    raise Place(file, count).error(match[0], why)
            for name in _READ.findall(line):
                # Of numbers up to the control's own the interpreter tells (`_with_names`).
                free = name.isdigit() and (int(name) < _CONTROLS or 5420 <= int(name) <= 5422)
                known = name in _MEANT or (name in set_names and name not in _OTHERS)
                # The last value that a subroutine has returned, of this program once it has called one.
                if not (known or free or (name == "<_value>" and called)):
                    raise Place(file, count).error(f"#{name}", NO_VALUE)
    _refuse_beginning_anew(path, texts[path])
    ends = [count for count, line in enumerate(texts[path], 1) if line == "%"]
    closed = ends[1] if len(ends) > 1 else ends[0] if ends and any(texts[path][: ends[0] - 1]) else None
    for count, line in enumerate(texts[path], 1):
        if closed is not None and count > closed and line:
            raise Place(path, count).error(line[:20], AFTER_THE_END)
    return any(_TURNS.search(line) for text in texts.values() for line in text), files[1:]


def _refuse_beginning_anew(path: Path, lines: Sequence[str]) -> None:
    """Raise InputError where M99 may end the program itself, which a control then runs again for ever."""
    ended = called = False
    for count, line in enumerate(lines, 1):
        ended |= _ENDS_ALL.search(line) is not None
        # A number that stands before the program's end may be its own.
        called |= ended and _NUMBERED_PROGRAM.match(line) is not None
        if not called and (match := _ENDS_PROGRAM.search(_NAME.sub("#", line))):
            why = "begins the program anew, for ever: end it with M2, and begin what M98 calls after that"
            raise Place(path, count).error(match[0], why)


def _with_names(texts: Mapping[Path, Sequence[str]]) -> dict[Path, list[str]]:
    """Return files with names in place of the numbers of parameters, but for arguments of subroutines.

    Raises InputError where it is not known whose arguments numbers are.
    """
    if not any("#" in line for text in texts.values() for line in text):
        return {file: list(text) for file, text in texts.items()}
    bare = {file: list(map(_bare, text)) for file, text in texts.items()}
    every = [line for text in bare.values() for line in text]
    prefix = "_p"
    while any(f"<{prefix}" in line for line in every):
        prefix += "p"
    # M98 calls lines that stand in no subroutine, with the arguments of whoever calls.
    unclear = any(map(_FANUC.search, every)) and any(map(_BOUNDS.match, every))
    named = dict[Path, list[str]]()
    for file, text in texts.items():
        within, lines = False, list[str]()
        for count, (line, bare_line) in enumerate(zip(text, bare[file], strict=True), 1):
            bound = _BOUNDS.match(bare_line)
            within |= bound is not None and bound[1] == "sub"
            numbers = map(int, _NUMBERED.findall(bare_line)) if unclear and not within else ()
            if any(1 <= number <= ARGUMENTS for number in numbers):
                raise Place(file, count).error("#", _WHOSE)
            lines.append(_with_name(line, prefix, within))
            within &= bound is None or bound[1] == "sub"
        named[file] = lines
    return named


def _with_name(line: str, prefix: str, within: bool) -> str:
    """Return a line with names; ``within`` a subroutine, whose arguments keep their numbers."""

    def name(match: re.Match[str]) -> str:
        key = int("".join(match[1].split()))
        kept = key >= _CONTROLS or (within and key <= ARGUMENTS) or not key
        return match[0] if kept else f"#<{prefix}{key}>"

    at, parts = 0, list[str]()
    for comment in (*_COMMENT.finditer(line), None):
        code = line[at : comment.start()] if comment else line[at:]
        code = _EXISTS_NUMBER.sub("[1]", _EXISTS.sub(r"[1+0*\1]", code))
        parts += [_NUMBERED.sub(name, code), comment[0] if comment else ""]
        at = comment.end() if comment else len(line)
    return "".join(parts)


def _read_before(lines: Sequence[str]) -> list[str]:
    """Return a line that reads what others, given for one, both set and read, where there is any.

    On its own line a name that is set has a value already: 0. The number in it is no parameter's any more.
    """
    bare = "".join(map(_bare, lines)) if any("=" in line for line in lines) else ""
    names = {f"#{name}" for name in _SET_NAME.findall(bare)} & set(_READ_NAME.findall(bare))
    if not names:
        return []
    return [f"{'/' * bare.startswith('/')}#{_CONTROLS - 1}=[0*[{'+'.join(sorted(names))}]]"]


def _split(line: str) -> list[str]:
    """Return a line; the change of the tool by itself, and the rest, where it sets compensation, too."""
    begin, words = _PLAIN.fullmatch(_COMMENT.sub("", line)), list[str]()
    if begin is not None:
        words = _WORD.findall(begin[2])
    changing = [word for word in words if _CHANGE.fullmatch(word)]
    if not any(_CHANGE.fullmatch(word) and word[0] in "Mm" for word in words) or not any(
        _COMPENSATION.fullmatch(word) for word in words
    ):
        return [line]
    assert begin is not None
    return [f"{begin[1]}{' '.join(part)}" for part in (changing, [w for w in words if w not in changing])]


def _lines_of(path: Path) -> list[str]:
    lines = LINE_END.split(read_input(path).decode("utf-8", errors="replace").rstrip("\r"))
    for count, line in enumerate(lines, 1):
        if "\r" in line:
            raise Place(path, count).error(line.split("\r")[0][-20:].strip(), CARRIAGE_RETURN)
    return lines


def _called(path: Path, lines: Sequence[str]) -> list[Path]:
    """Return the files beside a program of subroutines that it calls and does not hold."""
    text = "\n".join(lines)
    defined, names = set(_DEFINED.findall(text)), set(_CALLED.findall(text))
    if names & {"[", "#"}:
        raise InputError(f"{path}: calls a subroutine whose name is computed: name it, or leave --reader out")
    files = {name: path.parent / f"{name.strip('<>')}.ngc" for name in sorted(names)}
    here = {name: file for name, file in files.items() if file.exists()}
    for name in here.keys() & defined:
        # A control takes what it has come by, and else the file.
        calls, bounds = (
            [count for count, line in enumerate(lines, 1) if name in words.findall(line)]
            for words in (_CALLED, _DEFINED)
        )
        if calls[0] < bounds[0]:
            raise Place(path, calls[0]).error(f"O{name}", BOTH_PLACES.format(here[name].name))
    return [file for name, file in here.items() if name not in defined]


def _tool_table(machine: Machine) -> str:
    return "".join(
        f"T{tool.number} P{tool.number} Z{float((tool.length or 0) / _INCH):.12f} "
        f"D{float((tool.diameter or 0) / _INCH):.12f} ;\n"
        for tool in machine.tools.values()
        if tool.number
    )


def _offsets(machine: Machine) -> str:
    places = {5161: machine.homes.get("G28"), 5181: machine.homes.get("G30"), 5211: None}
    places |= {5221 + 20 * k: machine.offsets.get(name) for k, name in enumerate(SYSTEMS)}
    rows = {5220: 1.0}
    for first, place in places.items():
        values = [float(c / _INCH) for c in place or NOWHERE] + [0.0] * 3
        rows |= dict(enumerate(values, first))
    return "".join(f"{key}\t{value:.12f}\n" for key, value in sorted(rows.items()))
