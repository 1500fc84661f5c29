"""From the words of a program to straight moves in millimetres, by the modal rules of RS-274.

Numbers are exact: decimals as they stand, an inch 25.4 mm. Words that do not change where the tool is pass;
words that would, and all unknown ones, are refused. G0 is taken for a straight line, as G1, and the path
for exactly followed (G61); a control that interpolates rapids axis by axis, or rounds corners, leaves what
was checked.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place
from triaxis.host.motion.gcode import AFTER_THE_END, WHY_REFUSED, Block, Word, read_blocks
from triaxis.host.quantise import NOWHERE, Vector, vector

_AXES = "XYZ"
_INCH = Fraction(254, 10)

# Modal groups: of each, one word on a line. Those of "none" change nothing here.
_G_GROUPS = {
    "G0": "motion", "G1": "motion", "G80": "cycle", "G90": "distance", "G91": "distance", "G20": "units",
    "G21": "units", "G17": "plane", "G18": "plane", "G19": "plane", "G40": "radius compensation",
    "G49": "length compensation", "G54": "work offset", "G61": "path mode", "G94": "feed mode", "G4": "dwell",
}  # fmt: skip
_M_GROUPS = {
    "M0": "stop", "M1": "stop", "M2": "stop", "M30": "stop", "M3": "spindle", "M4": "spindle",
    "M5": "spindle", "M6": "tool change", "M7": "mist", "M8": "flood", "M9": "coolant off",
}  # fmt: skip
_NOT_NEGATIVE = "FSTPN"


@dataclass(frozen=True)
class Move:
    """A straight move from ``start`` to ``end`` in millimetres, of the program's line ``line``.

    ``feed`` is in millimetres per minute; None for a rapid.
    """

    line: int
    start: Vector
    end: Vector
    feed: Fraction | None

    def at(self, part: Fraction) -> Vector:
        """Return the position after a part of it, 0..1."""
        return vector(a + (b - a) * part for a, b in zip(self.start, self.end, strict=True))


@dataclass(frozen=True)
class Program:
    """The moves of a file, and what was assumed in reading it, a line each."""

    path: Path
    moves: tuple[Move, ...]
    notes: tuple[str, ...]


@dataclass
class _State:
    """What a line leaves to the next."""

    position: Vector
    motion: str | None = None
    relative: bool = False
    units: Fraction | None = None
    feed: Fraction | None = None
    moves: list[Move] = field(default_factory=list)
    notes: dict[str, str] = field(default_factory=dict)


def read_program(path: Path, start: Vector | None, skip_optional: bool = False) -> Program:
    """Read the moves of a program that begins at ``start``, in millimetres; None: nobody has said where.

    ``skip_optional`` leaves out lines that begin with /. Raises InputError, naming file, line and word, at
    whatever is not understood or stands after the program's end, and where there is no move.
    """
    state = _State(start or NOWHERE)
    ended = False
    for block in read_blocks(path):
        if ended and block.words:
            raise block.place.error(block.words[0].text, AFTER_THE_END)
        if block.optional:
            done = "left out" if skip_optional else "run"
            state.notes.setdefault("optional", f"lines that begin with / are {done}")
        if block.optional and skip_optional:
            continue
        if _run(block, state):
            ended = True
    if not state.moves:
        raise InputError(f"{path}: no moves: a program with at least one G0 or G1 move is needed")
    if start is None:
        line = state.moves[0].line
        state.notes["start"] = (
            f"line {line}: the first move starts at X0 Y0 Z0, which is assumed: give --start"
        )
    return Program(path, tuple(state.moves), tuple(state.notes.values()))


def _run(block: Block, state: _State) -> bool:
    """Run a line; return whether it ends the program."""
    place = block.place
    codes = _codes(block)
    words = _by_letter(block)
    if "cycle" in codes and "motion" not in codes:
        state.motion = None
    state.motion = codes["motion"].code if "motion" in codes else state.motion
    if "distance" in codes:
        state.relative = codes["distance"].code == "G91"
    if "units" in codes:
        state.units = _INCH if codes["units"].code == "G20" else Fraction(1)
    if "tool change" in codes:
        _change_tool(place, codes["tool change"], state)
    _check_parameters(place, words, codes)
    if "F" in words:
        if words["F"].value <= 0:
            raise place.error(words["F"].text, "a feed must be positive: correct it")
        state.feed = words["F"].value * _scale(place, state)
    axes = [words[letter] for letter in _AXES if letter in words]
    if axes:
        _move(place, axes, codes, state)
    return "stop" in codes and codes["stop"].code in ("M2", "M30")


def _by_letter(block: Block) -> dict[str, Word]:
    """Return the words other than G and M by their letters; refuse unknown and repeated ones."""
    words: dict[str, Word] = {}
    for index, word in enumerate(block.words):
        if word.letter in "GM":
            continue
        if word.letter not in "XYZFSTPNO":
            raise block.place.error(word.text, WHY_REFUSED.get(word.letter, "unknown: remove it"))
        if word.letter in words:
            raise block.place.error(word.text, f"{word.letter} stands twice on the line: keep one")
        if word.letter == "O" and len(block.words) > 1:
            raise block.place.error(word.text, WHY_REFUSED["O"])
        if word.letter == "N" and index > 0:
            raise block.place.error(word.text, "N must be the first word of its line: move it")
        if word.letter in "NOT" and word.value.denominator != 1:
            raise block.place.error(word.text, "must be a whole number: correct it")
        if word.letter in _NOT_NEGATIVE and word.value < 0:
            raise block.place.error(word.text, "must not be negative: correct it")
        words[word.letter] = word
    return words


def _codes(block: Block) -> dict[str, Word]:
    """Return the G and M words by their modal groups; refuse unknown ones and two of a group."""
    codes: dict[str, Word] = {}
    for word in block.words:
        if word.letter not in "GM":
            continue
        group = (_G_GROUPS | _M_GROUPS).get(word.code)
        if group is None:
            raise block.place.error(word.text, WHY_REFUSED.get(word.code, "not supported: remove it"))
        if group in codes:
            both = f"{codes[group].text} and {word.text}"
            raise block.place.error(word.text, f"{both} on one line exclude each other ({group}): keep one")
        codes[group] = word
    return codes


def _change_tool(place: Place, word: Word, state: _State) -> None:
    if state.moves or "tool" in state.notes:
        raise place.error(
            word.text, "changes the tool, and so its shape: check each tool's part of the program on its own"
        )
    state.notes["tool"] = f"line {place.line}: the tool of {word.text} is taken to be the one given"


def _check_parameters(place: Place, words: dict[str, Word], codes: dict[str, Word]) -> None:
    """Refuse P without the dwell that it belongs to, and axis words that a dwell would take."""
    if "P" in words and "dwell" not in codes:
        raise place.error(words["P"].text, "P belongs to G4, which is not on the line: remove it")
    for letter in _AXES if "dwell" in codes else "":
        if letter in words:
            raise place.error(
                words[letter].text, "on a line with G4 a control may take it for a time: split the line"
            )


def _scale(place: Place, state: _State) -> Fraction:
    """Return millimetres per unit of the program; millimetres are assumed where it says nothing."""
    if state.units is None:
        state.units = Fraction(1)
        state.notes["units"] = f"line {place.line}: no G20 or G21 before it: millimetres assumed"
    return state.units


def _move(place: Place, axes: Iterable[Word], codes: dict[str, Word], state: _State) -> None:
    first = next(iter(axes))
    if state.motion is None:
        why = "an axis word, but no G0 or G1 on the line or in force: add one"
        raise place.error(first.text, why)
    rapid = state.motion == "G0"
    if not rapid and state.feed is None:
        word = codes.get("motion", first)
        raise place.error(word.text, "a G1 move without a feed: give F on the line or before it")
    scale = _scale(place, state)
    target = list(state.position)
    for word in axes:
        k = _AXES.index(word.letter)
        target[k] = word.value * scale + (state.position[k] if state.relative else 0)
    end = vector(target)
    state.moves.append(Move(place.line, state.position, end, None if rapid else state.feed))
    state.position = end
