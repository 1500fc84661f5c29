"""The lines of a G-code file as words, and the order in which they run: branches, loops, subroutines.

The parsers on the package index do not fit: gcodeparser 0.3.0 drops lines of axis words without a G, runs
comments in parentheses, and pygcode 0.2.1 drops the rest of a line after a character that it does not know;
both round to binary.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeVar

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import Place
from triaxis.host.motion.expression import (
    ARGUMENTS,
    LARGEST,
    NUMBER,
    Expression,
    Key,
    Memory,
    Parameter,
    Scanner,
    Value,
    exact,
    number,
    times,
    truth,
)
from triaxis.host.motion.program_text import COMMENT, lines_of

Taken = TypeVar("Taken")

# What follows a program could be run by a control: nothing of a file is passed over.
AFTER_THE_END = (
    "stands after the end of the program: subroutines come before that, another program is a file of its own"
)
LATE_DELETE = "block delete is understood at the beginning of a line only: move it there"
# Radius and angle of a polar position.
POLAR = "@^"
# The number of a spindle has a sign, too.
_SIGNS = POLAR + "$"
# Lines that run again, and calls within calls: a program that takes more is taken for one that does not end.
_MOST_LINES, _MOST_CALLS = 2_000_000, 50

_PLAIN = re.compile(rf"([A-Za-z])[ \t]*([+-]?(?:{NUMBER}))", re.ASCII)
# What LinuxCNC takes for an O word on its way to the end of a branch; the rest of its line it does not check.
_SEEN = re.compile(r"/?(?:n[\d.]*)?o", re.IGNORECASE | re.ASCII)
_FLOW = re.compile(r"(?:N\d+\s*)?O\s*(?=[\d<#\[])", re.IGNORECASE | re.ASCII)
_FLOW_NAME, _FLOW_WORD = re.compile(r"<([^<>]*)>|(\d+)", re.ASCII), re.compile(r"[A-Za-z]+", re.ASCII)
_SUBROUTINE = re.compile(r"[\w-]{1,64}", re.ASCII)
_ENDS = {"sub": ("endsub",), "if": ("elseif", "else", "endif"), "elseif": ("elseif", "else", "endif"),
         "else": ("endif",), "while": ("endwhile",), "do": ("while",), "repeat": ("endrepeat",)}  # fmt: skip
# Words of macro programs, which stand where a letter and a number would.
_MACRO = re.compile(r"(?:IF|WHILE|GOTO|DO|END)(?=\s*[\d\[#])", re.IGNORECASE | re.ASCII)
# Of a repeat that is left LinuxCNC goes on to count where it comes there again; by its name it stops.
_COUNT_KEPT = "a control may go on with its count the next time: write it as a while"
_SECOND = "a second loop or branch of its name, which a control may take for the first: correct it"
_NOT_OF_REPEATS = "of a repeat, at which a control stops: write it as a while"
# LinuxCNC takes each break of a while that it passes over on its way to the end, and keeps it until the next
# end of a do, which it takes for that of the loop that it leaves. A continue of a do it keeps, too.
_BREAK_KEPT = "would run again after a while with a break, where a control may go on: write it as a while"
_CONTINUE_KEPT = "of a do, which a control may keep for the next loop: write it as a while, or with if"
BOTH_PLACES = "is called before it is defined, and {} has one of its name, which a control takes: keep one"
_OTHER_PLACE = "stands in {}, which is no program, and in {}, which a control takes: keep one"
_OTHER_FLOW = ("call", "return", "break", "continue", "endsub", "endif", "endwhile", "endrepeat")
# How many values stand after an O word: at least, at most; and how that is said. After others none does.
_VALUES = {
    **dict.fromkeys(("if", "elseif", "while", "repeat"), (1, 1, "one value in brackets: give it")),
    **dict.fromkeys(("return", "endsub"), (0, 1, "one value at most: remove the others")),
    "call": (0, ARGUMENTS, f"{ARGUMENTS} values at most: remove the others"),
}


@dataclass(frozen=True)
class Word:
    """A letter, in upper case, and a number. ``text`` is how it stands in the file."""

    letter: str
    value: Value
    text: str

    @property
    def code(self) -> str:
        """Return the word in its shortest form: G1 for g01, G38.2, X-0.5."""
        return f"{self.letter}{float(self.value):g}"


@dataclass(frozen=True)
class Computed:
    """A letter, and what gives its number once it runs. ``text`` is how it stands in the file."""

    letter: str
    value: Expression
    text: str

    @property
    def code(self) -> str:
        """Return the letter, of which it may be any word."""
        return self.letter


@dataclass(frozen=True)
class Line:
    """A line that has been read, and not yet run. ``words``: letters and what they will be.

    ``sets``, ``reads``: parameters. ``optional``: it begins with the block-delete sign, /. ``wrong``: why it
    cannot be run, where it cannot.
    """

    place: Place
    words: tuple[Word | Computed, ...] = ()
    settings: tuple[tuple[Callable[[Memory], Key], Expression], ...] = ()
    sets: tuple[Parameter, ...] = ()
    reads: tuple[Parameter, ...] = ()
    optional: bool = False
    wrong: InputError | None = None


@dataclass(frozen=True)
class Block:
    """A line as it runs: all its words have values; none where it is left out.

    ``line``: of the program; of what another file holds, that of the call.
    """

    place: Place
    words: tuple[Word, ...]
    optional: bool
    line: int


@dataclass
class Flow:
    """An O word: its name, what it does, with which values; and what stands between it and its end.

    ``written``: the name, None where it is computed; ``reads``: parameters.
    """

    place: Place
    name: Callable[[Memory], str]
    does: str
    values: tuple[Expression, ...]
    written: str | None
    reads: tuple[Parameter, ...]
    body: "list[_Statement]" = field(default_factory=list)
    # Where the body ended: elseif and else go on there, do has its condition in it.
    end: "Flow | None" = None

    @cached_property
    def breaks(self) -> bool:
        """Return whether a break of its name, or of one that is known only as it runs, is in its body."""
        return _has_break(self, _named(self))


_Statement = Line | Flow


class _LoopLeft(Exception):  # noqa: N818
    """Break, or continue, of the loop of a name."""


class _Return(Exception):  # noqa: N818
    """The end of a subroutine."""


def read_lines(path: Path) -> Iterator[Line | Flow]:
    """Yield the lines that are not empty. A single % stands before the first, and after the last."""
    started = closed = False
    for count, line in enumerate(lines_of(path), 1):
        place = Place(path, count)
        try:
            text = without_comments(place, line)
            body = text.strip()
            if body == "%":
                closed = started
                started = True
            elif body and closed:
                raise place.error(body.split()[0], AFTER_THE_END)
            elif body:
                started = True
                yield read_line(place, line, text)
        except InputError as error:
            # In a branch that is not run, too, as a control may see another end of it there.
            if _SEEN.match("".join(COMMENT.sub("", line).split())):
                raise
            yield Line(place, wrong=error)


def without_comments(place: Place, line: str) -> str:
    """Return a line with blanks in place of its comments, but for the last, ( .. ) or ; to its end."""
    kept: list[str] = []
    rest = line
    while match := re.search(r"[();]", rest):
        kept.append(rest[: match.start()])
        tail = rest[match.start() :]
        if match[0] == ";":
            return "".join(kept)
        if match[0] == ")":
            raise place.error(tail, "')' without '(': correct it")
        end = tail.find(")")
        if end < 0:
            raise place.error(tail, "the comment does not end on its line: add ')'")
        if "(" in tail[1:end]:
            raise place.error(tail, "a comment within a comment: remove the inner '('")
        kept.append(" " * (end + 1))
        rest = tail[end + 1 :]
    return "".join((*kept, rest))


def read_line(place: Place, line: str, text: str) -> Line | Flow:
    """Return what is on a line; raise InputError where it is not understood.

    ``text``: what `without_comments` leaves of it, in which the places of parameters are.
    """
    scanner = Scanner(text)
    optional = scanner.blanks() == "/"
    if optional:
        scanner.at += 1
        scanner.blanks()
    match = _FLOW.match(text, scanner.at)
    if optional and match:
        raise place.error(text.split()[0], "an O word that may be left out: begin its line without /")
    if match and (flow := _flow(place, text, match.end())):
        if COMMENT.split(line)[0].strip() != text.strip():
            raise place.error(text.split()[0], "an O word with a comment in it: move that to its end")
        return flow
    words: list[Word | Computed] = []
    settings: list[tuple[Callable[[Memory], Key], Expression]] = []
    sets: list[Parameter] = []
    while scanner.blanks():
        start = scanner.at
        try:
            if match := _MACRO.match(text, start):
                why = "macros of a control are not understood: have their moves written by the post-processor"
                raise place.error(match[0], why)
            if (words or settings) and text[start] in "oO":
                raise place.error(
                    text[start:].split()[0], "an O word begins its line: move it to one of its own"
                )
            if match := _PLAIN.match(text, start):
                scanner.at = match.end()
                words.append(Word(match[1].upper(), number(match[2]), match[0]))
            elif text[start] == "#":
                key = scanner.parameter()
                sets.append(scanner.parameters.pop())
                scanner.expect("=", "a parameter alone says nothing")
                settings.append((key, scanner.value()))
            else:
                letter = text[start]
                if not (letter.isascii() and letter.isalpha()) and letter not in _SIGNS:
                    raise place.error(text[start:].split()[0], _why_no_word(text[start:]))
                scanner.at += 1
                value = scanner.value()
                words.append(Computed(letter.upper(), value, text[start : scanner.at]))
        except ValueError as error:
            if isinstance(error, InputError):
                raise
            raise place.error(text[start:].split()[0], str(error)) from error
    return Line(place, tuple(words), tuple(settings), tuple(sets), tuple(scanner.parameters), optional)


def _why_no_word(rest: str) -> str:
    if rest[0] == "/":
        return LATE_DELETE
    if rest[0] == "%":
        return "'%' stands alone on its line: remove it"
    if rest[0] == "," and rest[1:2].upper() in ("R", "C"):
        return "a rounded or a bevelled corner: have its moves written by the post-processor"
    return "not a letter followed by a decimal number: correct it"


def _flow(place: Place, text: str, at: int) -> Flow | None:
    """Return what an O word does; None where its line is the number of a program."""
    scanner, written = Scanner(text, at), None
    try:
        name: Callable[[Memory], str]
        if match := _FLOW_NAME.match(text, at):
            scanner.at = match.end()
            fixed = written = "".join((str(int(match[2])) if match[2] else match[1]).split()).lower()
            name = lambda _: fixed  # noqa: E731
        else:
            value = scanner.value()
            name = lambda memory: _numeral(value(memory))  # noqa: E731
        scanner.blanks()
        word = _FLOW_WORD.match(text, scanner.at)
        if word is None:
            if not scanner.blanks() and match and match[2]:
                return None
            raise ValueError("says nothing: give sub, call, if, while, do, or repeat after it")
        does = word[0].lower()
        if does not in _ENDS and does not in _OTHER_FLOW:
            raise ValueError(f"{word[0]} is not understood after it: correct it")
        scanner.at = word.end()
        values: list[Expression] = []
        while scanner.blanks() == "[":
            values.append(scanner.bracket())
        if scanner.blanks():
            raise ValueError("more on its line than values in brackets: move it to the next")
        least, most, wanted = _VALUES.get(does, (0, 0, "no value: remove it"))
        if not least <= len(values) <= most:
            raise ValueError(f"{does} takes {wanted}")
    except ValueError as error:
        raise place.error(text.split()[0], str(error)) from error
    return Flow(place, name, does, tuple(values), written, tuple(scanner.parameters))


class Execution:
    """A program on its way: yields its blocks in the order in which they run.

    A subroutine that the file does not hold is looked for in one of its name beside it, with .ngc.
    """

    def __init__(self, path: Path, memory: Memory, skip_optional: bool) -> None:
        """Read a file; raise InputError where it cannot be read or an O word has no end.

        ``skip_optional`` leaves out lines that begin with /.
        """
        self._path, self._memory, self._skip = path, memory, skip_optional
        self._subroutines: dict[str, Flow] = {}
        # What the program has come by, as a control does; the loops that repeat just now.
        self._defined, self._repeating = set[str](), set[int]()
        # The loops and branches of a file, or of a subroutine; whether a break is kept.
        self._labels, self._broken = set[str](), False
        self._held = 0
        self._program = self._parsed(path)
        self._ran = self._depth = self._next = self._line = 0

    def blocks(self) -> Iterator[Block]:
        """Yield the blocks; raise InputError where one cannot be run."""
        try:
            yield from self._run(self._program, top=True)
        except (_LoopLeft, _Return) as left:
            place: Place = left.args[0]
            raise place.error("O", "stands in no loop or subroutine of its name: correct it") from left

    def refuse_following(self) -> None:
        """Raise InputError where anything would run after the block that was yielded last, in any case."""
        for statement in self._program[self._next :]:
            if isinstance(statement, Flow) and statement.does == "sub":
                continue
            words = statement.words if isinstance(statement, Line) else ()
            if isinstance(statement, Line) and statement.wrong is not None:
                raise statement.wrong
            if words or isinstance(statement, Flow):
                first = words[0] if words else None
                raise statement.place.error(first.text if first else "O", AFTER_THE_END)

    def _parsed(self, path: Path) -> list[_Statement]:
        """Return the statements of a file, and keep its subroutines."""
        lines = iter(read_lines(path))
        outside, self._labels = self._labels, set()
        found, end = self._nested(lines, None)
        self._labels = outside
        if end is not None:
            # A line before it that is wrong may be what it ends.
            wrong = (line.wrong for line in found if isinstance(line, Line) and line.wrong is not None)
            raise next(wrong, end.place.error(f"O {end.does}", "ends what has not begun: remove it"))
        return found

    def _nested(
        self, lines: Iterator[_Statement], outer: Flow | None
    ) -> tuple[list[_Statement], Flow | None]:
        """Return the statements up to the end of ``outer``, and that end."""
        found: list[_Statement] = []
        for line in lines:
            self._held += 1
            if isinstance(line, Line):
                found.append(line)
                continue
            # A loop after do and one of its own look alike: its name tells.
            ends = outer is not None and line.does in _ENDS[outer.does]
            if ends and (line.does != "while" or (outer and _named(line) == _named(outer))):
                return found, line
            if line.does == "sub":
                outside, self._labels = self._labels, set()
                self._close(lines, line)
                self._labels = outside
                if _named(line) in self._subroutines:
                    raise line.place.error(f"O<{_named(line)}>", "a second subroutine of its name: keep one")
                self._subroutines[_named(line)] = line
            elif line.does in _ENDS:
                if _named(line) in self._labels:
                    raise line.place.error(f"O<{_named(line)}>", _SECOND)
                self._labels.add(_named(line))
                self._close(lines, line)
            elif line.does.startswith("end"):
                return found, line
            found.append(line)
        if outer is not None:
            raise outer.place.error(f"O {outer.does}", f"has no {_ENDS[outer.does][-1]}: add it")
        return found, None

    def _close(self, lines: Iterator[_Statement], flow: Flow) -> None:
        flow.body, end = self._nested(lines, flow)
        assert end is not None
        flow.end = end
        if end.does not in _ENDS[flow.does]:
            raise end.place.error(f"O {end.does}", f"{_ENDS[flow.does][-1]} expected: add it")
        if _named(end) != _named(flow):
            raise end.place.error(
                f"O {end.does}", f"ends what has another name, in line {flow.place.line}: correct it"
            )
        if end.does in ("elseif", "else"):
            self._close(lines, end)

    def _run(self, statements: Sequence[_Statement], top: bool = False) -> Iterator[Block]:
        for index, statement in enumerate(statements):
            self._count(statement)
            if isinstance(statement, Flow):
                yield from self._run_flow(statement)
                continue
            if top:
                self._next = index + 1
            yield self._block(statement)

    def _count(self, statement: _Statement) -> None:
        self._ran += 1
        if statement.place.path == self._path:
            self._line = statement.place.line
        if self._ran > self._held + _MOST_LINES:
            why = f"{_MOST_LINES} lines have run again, so the program does not end: correct its loops"
            raise statement.place.error("O" if isinstance(statement, Flow) else "line", why)

    def _block(self, line: Line) -> Block:
        if line.optional and self._skip:
            return Block(line.place, (), True, self._line)
        if line.wrong is not None:
            raise line.wrong
        memory, words = self._memory, list[Word]()
        try:
            keys = [key(memory) for key, _ in line.settings]
        except ValueError as error:
            raise line.place.error("#", str(error)) from error
        memory.being_set = frozenset(keys)
        for word in line.words:
            if isinstance(word, Word):
                words.append(word)
                continue
            value = self._value(line.place, word.text, word.value)
            words.append(Word(word.letter, value, word.text))
        for word in words:
            if not abs(word.value) <= LARGEST:
                raise line.place.error(word.text, f"more than {LARGEST:g}: correct it")
        # Values on a line are those from before it.
        given = [self._value(line.place, "#", value) for _, value in line.settings]
        memory.being_set = frozenset()
        for key, value in zip(keys, given, strict=True):
            try:
                memory.set(key, value)
            except ValueError as error:
                raise line.place.error("#", str(error)) from error
        return Block(line.place, tuple(words), line.optional, self._line)

    def _value(self, place: Place, text: str, value: Expression) -> Value:
        return self._taken(place, text, value, lambda found: found)

    def _taken(self, place: Place, text: str, value: Expression, take: Callable[[Value], Taken]) -> Taken:
        """Return what is taken from a value; raise InputError at its place where there is none."""
        try:
            return take(value(self._memory))
        except ValueError as error:
            raise place.error(text, str(error)) from error

    def _name(self, flow: Flow) -> str:
        try:
            name = flow.name(self._memory)
        except ValueError as error:
            raise flow.place.error("O", str(error)) from error
        if not _SUBROUTINE.fullmatch(name):
            raise flow.place.error("O", "a name of letters, digits, - and _, 1 to 64 of them: correct it")
        return name

    def _run_flow(self, flow: Flow) -> Iterator[Block]:
        does, memory = flow.does, self._memory
        if does == "call":
            yield from self._call(flow)
        elif does == "sub":
            # To a control the value of its end may be one that it returns.
            memory.common.pop("_value", None)
            self._defined.add(_named(flow))
        elif does == "return":
            self._returned(flow)
            raise _Return(flow.place)
        elif does in ("break", "continue"):
            raise _LoopLeft(flow.place, self._name(flow), does)
        elif does in ("if", "elseif"):
            if self._taken(flow.place, "O", flow.values[0], truth):
                yield from self._run(flow.body)
            elif flow.end is not None and flow.end.does != "endif":
                yield from self._run_flow(flow.end)
        elif does == "else":
            yield from self._run(flow.body)
        else:
            yield from self._loop(flow)

    def _loop(self, flow: Flow) -> Iterator[Block]:
        assert flow.end
        name, left = self._name(flow), 0
        if flow.does == "repeat":
            if id(flow) in self._repeating:
                raise flow.place.error("O", f"repeats while it does already: {_COUNT_KEPT}")
            left = self._taken(flow.place, "O", flow.values[0], times)
            if left > _MOST_LINES:
                raise flow.place.error("O", f"repeats more than {_MOST_LINES} times: correct it")
        first = flow.does == "do"
        while True:
            if flow.does == "repeat":
                left -= 1
                again = left >= 0
            else:
                condition = flow.end.values if flow.does == "do" else flow.values
                again = first or self._taken(flow.place, "O", condition[0], truth)
            if flow.does == "do" and not first:
                if again and self._broken:
                    raise flow.end.place.error("O", _BREAK_KEPT)
                self._broken = False
            if not again:
                self._broken |= flow.does == "while" and flow.breaks
                return
            first = False
            # An empty loop that does not end has lines, too.
            self._count(flow)
            self._repeating |= {id(flow)} if flow.does == "repeat" else set()
            try:
                yield from self._run(flow.body)
            except (_LoopLeft, _Return) as leave:
                ours = isinstance(leave, _LoopLeft) and leave.args[1] == name
                if not ours and flow.does == "repeat":
                    place: Place = leave.args[0]
                    raise place.error("O", f"leaves a repeat before its end: {_COUNT_KEPT}") from leave
                if not ours:
                    raise
                self._left(flow, leave.args[0], leave.args[2])
                if leave.args[2] == "break":
                    return
            finally:
                self._repeating.discard(id(flow))

    def _left(self, flow: Flow, place: Place, does: str) -> None:
        """Note what a control makes of a break or continue; raise InputError where it goes elsewhere."""
        if flow.does == "repeat":
            raise place.error("O", f"{does} {_NOT_OF_REPEATS}")
        if flow.does == "do" and does == "continue":
            raise place.error("O", f"{does} {_CONTINUE_KEPT}")
        self._broken = flow.does == "while" and (does == "break" or self._broken or flow.breaks)

    def _call(self, flow: Flow) -> Iterator[Block]:
        memory = self._memory
        name = self._name(flow)
        beside = self._path.parent / f"{name}.ngc"
        if name not in self._subroutines:
            if beside.exists():
                self._parsed(beside)
        elif beside.exists():
            held = self._subroutines[name].place.path
            if held not in (self._path, beside):
                why = _OTHER_PLACE.format(held.name, beside.name)
                raise flow.place.error(f"O<{name}>", why)
            if held == self._path and name not in self._defined:
                raise flow.place.error(f"O<{name}>", BOTH_PLACES.format(beside.name))
        subroutine = self._subroutines.get(name)
        if subroutine is None or subroutine.end is None:
            raise flow.place.error(f"O<{name}>", f"no such subroutine here or in {name}.ngc: add it")
        self._depth += 1
        if self._depth > _MOST_CALLS:
            raise flow.place.error(f"O<{name}>", f"more than {_MOST_CALLS} calls within calls: correct it")
        values = [self._value(flow.place, "O", value) for value in flow.values]
        # What the last call returned a control has until the next value; here it is known after its own.
        memory.common.pop("_value", None)
        # What is not given has no value: to some controls it is 0, to others what the caller has.
        memory.frames.append(dict(enumerate(values, 1)))
        try:
            yield from self._run(subroutine.body)
            self._returned(subroutine.end)
        except _Return:
            pass
        finally:
            memory.frames.pop()
            self._depth -= 1

    def _returned(self, flow: Flow) -> None:
        """Take what a subroutine returns, where its end says it."""
        if flow.values:
            self._memory.common["_value"] = self._value(flow.place, "O", flow.values[0])
        else:
            self._memory.common.pop("_value", None)


def _numeral(value: Value) -> str:
    number = exact(value)
    if number.denominator != 1:
        raise ValueError("a name that is a number is a whole one: correct it")
    return str(int(number))


def _has_break(flow: Flow, name: str) -> bool:
    for statement in flow.body:
        part = statement if isinstance(statement, Flow) else None
        while part is not None:
            if part.does == "break" and _named(part) in (name, f"line {part.place.line}"):
                return True
            if _has_break(part, name):
                return True
            part = part.end
    return False


def _named(flow: Flow) -> str:
    """Return a name that is known without running the program; a place for any other."""
    try:
        return flow.name(Memory(lambda _: None))
    except ValueError:
        return f"line {flow.place.line}"
