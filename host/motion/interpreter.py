"""What a control does by the words of a line: the modal rules of RS-274, offsets, tools, cycles.

Numbers are exact: decimals as they stand, an inch 25.4 mm. Words that do not change where the tool is pass;
words that would and are not followed, and all unknown ones, are refused. A rapid may be any way on which no
axis turns back, unless the machine file says that it is straight.

Coordinates. The frame is that of WORK.stl: G54 as the machine file has it, and without one as it is at the
start. The spindle's nose S moves; the tool's origin, its tip, is its length below. Where a word says v, S
goes to

    v + zero of the system in force + G92 + length compensation,

and where no length is known, S is the tip, and compensation takes it for what it is. A, B and C are in
degrees, and without offsets.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.golden.input_file import Place
from triaxis.host.motion.curves import Curve, arc, centre_by_radius
from triaxis.host.motion.expression import Approximate, Key, Value, exact
from triaxis.host.motion.gcode import POLAR, Block, Word
from triaxis.host.motion.kinematics import ROTARY
from triaxis.host.motion.machine import SYSTEMS
from triaxis.host.motion.nurbs import nurbs
from triaxis.host.motion.reading import Reading
from triaxis.host.motion.words import ARCS, CYCLES, GROUPS, TAKERS, TAKING_AXES, WHY_REFUSED
from triaxis.host.quantise import Vector, added, vector

_AXES = "XYZ"
# Of M60.
PALLET = "what comes with a change of the pallet is not known: the workpiece is taken to be the same"
# Of G92.3.
RESTORES = "brings back what the control kept before the program, which nobody knows here: give G92"
_INCH, _MILLIMETRE = Rational(254, 10), Rational(1)
ORIGIN: Vector = vector((Rational(0),) * 3)
# Of a plane the two axes of its arcs, counter-clockwise from the first to the second, then the third.
_PLANES = {"G17": (0, 1, 2), "G18": (2, 0, 1), "G19": (1, 2, 0)}
_NOT_NEGATIVE = "FSTNHDL"
# Millimetres: what rounds to 0 is 0 to a control.
_LEAST_TOLERANCE = Rational(1, 1000)
# Arcs are replaced by points up to a quarter of the tolerance apart, before these are joined within it.
JOINED = Rational(5, 4)
# Holes that one line may drill, and turns of one arc.
_MOST_HOLES = _MOST_TURNS = 10_000
# Words that may stand beside the one that begins a NURBS.
_BESIDE_NURBS = frozenset(("G17", "G18", "G19", "G20", "G21", "G61", "G90", "G91", "G93", "G94"))
# What changes the zero, or what a position is from, on the line itself.
_UNDER_POLAR = frozenset(("G53", "G92.1", "G92.2", "G92.3"))
# LinuxCNC's G73 and G83 go up to so much above the last peck before they go on; it may be above R.
_OVER_PECK = Rational(254, 1000)
# Where controls differ.
_WITHIN_CYCLES = (
    "within a series of cycles: end it by G80 before that, and give the whole cycle again after it"
)
# Refused words that are told at a time.
_TOLD = 12


def _whole(word: Word) -> int:
    """Return a whole number, of which a computed one may fall short by a little."""
    return int(exact(word.value))


def _named(axes: tuple[int, ...]) -> str:
    return " and ".join(sorted(_AXES[k] for k in axes))


@dataclass(frozen=True)
class Modal:
    """What words leave from line to line."""

    motion: str | None = None
    plane: str = "G17"
    relative: bool = False
    arc_absolute: bool = False
    units: Fraction | None = None
    feed: bool = False
    to_old_height: bool | None = None
    system: str = "G54"
    tolerance: Fraction = Fraction(0)


@dataclass(frozen=True)
class ControlPoints:
    """What G5.2 has begun: where, of which order, in which plane, and its points with their weights."""

    place: Place
    line: int
    order: int
    plane: str
    points: tuple[Vector, ...]
    weights: tuple[Fraction, ...]


@dataclass
class Interpreter(Reading):
    """Runs blocks. ``position``: of the spindle's nose; ``zeros``: of the systems, where they are known."""

    position: Vector
    zeros: dict[str, Vector]
    modal: Modal
    # Of the program, that runs now.
    line: int = 0
    shift: Vector = ORIGIN
    shifted: bool = True
    # Whether the program has said what G92 is.
    shift_known: bool = False
    # Whose length G43 adds; None without compensation.
    offset: int | None = None
    compensation: Vector = ORIGIN
    # By T; None before the first: what the control has selected then nobody tells.
    chosen: int | None = None
    cycle: dict[str, Fraction] = field(default_factory=dict)
    # Where a series of cycles began; what must not change within it.
    level: Fraction | None = None
    begun_with: tuple[object, ...] = ()
    # Of which tool, with which compensation all moves are, where lengths are not known.
    basis: tuple[int | None, int | None] | None = None
    nurbs: ControlPoints | None = None
    refused: list[InputError] = field(default_factory=list)

    def ask(self, key: Key) -> Value | None:
        """Return the value of a parameter that the control gives; None where it gives none."""
        here, scale = self.programmed(), self.modal.units or _MILLIMETRE
        if isinstance(key, str):
            named = {f"_{axis.lower()}": Approximate(x / scale) for axis, x in zip(_AXES, here, strict=True)}
            flags = {
                "_metric": scale == 1, "_imperial": scale != 1, "_absolute": not self.modal.relative,
                "_incremental": self.modal.relative,
            }  # fmt: skip
            numbers = {"_current_tool": self.loaded, "_selected_tool": self.chosen}
            if key in numbers:
                number = numbers[key]
                return None if number is None else Fraction(number)
            return named.get(key, Fraction(flags[key]) if key in flags else None)
        if 5420 <= key < 5423:
            return Approximate(here[key - 5420] / scale)
        # Of an axis that no machine file has, nobody knows where it stands.
        if 5423 <= key < 5426 and ROTARY[key - 5423] in self.machine.rotary:
            return Approximate(self.turned[key - 5423])
        # The shift of G92 and what the tool table holds have the machine's unit, not the program's.
        known = {
            5220: Fraction(SYSTEMS.index(self.modal.system) + 1),
            5400: None if self.loaded is None else Fraction(self.loaded),
        }  # fmt: skip
        return known.get(key)

    def programmed(self) -> Vector:
        """Return the position as the program has it, in millimetres."""
        return vector(s - z for s, z in zip(self.position, self.origin(), strict=True))

    def origin(self) -> Vector:
        """Return where the spindle's nose is at X0 Y0 Z0."""
        shift = self.shift if self.shifted else ORIGIN
        return added(self.zeros[self.modal.system], shift, self.compensation)

    def refuse(self, place: Place, word: Word, why: str) -> None:
        """Keep what is not understood: all of it is told at once."""
        error = place.error(word.text, why)
        if str(error) not in map(str, self.refused):
            self.refused.append(error)
        if len(self.refused) >= _TOLD:
            raise InputError("there may be more: the rest is not read")

    def tell_refused(self, end: InputError | None = None) -> None:
        """Raise InputError where anything was not understood, with what ended the reading before its end."""
        errors = [*self.refused, end] if end is not None else self.refused
        if len(errors) == 1:
            raise errors[0]
        if errors:
            first, *others = map(str, errors)
            path = first.split(": line ")[0]
            raise InputError("; ".join((first, *(other.removeprefix(f"{path}: ") for other in others))))

    def run(self, block: Block) -> bool:
        """Run a line; return whether it ends the program."""
        self.line = block.line
        place, codes = block.place, self._codes(block)
        on_line = {word.code for group in codes.values() for word in group}
        words = self._by_letter(block, on_line)
        if self.nurbs is not None or "G5.2" in on_line:
            self._only_nurbs(block)
        self._set_modal(place, codes, words)
        if "T" in words:
            self.chosen = _whole(words["T"])
        for word in codes.get("tool change", ()):
            self._change_tool(place, word, words)
        if "M60" in on_line:
            self.notes["pallet"] = f"line {self.line}: {PALLET}"
        for word in codes.get("length compensation", ()):
            self._compensate(place, word, words)
        for word in codes.get("work offset", ()):
            self._choose_system(place, word)
        words |= self._polar(place, words, bool(on_line & (TAKING_AXES | _UNDER_POLAR)))
        axes = {_AXES.index(letter): words[letter] for letter in _AXES if letter in words}
        turning = [words[letter] for letter in ROTARY if letter in words]
        if self.modal.motion in ("G5.2", "G5.3"):
            self._nurbs(block, words, axes)
        elif not self._non_modal(place, codes, words, axes):
            if axes | self._arc_alone(words) or turning:
                self._motion(place, codes, words, axes)
            elif on_line & (ARCS | CYCLES | {"G5", "G5.1", "G33", "G53"}):
                raise place.error(block.words[0].text, "a motion without X, Y or Z: give one")
        return bool(on_line & {"M2", "M30"})

    def _codes(self, block: Block) -> dict[str, list[Word]]:
        """Return the G and M words by their modal groups; refuse unknown ones and two of a group."""
        codes: dict[str, list[Word]] = {}
        for word in block.words:
            if word.letter not in "GM":
                continue
            group = GROUPS.get(word.code)
            if group is None:
                why = "not known: see what it does, and whether it moves anything"
                self.refuse(block.place, word, WHY_REFUSED.get(word.code, why))
            elif group in codes and group != "no modal group":
                both = f"{codes[group][0].text} and {word.text}"
                raise block.place.error(
                    word.text, f"{both} on one line exclude each other ({group}): keep one"
                )
            else:
                codes.setdefault(group, []).append(word)
        return codes

    def _by_letter(self, block: Block, on_line: set[str]) -> dict[str, Word]:
        """Return the words other than G and M by their letters; refuse unknown and repeated ones."""
        words: dict[str, Word] = {}
        # The motion in force takes letters where it moves by this line, and no other word takes the line.
        groups = {GROUPS[code] for code in on_line}
        # What a word means that is not understood, nobody knows: that word alone is told.
        strange = any(word.letter in "GM" and word.code not in GROUPS for word in block.words)
        by_it = not groups & {"motion", "cycle"} and not on_line & TAKING_AXES
        moving = any(word.letter in f"XYZIJK{ROTARY}{POLAR}" for word in block.words)
        in_force = on_line | ({self.modal.motion or ""} if by_it and moving else set())
        for index, word in enumerate(block.words):
            letter = word.letter
            if letter in "GM":
                continue
            if (
                letter not in {*"XYZFSTNO" + POLAR, *self.machine.rotary}
                and not TAKERS.get(letter, frozenset()) & in_force
            ):
                if not strange or letter in "ABCUVW":
                    self.refuse(block.place, word, WHY_REFUSED.get(letter, "not known: correct it"))
                continue
            if letter in words:
                raise block.place.error(word.text, f"{letter} stands twice on the line: keep one")
            if letter == "O" and len(block.words) > 1:
                raise block.place.error(
                    word.text, "a program number stands alone on its line: move the others"
                )
            if letter == "N" and index > 0:
                raise block.place.error(word.text, "N must be the first word of its line: move it")
            whole = "OTHL" + "P" * bool(in_force & (ARCS | {"G10"})) + "Q" * ("M61" in on_line)
            if letter in whole and exact(word.value).denominator != 1:
                raise block.place.error(word.text, "must be a whole number: correct it")
            if letter == "L" and not 1 <= word.value <= _MOST_HOLES and in_force & CYCLES:
                raise block.place.error(word.text, f"repeats 1 to {_MOST_HOLES} times: correct it")
            if letter in _NOT_NEGATIVE + "PQ" * ("G5" not in in_force) and word.value < 0:
                raise block.place.error(word.text, "must not be negative: correct it")
            words[letter] = word
        return words

    def _set_modal(self, place: Place, codes: dict[str, list[Word]], words: dict[str, Word]) -> None:
        modal, before = self.modal, self.modal.motion
        changes: dict[str, object] = {}
        for group, (word, *_) in codes.items():
            code = word.code
            if group == "motion":
                changes["motion"] = code
            elif group == "cycle" and "motion" not in codes:
                changes["motion"] = None
            elif group == "plane":
                changes["plane"] = code
            elif group == "distance":
                changes["relative"] = code == "G91"
            elif group == "arc distance":
                changes["arc_absolute"] = code == "G90.1"
            elif group == "units":
                changes["units"] = _INCH if code == "G20" else _MILLIMETRE
            elif group == "retract":
                changes["to_old_height"] = code == "G98"
        if changes:
            self.modal = modal = replace(modal, **changes)  # pyright: ignore[reportArgumentType]
        if modal.motion != before or "units" in codes:
            self.cycle = {}
        if modal.motion not in CYCLES:
            self.level = None
        if "F" in words:
            if words["F"].value <= 0:
                raise place.error(words["F"].text, "a feed must be positive: correct it")
            self.modal = replace(self.modal, feed=True)
        for word in codes.get("path mode", ()):
            self._path_mode(place, word, words)

    def _path_mode(self, place: Place, word: Word, words: dict[str, Word]) -> None:
        tolerance = Fraction(0)
        if word.code == "G64":
            left, joined = (self.length(words[k]) if k in words else None for k in "PQ")
            # P0 is no tolerance of 0, but none at all.
            if left is not None and left > _LEAST_TOLERANCE:
                # The path may be left by P, and moves that are nearly in line joined by as much, or Q.
                tolerance = left + JOINED * (left if joined is None else joined)
            elif self.machine.tolerance is None:
                why = "lets the control round corners: give P, or path_tolerance in a machine file"
                self.refuse(place, word, why)
            else:
                tolerance = self.machine.tolerance + JOINED * (joined or 0)
        self.modal, self.exact_path = replace(self.modal, tolerance=tolerance), True

    def length(self, word: Word) -> Fraction:
        """Return the value of a word in millimetres, which are assumed where the program says nothing."""
        if self.modal.units is None:
            self.modal = replace(self.modal, units=_MILLIMETRE)
            self.notes["units"] = f"line {self.line}: no G20 or G21 before it: millimetres assumed"
        return exact(word.value) * (self.modal.units or 1)

    def _change_tool(self, place: Place, word: Word, words: dict[str, Word]) -> None:
        if word.code == "M61" and "Q" not in words:
            raise place.error(word.text, "which tool it is: give Q")
        number = _whole(words["Q"]) if word.code == "M61" else self.chosen
        if self.machine.tools:
            if number is None:
                why = "changes to the tool that the control has selected, which nobody says: give T before it"
                raise place.error(word.text, why)
            if number and number not in self.machine.tools:
                self.refuse(place, word, f"the machine file has no tool {number}: add it")
            self.notes["tool"] = f"line {self.line}: how the machine moves to change tools is not checked"
        elif (number is None or number != self.loaded) and (self.moves or "tool" in self.notes):
            self.refuse(place, word, "changes the tool, and so its shape: give a machine file with tools")
        else:
            self.notes["tool"] = f"line {self.line}: the tool of {word.text} is taken to be the one given"
        self.changes += 1
        # Of moves with an empty spindle nothing is known, but by a tool 0.
        self.loaded = number if number in self.machine.tools or not self.machine.tools else None

    def _compensate(self, place: Place, word: Word, words: dict[str, Word]) -> None:
        self.offset, self.compensation = None, ORIGIN
        if word.code == "G49":
            return
        number = _whole(words["H"]) if "H" in words else self.loaded
        if "H" in words and number == 0 != self.loaded:
            why = "the tool in the spindle to some controls, and tool 0 to others: say which, by its number"
            raise place.error(words["H"].text, why)
        self.offset = -1 if number is None else number
        length = self.length_of(number)
        if length is not None:
            self.compensation = vector((Fraction(0), Fraction(0), length))
        elif number == 0 or self.loaded not in (None, number):
            raise place.error(
                word.text, f"the length of tool {number} is not known: give it in a machine file"
            )
        else:
            self.notes["length"] = f"line {self.line}: {word.text} is taken for the tool's true length"

    def _known(self) -> bool:
        """Return whether all lengths are known that say where the tool's origin is."""
        return self.length_of(self.loaded) is not None and (
            self.offset is None or self.length_of(self.offset) is not None
        )

    def _absolute(self, place: Place, word: Word) -> Vector:
        """Return the machine coordinates of the frame; raise InputError where the tool's place in them is not
        known.
        """
        zero = self.machine.offsets.get("G54")
        if zero is None:
            why = "is where only the machine knows: give offsets, and homes, in a machine file"
            raise place.error(word.text, why)
        if self.offset is not None and not self._known():
            raise place.error(word.text, "with a tool of unknown length: give it in a machine file")
        return zero

    def _zero(self, place: Place, word: Word, system: str) -> Vector:
        if system not in self.zeros:
            why = f"where {system} has its zero, only the machine knows: give it in a machine file"
            self.refuse(place, word, why)
            # What comes of it counts for nothing; what else is not understood is looked for.
            self.zeros[system] = ORIGIN
        return self.zeros[system]

    def _choose_system(self, place: Place, word: Word) -> None:
        if self.modal.motion in CYCLES:
            raise place.error(word.text, _WITHIN_CYCLES)
        self._zero(place, word, word.code)
        self.modal = replace(self.modal, system=word.code)

    def _non_modal(
        self, place: Place, codes: dict[str, list[Word]], words: dict[str, Word], axes: dict[int, Word]
    ) -> bool:
        """Do what words say that hold for their line alone; return whether they took the axes."""
        group = codes.get("no modal group", [])
        taking = [word for word in group if word.code in TAKING_AXES]
        if len(group) > 1 or (taking and codes.keys() & {"motion", "cycle"}):
            raise place.error(group[-1].text, "two words of the line take its axes: split it")
        if not group or group[0].code == "G53":
            return False
        word, values = group[0], {k: self.length(axis) for k, axis in axes.items()}
        code = word.code
        if self.modal.motion in CYCLES and code not in ("G4", "G28", "G30"):
            raise place.error(word.text, _WITHIN_CYCLES)
        if code == "G4" and axes and "P" not in words:
            why = "on a line with G4 a control may take it for a time: split the line"
            raise place.error(next(iter(axes.values())).text, why)
        turning = [words[letter] for letter in ROTARY if letter in words]
        if taking and turning:
            raise place.error(
                turning[0].text, f"with {code}: axes that turn have no offsets here, and no home"
            )
        if code in ("G28", "G30") and not axes and self.machine.rotary:
            raise place.error(word.text, "turns axes to where only the machine knows: name X, Y or Z")
        if code in ("G92", "G52") and not axes:
            raise place.error(word.text, "takes X, Y or Z: give one")
        if code == "G10":
            self._set_system(place, word, words, values)
        elif code in ("G28", "G30"):
            self._go_home(place, word, axes)
        elif code in ("G92", "G52"):
            here, shift = self.programmed(), self.shift if self.shifted else ORIGIN
            new = {k: here[k] + shift[k] - v if code == "G92" else v for k, v in values.items()}
            self.shift, self.shifted = vector(new.get(k, shift[k]) for k in range(3)), True
            self.shift_known = True
        elif code == "G92.1":
            self.shift, self.shift_known = ORIGIN, True
        elif code == "G92.3" and not self.shift_known:
            raise place.error(word.text, RESTORES)
        elif code != "G4":
            self.shifted = code == "G92.3"
        return bool(taking)

    def _set_system(
        self, place: Place, word: Word, words: dict[str, Word], values: dict[int, Fraction]
    ) -> None:
        """Do G10 L2, which gives the zero of a system in machine coordinates, or L20, which gives it by where
        the tool is.
        """
        kind, number = (_whole(words[k]) if k in words else -1 for k in "LP")
        if kind not in (2, 20) or not 0 <= number <= len(SYSTEMS):
            return self.refuse(
                place, word, "only G10 L2 and L20 of a system 0 to 9 are followed: write them so"
            )
        if "R" in words and words["R"].value:
            why = "turned systems are followed by LinuxCNC's interpreter alone: give --reader rs274"
            return self.refuse(place, words["R"], why)
        system = SYSTEMS[number - 1] if number else self.modal.system
        if kind == 2:
            zero = self._absolute(place, word)
            new = {k: v - zero[k] for k, v in values.items()}
        else:
            shift = self.shift if self.shifted else ORIGIN
            new = {k: self.position[k] - self.compensation[k] - shift[k] - v for k, v in values.items()}
        old = self.zeros.get(system)
        if old is None and len(new) < 3:
            self._zero(place, word, system)
        self.zeros[system] = vector(new[k] if k in new else old[k] if old else Fraction(0) for k in range(3))
        return None

    def _go_home(self, place: Place, word: Word, axes: dict[int, Word]) -> None:
        zero, home = self._absolute(place, word), self.machine.homes.get(word.code)
        if home is None:
            raise place.error(word.text, "goes where only the machine knows: give homes in a machine file")
        if axes:
            self._line(place, self._target(axes), rapid=True)
        goal = [h - z for h, z in zip(home, zero, strict=True)]
        moved = (goal[k] if k in axes or not axes else self.position[k] for k in range(3))
        self._line(place, vector(moved), rapid=True)

    def _target(self, axes: dict[int, Word]) -> Vector:
        """Return where the axis words of a line go."""
        origin, target = self.origin(), list(self.position)
        for k, word in axes.items():
            value = self.length(word)
            target[k] = target[k] + value if self.modal.relative else origin[k] + value
        return vector(target)

    def _polar(self, place: Place, words: dict[str, Word], taken: bool) -> dict[str, Word]:
        """Return the X and Y words of a polar position: radius @ and angle ^, what is not given as it is."""
        given = [words.get(letter) for letter in POLAR]
        if not any(given):
            return {}
        first = given[0] or given[1]
        assert first
        if self.modal.plane != "G17" or "X" in words or "Y" in words or taken:
            raise place.error(first.text, "polar positions are of a move in XY, without X and Y: correct it")
        unit = self.modal.units or _MILLIMETRE
        x, y = (float(c / unit) for c in self.programmed()[:2])
        now = math.hypot(x, y), math.degrees(math.atan2(y, x))
        if now[0] < 1e-6 and (given[1] is None or self.modal.relative):
            raise place.error(first.text, "from the zero, which has no angle: give @ and ^, and G90")
        radius, angle = (
            old if word is None else float(word.value) + (old if self.modal.relative else 0)
            for old, word in zip(now, given, strict=True)
        )
        to = radius * math.cos(math.radians(angle)), radius * math.sin(math.radians(angle))
        less = (x, y) if self.modal.relative else (0.0, 0.0)
        return {k: Word(k, a - b, first.text) for k, a, b in zip("XY", to, less, strict=True)}

    def _arc_alone(self, words: dict[str, Word]) -> dict[int, Word]:
        """Return the centre of a whole circle that is given without axis words."""
        here = self.modal.motion in ARCS
        return {k: words[letter] for k, letter in enumerate("IJK") if here and letter in words}

    def _motion(
        self, place: Place, codes: dict[str, list[Word]], words: dict[str, Word], axes: dict[int, Word]
    ) -> None:
        motion = self.modal.motion
        turning = {ROTARY.index(letter): words[letter] for letter in ROTARY if letter in words}
        first = next(word for given in (axes, self._arc_alone(words), turning) for word in given.values())
        if motion is None and self.refused:
            # It may be that of a word which is refused: nothing is known of where it goes.
            return None
        if motion is None:
            raise place.error(first.text, "an axis word, but no G0 or G1 on the line or in force: add one")
        absolute = [word for word in codes.get("no modal group", ()) if word.code == "G53"]
        if absolute:
            if (
                motion not in ("G0", "G1")
                or self.modal.relative
                or first.letter not in _AXES + ROTARY
                or first.text[0] in POLAR
            ):
                raise place.error(
                    absolute[0].text, "goes with G0 or G1, G90, and X, Y or Z: correct the line"
                )
            zero = self._absolute(place, absolute[0])
            values = {k: self.length(word) - zero[k] for k, word in axes.items()}
            target = vector(values.get(k, self.position[k]) for k in range(3))
        else:
            target = self._target(axes)
        # The feed of a thread is the spindle's.
        if motion not in ("G0", "G33") and not self.modal.feed:
            word = next(iter(codes.get("motion", ())), first)
            raise place.error(word.text, f"a {motion} move without a feed: give F on the line or before it")
        turned = list(self.turned)
        for k, word in turning.items():
            turned[k] = exact(word.value) + (turned[k] if self.modal.relative else 0)
        if vector(turned) != self.turned and motion not in ("G0", "G1"):
            word = next(iter(turning.values()))
            raise place.error(word.text, f"{motion} does not turn axes: give G0 or G1")
        if motion in CYCLES:
            return self._drill(place, words, axes)
        try:
            if motion in ("G5", "G5.1"):
                return self._spline(place, words, target)
            self._line(place, target, motion == "G0", self._curve(words, target), vector(turned))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise place.error(first.text, str(error)) from error
        return None

    def _curve(self, words: dict[str, Word], target: Vector) -> Curve | None:
        """Return the curve of the spindle's nose to a target, None where it is straight."""
        motion, start = self.modal.motion or "", self.position
        given = {letter: self.length(words[letter]) for letter in "IJKR" if letter in words}
        if motion in ARCS:
            plane, clockwise = _PLANES[self.modal.plane], motion == "G2"
            turns = _whole(words["P"]) if "P" in words else 1
            if not 1 <= turns <= _MOST_TURNS:
                raise ValueError(f"an arc of {turns} turns: give P1 to P{_MOST_TURNS}")
            if "R" in given:
                if given.keys() & set("IJK"):
                    raise ValueError("an arc by R and a centre: give one of them")
                centre, off = centre_by_radius(start, target, plane, given["R"], clockwise)
            else:
                centre, off = self._centre(given, plane), Fraction(0)
            within = self.modal.tolerance
            curve = arc(start, target, plane, centre, clockwise, turns, tolerance=within)
            return replace(curve, slack=curve.slack + off)
        return None

    def _spline(self, place: Place, words: dict[str, Word], target: Vector) -> None:
        """Go along a spline of one control point, or of two; no motion is in force after it.

        To LinuxCNC it is the NURBS of its points; and the motion before it stays in force there.
        """
        start, motion = self.position, self.modal.motion
        if self.modal.plane != "G17" or start[2] != target[2]:
            raise ValueError("a spline is in the XY plane: give G17 and no Z")
        if "I" not in words or "J" not in words:
            raise ValueError("a spline without its first control point: give I and J")
        if motion == "G5" and ("P" not in words or "Q" not in words):
            raise ValueError("a spline without its second control point: give P and Q")
        points = [start]
        for of, letters in ((start, "IJ"), (target, "PQ"))[: 2 if motion == "G5" else 1]:
            x, y = (self.length(words[letter]) for letter in letters)
            points.append(added(of, vector((x, y, Rational(0)))))
        points.append(target)
        self._along_nurbs(place, points, [Fraction(1)] * len(points), len(points), "G17")

    def _only_nurbs(self, block: Block) -> None:
        """Refuse what may change the sense of control points, or leaves them."""
        beside = _BESIDE_NURBS if self.nurbs is None else frozenset()
        for word in block.words:
            if word.code not in ("G5.2", "G5.3", *beside) and word.letter not in "XYZPLFN":
                where = "between G5.2 and G5.3" if self.nurbs else "on a line with G5.2"
                raise block.place.error(word.text, f"{where}: only control points stand there, and F")

    def _nurbs(self, block: Block, words: dict[str, Word], axes: dict[int, Word]) -> None:
        """Add what a line has of a NURBS; go along it where it ends."""
        place, begun, word = block.place, self.nurbs, block.words[0]
        if self.modal.motion == "G5.3":
            if axes:
                raise place.error(next(iter(axes.values())).text, "on a line with G5.3: give it before")
            self._end_nurbs(place, word)
            return
        if not self.modal.feed:
            raise place.error(word.text, "a NURBS without a feed: give F on the line or before it")
        weight = exact(words["P"].value) if "P" in words else None
        if begun is None:
            order = _whole(words["L"]) if "L" in words else 3
            if order < 3:
                raise place.error(words["L"].text, "the order of a NURBS is 3 or more: correct it")
            first = weight if weight and not axes else Fraction(1)
            begun = ControlPoints(place, self.line, order, self.modal.plane, (self.position,), (first,))
        elif "L" in words:
            raise place.error(words["L"].text, "of a NURBS that has begun: give its order where it begins")
        if axes:
            wanted = _PLANES[begun.plane][:2]
            if axes.keys() != set(wanted):
                raise place.error(
                    word.text, f"a control point in {begun.plane} has {_named(wanted)}: give both"
                )
            if not weight:
                raise place.error(word.text, "a control point without a weight above 0: give P")
            points = (*begun.points, self._target(axes))
            begun = replace(begun, points=points, weights=(*begun.weights, weight))
        elif begun.place is not place:
            raise place.error(
                word.text, f"not a control point: give {_named(_PLANES[begun.plane][:2])} and P"
            )
        self.nurbs = begun

    def _end_nurbs(self, place: Place, word: Word) -> None:
        begun, self.nurbs = self.nurbs, None
        if begun is None:
            raise place.error(word.text, "no NURBS to end: begin it by G5.2")
        if len(begun.points) < begun.order:
            why = f"{len(begun.points)} points, the tool's own among them: order {begun.order} needs as many"
            raise place.error(word.text, why)
        self.line = begun.line
        try:
            self._along_nurbs(begun.place, begun.points, begun.weights, begun.order, begun.plane)
        except ValueError as error:
            raise error if isinstance(error, InputError) else begun.place.error("G5.2", str(error)) from error

    def _along_nurbs(
        self, place: Place, points: Sequence[Vector], weights: Sequence[Fraction], order: int, plane: str
    ) -> None:
        """Go along a NURBS; no motion is in force after it. Raises ValueError where nobody knows its way."""
        zero = self.origin()
        far = max(abs(float(c - z)) for point in points for c, z in zip(point, zero, strict=True))
        curves = nurbs(points, weights, order, _PLANES[plane][:2], far)
        off = max(curve.slack for curve in curves)
        told = f"{float(off):.2g} mm are added for the arcs by which controls follow splines"
        self.notes.setdefault("spline", f"line {self.line}: {told}")
        for curve in curves:
            self._line(place, curve.end, False, curve)
        self.modal = replace(self.modal, motion=None)

    def end(self) -> None:
        """Refuse a program that ends before something that it has begun."""
        if self.nurbs is not None:
            raise self.nurbs.place.error("G5.2", "a NURBS that is not ended: give G5.3")

    def _centre(self, given: dict[str, Fraction], plane: tuple[int, int, int]) -> tuple[Fraction, Fraction]:
        if "IJK"[plane[2]] in given:
            raise ValueError(f"{'IJK'[plane[2]]} is not in the plane of the arc: correct it")
        letters = ["IJK"[k] for k in plane[:2]]
        if not given.keys() & set(letters):
            raise ValueError(f"an arc without a centre: give {letters[0]} and {letters[1]}, or R")
        if self.modal.arc_absolute:
            if not given.keys() >= set(letters):
                raise ValueError(f"G90.1 takes a whole centre: give {letters[0]} and {letters[1]}")
            origin = self.origin()
            first, second = (origin[k] + given[letter] for k, letter in zip(plane, letters, strict=False))
        else:
            first, second = (
                self.position[k] + given.get(letter, 0) for k, letter in zip(plane, letters, strict=False)
            )
        return first, second

    def _drill(self, place: Place, words: dict[str, Word], axes: dict[int, Word]) -> None:
        """Go through a drilling cycle: to the place, down to R, to the bottom, and up again.

        What it does on the way, as in pecking, is on the same line up and down. A tool that is below the
        height from which it goes down, after a hole with another R, goes straight there: LinuxCNC does so.
        """
        a, b, c = _PLANES[self.modal.plane]
        relative, origin = self.modal.relative, self.origin()
        if self.modal.plane != "G17" and self.modal.motion in ("G74", "G84"):
            why = f"tapping in {self.modal.plane}: controls go to different places: write plain moves"
            raise place.error(self.modal.motion or "", why)
        if "R" in words:
            self.cycle["R"] = self.length(words["R"])
        if "Q" in words:
            self.cycle["Q"] = self.length(words["Q"])
        if c in axes:
            self.cycle["bottom"] = self.length(axes[c])
        if not self.cycle.keys() >= {"R", "bottom"}:
            raise place.error(self.modal.motion or "", "a cycle without its depth: give R and Z")
        now = self.modal.plane, self.modal.units, self.compensation
        if self.level is None:
            self.level, self.begun_with = self.position[c], now
        if now != self.begun_with:
            why = f"plane, units or length changed {_WITHIN_CYCLES}"
            raise place.error(self.modal.motion or "", why)
        old = self.level
        clear = old + self.cycle["R"] if relative else origin[c] + self.cycle["R"]
        bottom = clear + self.cycle["bottom"] if relative else origin[c] + self.cycle["bottom"]
        if bottom > clear:
            raise place.error(self.modal.motion or "", "a cycle whose bottom is above R: correct it")
        above = max(old, clear) if self.modal.to_old_height else clear
        if self.modal.to_old_height is None and old > clear:
            why = (
                "goes up again to R with some controls, with others to where it was: say which, by G99 or G98"
            )
            raise place.error(self.modal.motion or "", why)

        pecks = self.modal.motion in ("G73", "G83") and "Q" in self.cycle
        highest = max(above, clear + _OVER_PECK - self.cycle["Q"]) if pecks else above

        def at(place_in_plane: Vector, height: Fraction) -> Vector:
            return vector(height if k == c else place_in_plane[k] for k in range(3))

        if old < clear != self.position[c]:
            self._line(place, at(self.position, clear), rapid=True)
        for again in range(_whole(words["L"]) if "L" in words else 1):
            if again and relative:
                # A step of the angle goes on from where the last one led.
                step = {letter: words[letter] for letter in POLAR if letter in words}
                axes = axes | {_AXES.index(k): word for k, word in self._polar(place, step, False).items()}
            target = self._target({k: axes[k] for k in (a, b) if k in axes})
            higher = not again and self.position[c] > clear
            self._line(place, at(target, self.position[c] if higher else above), rapid=True)
            self._line(place, at(target, clear), rapid=True)
            self._line(place, at(target, bottom), rapid=False)
            if highest != above:
                self._line(place, at(target, highest), rapid=True)
            self._line(place, at(target, above), rapid=True)

    def _line(
        self, place: Place, target: Vector, rapid: bool, curve: Curve | None = None,
        turned: Vector | None = None,
    ) -> None:  # fmt: skip
        """Move the spindle's nose, and the tool with it."""
        if self.machine.tools and self.loaded is None:
            raise place.error("move", "no tool is in the spindle: change to one, or give `loaded`")
        basis = None if self._known() else (self.loaded, self.offset)
        if self.moves and basis != self.basis:
            why = "moves of tools, or with offsets, whose lengths are not known: give all in a machine file"
            raise place.error("move", why)
        if basis is not None and self.offset is not None and self.loaded not in (None, self.offset):
            why = "with the length of another tool than the one in the spindle: give all in a machine file"
            raise place.error("move", why)
        self.basis = basis
        start, self.position = self.position, target
        try:
            self.go(self.line, start, target, rapid, curve, turned or self.turned, self.modal.tolerance)
        except ValueError as error:
            raise place.error("move", str(error)) from error
