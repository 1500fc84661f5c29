"""What both readers of programs do: moves as they are told, the program that they make, and its notes."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host.motion.curves import Curve
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.moves import Move, Program
from triaxis.host.motion.program_text import COMMENT, lines_of
from triaxis.host.quantise import NOWHERE, Vector, added, vector

# What a program may leave to the control, and what says it.
_STATE = {
    assumed: re.compile(rf"[Gg]\s*0*(?:{codes})(?!\.?\d)")
    for assumed, codes in (
        ("G90", "9[01]"), ("G17", "1[789]"), ("G54", r"5[4-9]|59\.[123]"), ("no G92", r"92\.[12]"),
        ("no length compensation", r"43(?:\.1)?|49"),
    )
}  # fmt: skip
_CALL = re.compile(r"^\s*(?:N\s*\d+\s*)?O.*CALL", re.IGNORECASE | re.ASCII)


@dataclass(kw_only=True)
class Reading:
    """A program that is being read, for a machine with a tool in its spindle, if any."""

    machine: Machine
    loaded: int | None = None
    # How often a tool was changed.
    changes: int = 0
    # Of A, B and C.
    turned: Vector = NOWHERE
    # Whether the program says how exactly the path is followed; how exactly the last move was.
    exact_path: bool = False
    blended: Fraction = Fraction(0)
    moves: list[Move] = field(default_factory=list)
    # Of what was assumed, by what it is about.
    notes: dict[str, str] = field(default_factory=dict)

    def length_of(self, number: int | None) -> Fraction | None:
        """Return the length of a tool, None where that is not known."""
        tool = self.machine.tools.get(-1 if number is None else number)
        return tool.length if tool else None

    def go(
        self, line: int, start: Vector, end: Vector, rapid: bool, curve: Curve | None, turned: Vector,
        tolerance: Fraction, off: Fraction = Fraction(0), turned_off: Fraction = Fraction(0),
    ) -> None:  # fmt: skip
        """Add a move of the spindle's nose, and of the tool below it; raise ValueError as `Machine.turned`.

        ``tolerance``: within which it is joined to others; ``off``, ``turned_off``: how far places, and
        angles in degrees, may be from where they are said to be.
        """
        if down := self.length_of(self.loaded):
            below = vector((Rational(0), Rational(0), -Rational(down)))
            start, end, curve = added(start, below), added(end, below), curve and curve.moved(below)
        if not (rapid or self.exact_path or self.machine.tolerance is not None):
            told = "without G61 or G64 the path is taken for exactly followed"
            self.notes.setdefault("path mode", f"line {line}: {told}")
        straight = curve is None and (not rapid or self.machine.straight)
        # The corner between two moves is rounded by the larger tolerance of both.
        blended, self.blended = max(tolerance, self.blended), tolerance
        slack = blended + off + (curve.slack if curve else 0)
        turns, self.turned = (self.turned, turned), turned
        move = Move(
            line, start, end, rapid, straight, curve, slack, self.loaded or 0, turns, turned_off, self.changes
        )
        self.moves.append(self.machine.turned(move, self.moves, blended))

    def program(self, path: Path, start: Vector | None) -> Program:
        """Return what was read of a file; raise InputError where nothing moves.

        ``start``: where the program begins; None: nobody has said where.
        """
        if not self.moves:
            raise InputError(f"{path}: no moves: a program with at least one G0 or G1 move is needed")
        if start is None:
            told = "the first move starts at X0 Y0 Z0, which is assumed: give --start"
            self.notes["start"] = f"line {self.moves[0].line}: {told}"
        self.notes["state"] = _assumed_state(lines_of(path), self.moves)
        self.notes |= self.machine.assumed
        changes = (self.loaded or 0, self.changes) != (self.moves[-1].tool, self.moves[-1].changes)
        if changes:
            told = "is not checked where it is then: add a move there"
            self.notes["late change"] = f"the tool that is changed to after the last move {told}"
        return Program(path, tuple(self.moves), tuple(filter(None, self.notes.values())), changes)


def _assumed_state(lines: Sequence[str], moves: Sequence[Move]) -> str:
    """Return the note of what no line up to the first move says: what the control has then; "" where nothing.

    An aborted program may leave G91, another system or plane; G92 and G43 stay after M2.
    """
    # A move of a subroutine stands before the call, and what is said before that counts.
    called = next((count for count, line in enumerate(lines, 1) if _CALL.search(line)), 0)
    said = (line for line in lines[: max(moves[0].line, called)] if not line.lstrip().startswith("/"))
    text = "\n".join(COMMENT.sub("", line) for line in said)
    curved = any(move.curve is not None for move in moves)
    missing = [
        assumed
        for assumed, pattern in _STATE.items()
        if pattern.search(text) is None and (curved or assumed != "G17")
    ]
    if not missing:
        return ""
    return f"line {moves[0].line}: assumed, as no line up to the first move says it: {', '.join(missing)}"
