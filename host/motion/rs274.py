"""Programs read by LinuxCNC's own interpreter: all that it understands, as moves of a tool.

``rs274`` (Debian's linuxcnc-uspace) runs a program and prints what a machine would be told, with four
decimals in the unit in force, which the slack of each move covers. Each line is given its number as N word,
so that moves know theirs. It thinks in inches: so do the offsets and the tool table that it is given.
"""

import math
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.input_file import Place, read_input
from triaxis.host.motion.curves import Curve, arc
from triaxis.host.motion.expression import number
from triaxis.host.motion.machine import SYSTEMS, Machine
from triaxis.host.motion.program import Move, Program, assumed_start
from triaxis.host.quantise import NOWHERE, Vector, added, vector

_PROGRAM = "rs274"
_INCH = Rational(254, 10)
# Seconds: against hanging alone. What it printed until then is not looked at.
_LONGEST = 3600
_NUMBER = re.compile(r"^(\s*/?)\s*(?:[Nn]\s*\d+)?", re.ASCII)
_CALL = re.compile(r"\s*\d+ N(\d+|\.+)\s+([\w.]+)\((.*)\)", re.ASCII)
_ERROR = re.compile(r"^(?!executing|File ended).*\S", re.MULTILINE)
# Of what is printed: a position is the sum of four numbers, the centre of an arc moves all of it.
_HALF, _SUMMED, _SUMMED_ARC = Rational(1, 20000), 4, 12
_PLANES = {"XY": (0, 1, 2), "XZ": (2, 0, 1), "YZ": (1, 2, 0)}
_REFUSED = {
    "STRAIGHT_PROBE": "ends where the part is, which nobody knows before: check the program without it",
    "NURBS_FEED": "a spline, which the interpreter does not print: let the post-processor write plain moves",
    "ORIENT_SPINDLE": "orients the spindle, and so turns the tool: check the program without it",
}
_IGNORED = re.compile(
    r"(ENABLE|DISABLE|START|STOP|SET_(FEED|SPINDLE|AUX|TOOL|G54)|CLEAR|FLOOD|MIST|LOG|TURN_PROBE|USE_SPINDLE)\w*|"
    r"COMMENT|MESSAGE|DWELL|ON_RESET|PROGRAM_\w+|OPTIONAL_PROGRAM_STOP|PALLET_SHUTTLE|FINISH|SELECT_TOOL"
)


@dataclass
class _Machine:
    """What the interpreter has told: offsets, units, tool; and the moves that follow, in millimetres."""

    path: Path
    machine: Machine
    loaded: int | None
    unit: Fraction = Rational(1)  # noqa: RUF009
    system: Vector = NOWHERE
    shift: Vector = NOWHERE
    compensation: Vector = NOWHERE
    angle: float = 0.0
    plane: str = "XY"
    tolerance: Fraction = Fraction(0)
    joined: Fraction = Fraction(0)
    position: Vector | None = None
    moves: list[Move] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)

    def told(self, line: int, call: str, text: str) -> None:
        """Take a call; raise ValueError where it is not understood."""
        if call in _REFUSED:
            raise ValueError(_REFUSED[call])
        if call == "USE_LENGTH_UNITS":
            self.unit = _INCH if "INCH" in text else Rational(1)
        elif call == "SELECT_PLANE":
            self.plane = text.rsplit("_", 1)[-1]
        elif call == "SET_XY_ROTATION":
            self.angle = math.radians(float(text))
        elif call == "SET_MOTION_CONTROL_MODE":
            self._path_mode(text)
        elif call in ("CHANGE_TOOL", "CHANGE_TOOL_NUMBER"):
            self._change_tool(line, int(text))
        elif call in _CALLS:
            numbers = [
                number(part) if "-" not in part else -number(part[1:]) for part in re.split(r"[,\s]+", text)
            ]
            _CALLS[call](self, line, [value * self.unit for value in numbers], numbers)
        elif not _IGNORED.fullmatch(call):
            raise ValueError(f"{call} is not understood: check the program without it")

    def _path_mode(self, text: str) -> None:
        mode, *tolerance = text.split(", ")
        self.tolerance = Fraction(0)
        if mode == "CANON_CONTINUOUS":
            self.tolerance = number(tolerance[0]) * self.unit
            if not self.tolerance and self.machine.tolerance is None:
                raise ValueError(
                    "lets the control round corners: give P, or path_tolerance in a machine file"
                )
            self.tolerance = self.tolerance or self.machine.tolerance or Fraction(0)

    def _change_tool(self, line: int, tool: int) -> None:
        if self.machine.tools and tool not in self.machine.tools:
            raise ValueError(f"the machine file has no tool {tool}: add it")
        if not self.machine.tools and (self.moves or "tool" in self.notes):
            raise ValueError("changes the tool, and so its shape: give a machine file with tools")
        taken = "how the machine moves to change tools is not checked"
        self.notes["tool"] = (
            f"line {line}: {taken if self.machine.tools else 'the tool is taken to be the one given'}"
        )
        self.loaded = tool

    def _set(self, name: str, values: list[Fraction]) -> None:
        setattr(self, name, vector(values[:3]))

    def _joined(self, values: list[Fraction]) -> None:
        self.joined = values[0]

    def _place(self, position: list[Fraction]) -> Vector:
        """Return where the spindle's nose is, in the frame of WORK.stl."""
        x, y, z = (p + s for p, s in zip(position, self.shift, strict=True))
        if self.angle:
            cos, sin = Fraction(math.cos(self.angle)), Fraction(math.sin(self.angle))
            x, y = (Rational(round(v * 10**9), 10**9) for v in (x * cos - y * sin, x * sin + y * cos))
        zero = self.machine.offsets.get("G54", NOWHERE)
        parts = zip((x, y, z), self.system, self.compensation, zero, strict=True)
        return vector(Rational(p + s + c - o) for p, s, c, o in parts)

    def _straight(self, line: int, values: list[Fraction], rapid: bool) -> None:
        if any(values[3:]):
            raise ValueError("only X, Y and Z move here: check single poses with `triaxis check --rotate`")
        self._go(line, self._place(values[:3]), rapid)

    def _arc(self, line: int, values: list[Fraction], numbers: list[Fraction]) -> None:
        if any(values[6:]):
            raise ValueError("only X, Y and Z move here: check single poses with `triaxis check --rotate`")
        axes = _PLANES[self.plane]
        if self.angle and self.plane != "XY":
            raise ValueError("an arc of a turned system out of XY: write turned moves")
        end, centre = [Fraction(0)] * 3, [Fraction(0)] * 3
        for k, value in zip(axes, (values[0], values[1], values[5]), strict=True):
            end[k] = value
        for k, value in zip(axes, (values[2], values[3], values[5]), strict=True):
            centre[k] = value
        target, middle, turns = self._place(end), self._place(centre), int(numbers[4])
        assert self.position is not None
        about = middle[axes[0]], middle[axes[1]]
        self._go(line, target, False, arc(self.position, target, axes, about, turns < 0, abs(turns)))

    def _go(self, line: int, target: Vector, rapid: bool, curve: Curve | None = None) -> None:
        start, self.position = self.position, target
        # The first goes to where the program begins.
        if start is None:
            return
        tools = self.machine.tools
        if tools and self.loaded is None:
            raise ValueError("no tool is in the spindle: give `loaded` in the machine file")
        tool = tools.get(self.loaded or 0)
        below = vector((Rational(0), Rational(0), -Rational((tool and tool.length) or 0)))
        start, end = (added(p, below) for p in (start, target))
        printed = _HALF * self.unit * (_SUMMED if curve is None else _SUMMED_ARC)
        slack = self.tolerance + self.joined + printed + (curve.slack if curve is not None else 0)
        straight = curve is None and (not rapid or self.machine.straight)
        moved = curve.moved(below) if curve is not None else None
        self.moves.append(Move(line, start, end, rapid, straight, moved, slack, self.loaded or 0))


_CALLS = {
    "STRAIGHT_TRAVERSE": lambda to, line, values, _: to._straight(line, values, True),
    "STRAIGHT_FEED": lambda to, line, values, _: to._straight(line, values, False),
    "RIGID_TAP": lambda to, line, values, _: to._straight(line, values, False),
    "ARC_FEED": lambda to, line, values, numbers: to._arc(line, values, numbers),
    "SET_G5X_OFFSET": lambda to, _, values, __: to._set("system", values[1:]),
    "SET_G92_OFFSET": lambda to, _, values, __: to._set("shift", values),
    "USE_TOOL_LENGTH_OFFSET": lambda to, _, values, __: to._set("compensation", values),
    "SET_NAIVECAM_TOLERANCE": lambda to, _, values, __: to._joined(values),
}


def read_by_rs274(path: Path, start: Vector | None, skip_optional: bool, machine: Machine) -> Program:
    """Read a program as `program.read_program` does; raise InputError where the interpreter refuses it."""
    text = read_input(path).decode("utf-8", errors="replace")
    if shutil.which(_PROGRAM) is None:
        raise InputError(f"{_PROGRAM} is not installed: install linuxcnc-uspace, or leave --reader out")
    place = [float(c) for c in start or NOWHERE]
    lines = [f"N0 G21 G90 G0 X{place[0]:.9f} Y{place[1]:.9f} Z{place[2]:.9f}"]
    lines += [
        line if line.strip() in ("", "%") else _NUMBER.sub(rf"\g<1>N{count} ", line, count=1)
        for count, line in enumerate(re.split(r"\r\n|\n|\r", text), 1)
    ]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        whole = "\n".join(["%", *(line for line in lines if line.strip() != "%"), "%", ""])
        (folder / "program.ngc").write_text(whole)
        (folder / "tools.tbl").write_text(_tool_table(machine))
        (folder / "offsets.var").write_text(_offsets(machine))
        (folder / "rs274.ini").write_text(f"[RS274NGC]\nSUBROUTINE_PATH = {path.parent.resolve()}\n")
        command = [_PROGRAM, "-g", "-i", "rs274.ini", "-t", "tools.tbl", "-v", "offsets.var", "program.ngc"]
        try:
            done = subprocess.run(
                [*command[:2], *["-b"] * skip_optional, *command[2:]], cwd=folder, capture_output=True,
                text=True, errors="replace", timeout=_LONGEST, check=False,
            )  # fmt: skip
        except subprocess.TimeoutExpired as error:
            raise InputError(
                f"{path}: {_PROGRAM} did not end within {_LONGEST} s: correct its loops"
            ) from error
    if done.returncode:
        told = _ERROR.findall(done.stderr)
        raise InputError(f"{path}: {_PROGRAM} refuses it: {' / '.join(told[-3:]) or 'no reason given'}")
    state = _Machine(path, machine, machine.loaded)
    for told in done.stdout.splitlines():
        match = _CALL.fullmatch(told)
        if match is None:
            continue
        line = int(match[1]) if match[1].isdigit() else 0
        try:
            state.told(line, match[2], match[3])
        except ValueError as error:
            raise Place(path, line).error(match[2], str(error)) from error
    if not state.moves:
        raise InputError(f"{path}: no moves: a program with at least one G0 or G1 move is needed")
    if start is None:
        state.notes["start"] = assumed_start(state.moves)
    return Program(path, tuple(state.moves), tuple(state.notes.values()))


def _tool_table(machine: Machine) -> str:
    return "".join(
        f"T{tool.number} P{tool.number} Z{float((tool.length or 0) / _INCH):.12f} "
        f"D{float((tool.diameter or 0) / _INCH):.12f} ;\n"
        for tool in machine.tools.values()
    )


def _offsets(machine: Machine) -> str:
    places = {5161: machine.homes.get("G28"), 5181: machine.homes.get("G30"), 5211: None}
    places |= {5221 + 20 * k: machine.offsets.get(name) for k, name in enumerate(SYSTEMS)}
    rows = {5220: 1.0}
    for first, place in places.items():
        values = [float(c / _INCH) for c in place or NOWHERE] + [0.0] * 3
        rows |= dict(enumerate(values, first))
    return "".join(f"{key}\t{value:.12f}\n" for key, value in sorted(rows.items()))
