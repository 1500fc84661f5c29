"""Programs read by LinuxCNC's own interpreter: all that it understands, as moves of a tool.

``rs274`` (Debian's linuxcnc-uspace) runs a program, as rs274_text.py prepares it, and prints what a machine
would be told, with four decimals in the unit in force, which the slack of each move covers. It thinks in
inches: so do the offsets and the tool table that it is given.
"""

import math
import os
import re
import shutil
import signal
import subprocess
import tempfile
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.input_file import Place, read_input
from triaxis.host.engines import Progress, unwatched
from triaxis.host.motion.curves import SLACK, Curve, Turned, arc
from triaxis.host.motion.expression import number
from triaxis.host.motion.interpreter import JOINED, PALLET
from triaxis.host.motion.kinematics import ROTARY
from triaxis.host.motion.machine import SYSTEMS, Machine
from triaxis.host.motion.moves import Program
from triaxis.host.motion.program import TOLD_AFTER, read_program
from triaxis.host.motion.program_text import runs_python
from triaxis.host.motion.reading import Reading
from triaxis.host.motion.rs274_text import prepared, unset
from triaxis.host.quantise import NOWHERE, Vector, added, vector

_PROGRAM = "rs274"
_INCH = Rational(254, 10)
# Seconds of the processor, and bytes printed: against loops without an end alone.
_LONGEST, _MOST_BYTES = 3600, 1 << 30
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
class _Told(Reading):
    """What the interpreter has told: offsets, units, tool; and the moves that follow, in millimetres."""

    path: Path
    unit: Fraction = Rational(1)  # noqa: RUF009
    # Zero of the system, G92, length compensation; and how far each printed number may be off.
    offsets: dict[str, Vector] = field(default_factory=lambda: dict.fromkeys(_OFFSETS, NOWHERE))
    errors: dict[str, Fraction] = field(default_factory=lambda: dict.fromkeys(_OFFSETS, Fraction(0)))
    angle: float = 0.0
    plane: str = "XY"
    tolerance: Fraction = Fraction(0)
    joined: Fraction = Fraction(0)
    position: Vector | None = None
    # The offsets of A, B and C: of the system, and G92.
    turned_by: dict[str, Vector] = field(default_factory=dict[str, Vector])
    # Whether the program may turn systems; how far from their zero anything was, in X and Y together.
    turns: bool = False
    farthest: Fraction = Fraction(0)
    # The line of the last change of a tool; whether compensation has changed since the last move of Z.
    changed: int = -1
    numbered: bool = True
    stale: bool = False
    # Whether a T has been told.
    chosen: bool = False
    # Lines that were given as two.
    split: frozenset[int] = frozenset()

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
            self._path_mode(text)
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

    def _path_mode(self, text: str) -> None:
        mode, *tolerance = text.split(", ")
        self.tolerance, self.exact_path = Fraction(0), True
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
            raise ValueError(
                f"where {system} has its zero, only the machine knows: give it in a machine file"
            )
        self._set("system", line, values[1:], numbers[1:])

    def _joined(self, values: list[Fraction]) -> None:
        self.joined = JOINED * (values[0] + _HALF * self.unit) if values[0] else values[0]

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
        within = self.tolerance + self.joined if self.tolerance else Fraction(0)
        curve: Curve = arc(start, stop, axes, about, turns < 0, abs(turns), 4 * self._error(), within)
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
        # The first goes to where the program begins.
        if start is None:
            self.turned = turned or self.turned
            return
        if self.machine.tools and self.loaded is None:
            raise ValueError("no tool is in the spindle: change to one, or give `loaded` in the machine file")
        self.stale &= start[2] == target[2]
        if self.length_of(self.loaded) is None and any(self.offsets["compensation"]):
            raise ValueError("a move with length compensation, of a tool whose length is not known: give it")
        self.notes.setdefault("units", f"line {line}: no G20 or G21 before it: millimetres assumed")
        # The centre of an arc moves all of it.
        printed = self._error() * (1 if curve is None else 3)
        tolerance = self.tolerance + self.joined
        self.go(line, start, target, rapid, curve, turned or self.turned, tolerance, printed, 6 * _HALF)


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
        # It would be run: of its files, those beside it can be called.
        files = {given, *(file for file in given.parent.glob("*.ngc") if file.is_file())}
        if any(runs_python(read_input(file).decode(errors="replace")) for file in files):
            return False
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
    (folder / "tools.tbl").write_text(_tool_table(machine), "utf-8")
    (folder / "offsets.var").write_text(_offsets(machine), "utf-8")
    (folder / "rs274.ini").write_text(f"[RS274NGC]\nSUBROUTINE_PATH = {called}\n", "utf-8")
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
    _check_installed()
    text = prepared(path, machine)
    x, y, z = (float(c) for c in start or NOWHERE)
    # Where it begins, with which tool; then no motion is in force.
    first = [f"N0 T{machine.loaded} M6"] if machine.loaded is not None else []
    first += [f"N0 G21 G90 G0 X{x:.9f} Y{y:.9f} Z{z:.9f}", "N0 G80"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "called").mkdir()
        (folder / "program.ngc").write_text("\n".join(["%", *first, *text.lines, "%", ""]), "utf-8")
        for file, lines in text.called.items():
            (folder / "called" / file).write_text("\n".join(lines), "utf-8")
        done = _interpret(folder, machine, skip_optional, Path("program.ngc"), Path("called"), _LONGEST)
        if done in _ENDLESS:
            most = f"within {_LONGEST} s, or {_MOST_BYTES >> 30} GB of moves"
            raise InputError(f"{path}: {_PROGRAM} did not end {most}: correct its loops")
        if done:
            raise _refusal(path, (folder / _ERRORS).read_text(errors="replace"))
        state = _Told(
            path, machine=machine, loaded=machine.loaded, tolerance=machine.tolerance or Fraction(0),
            split=text.split, turns=text.turns,
        )  # fmt: skip
        with (folder / _PRINTED).open(errors="replace") as calls:
            spline = _take(state, calls, progress)
    if spline is not None:
        program = read_program(path, start, skip_optional, machine)
        note = f"line {spline}: a spline, which it does not print: the program was read without rs274"
        return replace(program, notes=(*program.notes, note))
    if text.optional:
        told = "left out" if skip_optional else "run"
        state.notes["optional"] = f"lines that begin with / are {told}"
    return state.program(path, start)


def _refusal(path: Path, errors: str) -> InputError:
    """Return what the interpreter says of a program that it does not run to its end."""
    if (found := unset(path, errors)) is not None:
        return found
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
