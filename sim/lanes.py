"""Many cores in lockstep: rewrites the C++ of one core so that each statement is a loop over lanes.

Every signal becomes an array with one element a lane, every assignment a loop that the compiler turns into
vector instructions. What a lane does is what Verilator's statements say: no more is understood of them than
where they begin and end, and which signals they name. What is not understood is refused.
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import ToldError

_ROOT = "Vtop___024root"
_SCALARS = {"CData": "IData", "SData": "IData", "IData": "IData", "QData": "QData"}
_PORTS = {"8": "IData", "16": "IData", "": "IData", "64": "QData", "W": "IData"}

_PORT = re.compile(r"\s*VL_(?:IN|OUT)(8|16|64|W|)\((\w+),\d+,\d+(?:,(\d+))?\);")
_MEMBER = re.compile(r"\s*((?:VlUnpacked<)*)(CData|SData|IData|QData)/\*[\d:]*\*/((?:, \d+>)*) (\w+);")
_FUNCTION = re.compile(rf"^void {_ROOT}___(\w+)\({_ROOT}\* vlSelf\) {{\n(.*?)^}}\n", re.S | re.M)
_LOCAL = re.compile(r"(?:CData|SData|IData)/\*[\d:]*\*/ (\w+);")
_CALL = re.compile(rf"{_ROOT}___(\w+)\(vlSelf\);")
_TRIGGERED = re.compile(r"\((\d+)ULL & vlSelfRef\.__VnbaTriggered\[0U\]\)")
_SIGNAL = re.compile(r"vlSelfRef\.(\w+)")
_TARGET = re.compile(r"(vlSelfRef\.\w+\s*(\[.*\])?|__V\w+)\s*", re.S)
_WHOLE = re.compile(r"\s*vlSelfRef\.\w+(\s*\[\d+U\])*")
_INDEX = re.compile(r"\s*\[")
# Of the simulator's own, and not of the design.
_SCHEDULING = re.compile(r"__V(ico|act|nba|stl)\w*|__Vtrigprev\w*")
_SPACE, _ELSE = re.compile(r"\s*(?=\S)"), re.compile(r"\s*else\s*")
_LOCAL_NAME = re.compile(r"\b__V\w+\b")
# A rising clock is the first of what is waited for.
_CLOCK = 1
# Loops in a function.
_PART = 200


class LanesError(ToldError, ValueError):
    """Verilator wrote something that is not understood here."""


@dataclass(frozen=True)
class _Member:
    """A signal: the type of an element of it, and its dimensions."""

    kind: str
    dims: tuple[int, ...]


@dataclass(frozen=True)
class _If:
    """A statement that branches."""

    condition: str
    then: str
    otherwise: str


def write_lanes(model: Path, lanes: int) -> None:
    """Write Vtop_lanes.h beside the C++ of a model: struct Lanes, and what a clock does with it.

    Raises LanesError where the C++ has something that is not understood.
    """
    header = (model / f"{_ROOT}.h").read_text(encoding="utf-8")
    sources = sorted(model.glob(f"{_ROOT}__*.cpp"))
    code = "".join(path.read_text(encoding="utf-8") for path in sources if "Slow" not in path.stem)
    writer = _Writer(_members(header), dict(_FUNCTION.findall(code)))
    (model / "Vtop_lanes.h").write_text(writer.written(lanes), encoding="utf-8")


def _members(header: str) -> dict[str, _Member]:
    members = {}
    for line in header.splitlines():
        if found := _PORT.fullmatch(line):
            size, name, words = found.groups()
            members[name] = _Member(_PORTS[size], (int(words),) if words else ())
        elif found := _MEMBER.fullmatch(line):
            depth, kind, dims, name = found.groups()
            # Verilator names the dimensions from the inside.
            sizes = tuple(int(size) for size in re.findall(r"\d+", dims))[::-1]
            if len(sizes) == depth.count("<") and not _SCHEDULING.fullmatch(name):
                members[name] = _Member(_SCALARS[kind], sizes)
    return members


def _closing(text: str, start: int) -> int:
    """Return the place behind the bracket that closes the one at ``start``."""
    opened = text[start]
    closed = {"(": ")", "[": "]", "{": "}"}[opened]
    depth = 0
    for place in range(start, len(text)):
        depth += (text[place] == opened) - (text[place] == closed)
        if not depth:
            return place + 1
    raise LanesError(f"lanes: a bracket that does not close: {text[start : start + 80]}")


def _block(text: str, start: int) -> tuple[str, int]:
    """Return what stands in the braces at ``start``, and the place behind them."""
    end = _closing(text, start)
    return text[start + 1 : end - 1], end


def _statements(text: str) -> Iterator[str | _If]:
    """Yield the statements of a block: texts without the semicolon, and branches."""
    place = 0
    while match := _SPACE.match(text, place):
        place = match.end()
        if text.startswith("if ", place):
            end = _closing(text, text.index("(", place))
            condition = text[text.index("(", place) : end]
            then, place = _block(text, text.index("{", end))
            otherwise = ""
            if follows := _ELSE.match(text, place):
                place = follows.end()
                if text.startswith("if ", place):
                    # All that belongs to the second one is in the other branch.
                    end = _end_of_if(text, place)
                    otherwise, place = text[place:end], end
                else:
                    otherwise, place = _block(text, place)
            yield _If(condition, then, otherwise)
            continue
        end = text.find(";", place)
        if end < 0:
            raise LanesError(f"lanes: no end of a statement: {text[place : place + 80]}")
        if statement := text[place:end].strip():
            yield statement
        place = end + 1


def _end_of_if(text: str, place: int) -> int:
    while True:
        end = _closing(text, text.index("{", _closing(text, text.index("(", place))))
        follows = _ELSE.match(text, end)
        if not follows:
            return end
        place = follows.end()
        if not text.startswith("if ", place):
            return _closing(text, place)


class _Writer:
    """Rewrites the functions of a model."""

    def __init__(self, members: dict[str, _Member], functions: dict[str, str]) -> None:
        self._members, self._functions = members, functions
        self._lines: list[str] = []
        # Signals of the functions themselves, and conditions.
        self._locals: set[str] = set()

    def written(self, lanes: int) -> str:
        """Return the text of the header."""
        inputs = self._function("Inputs", "ico_sequent__TOP__0")
        clock = self._function("Clock", "eval_nba")
        signals = {**self._members, **dict.fromkeys(sorted(self._locals), _Member("IData", ()))}
        fields = "".join(
            f"  alignas(64) {signal.kind} {name}{''.join(f'[{size}]' for size in signal.dims)}[kLanes];\n"
            for name, signal in signals.items()
        )
        copies = "".join(
            f"  for (int l = 0; l < kLanes; ++l) to.{name}{index}[l] = from.{name}{index};\n"
            for name, member in self._members.items()
            for index in _indices(member.dims)
        )
        return (
            "// Written by sim/lanes.py.\n"
            f'#include "{_ROOT}.h"\n\n'
            f"constexpr int kLanes = {lanes};\n\n"
            f"struct Lanes {{\n{fields}}};\n\n"
            f"static void Copy(Lanes& __restrict to, const {_ROOT}& from) {{\n{copies}}}\n\n"
            f"{inputs}\n{clock}"
        )

    def _function(self, name: str, of: str) -> str:
        """Return the text of a function, in parts: thousands of loops in one take a compiler very long."""
        self._lines = []
        self._walk(self._body(of), "")
        parts = [self._lines[start : start + _PART] for start in range(0, len(self._lines), _PART)]
        text = "".join(
            f"[[gnu::noinline]] static void {name}{number}(Lanes& __restrict s) {{\n{''.join(part)}}}\n\n"
            for number, part in enumerate(parts)
        )
        calls = "".join(f"  {name}{number}(s);\n" for number in range(len(parts)))
        return f"{text}static void {name}(Lanes& s) {{\n{calls}}}\n"

    def _body(self, name: str) -> str:
        if name not in self._functions:
            raise LanesError(f"lanes: no function {name} in the model")
        head, _, body = self._functions[name].partition("// Body\n")
        self._locals |= {*_LOCAL.findall(head)}
        return body

    def _walk(self, block: str, condition: str) -> None:
        """Write the loops of a block. ``condition``: the signal under which it is done, "" for always."""
        for statement in _statements(block):
            if isinstance(statement, _If):
                self._branch(statement, condition)
            elif called := _CALL.fullmatch(f"{statement};"):
                self._walk(self._body(called[1]), condition)
            else:
                self._assign(statement, condition)

    def _branch(self, statement: _If, condition: str) -> None:
        if triggers := _TRIGGERED.fullmatch(_inside(statement.condition)):
            # Only the clock moves.
            if int(triggers[1]) & _CLOCK:
                self._walk(statement.then, condition)
            return
        above = f"s.{condition}[l] && " if condition else ""
        # Once, before what is assigned under it changes what it asks for.
        then = self._condition(f"{above}{self._named(statement.condition)}")
        self._walk(statement.then, then)
        if statement.otherwise:
            self._walk(statement.otherwise, self._condition(f"{above}!s.{then}[l]"))

    def _condition(self, value: str) -> str:
        name = f"condition_{len(self._locals)}"
        self._locals.add(name)
        # A condition may have more bits than what keeps it.
        self._loop(f"s.{name}[l] = ({value}) != 0")
        return name

    def _assign(self, statement: str, condition: str) -> None:
        target, equals, value = statement.partition("=")
        if not equals or not _TARGET.fullmatch(target):
            raise LanesError(f"lanes: a statement that is no assignment: {statement[:80]}")
        for index in self._whole(target, value):
            to, what = self._named(target + index), self._named(value + index)
            # What is assigned in every case becomes a choice, without branches.
            self._loop(f"{to} = s.{condition}[l] ? ({what}) : {to}" if condition else f"{to} = {what}")

    def _whole(self, target: str, value: str) -> list[str]:
        """Return the indices of all elements where a whole array is assigned, one empty index otherwise."""
        found = _SIGNAL.match(target.strip())
        if not found:
            return [""]
        given = len(self._split(target.strip(), found)[0])
        dims = self._members[found[1]].dims[given:]
        if dims and not _WHOLE.fullmatch(value):
            raise LanesError(f"lanes: an array is assigned what is none: {target.strip()[:80]}")
        return _indices(dims)

    def _split(self, text: str, found: re.Match[str]) -> tuple[list[str], int]:
        """Return the indices behind a signal's name, and the place behind them."""
        if found[1] not in self._members:
            raise LanesError(f"lanes: an unknown signal: {found[1]}")
        indices: list[str] = []
        place = found.end()
        while len(indices) < len(self._members[found[1]].dims):
            opening = _INDEX.match(text, place)
            if not opening:
                break
            end = _closing(text, opening.end() - 1)
            indices.append(text[opening.end() : end - 1])
            place = end
        return indices, place

    def _named(self, text: str) -> str:
        """Return an expression with the element of a lane for every signal."""
        out, place = "", 0
        while found := _SIGNAL.search(text, place):
            indices, end = self._split(text, found)
            if len(indices) != len(self._members[found[1]].dims):
                raise LanesError(f"lanes: a whole array in an expression: {found[1]}")
            inner = "".join(f"[{self._named(index)}]" for index in indices)
            out += self._local(text[place : found.start()]) + f"s.{found[1]}{inner}[l]"
            place = end
        return re.sub(r"\s+", " ", (out + self._local(text[place:])).strip())

    def _local(self, text: str) -> str:
        return _LOCAL_NAME.sub(
            lambda found: f"s.{found[0]}[l]" if found[0] in self._locals else found[0], text
        )

    def _loop(self, statement: str) -> None:
        self._lines.append(f"  for (int l = 0; l < kLanes; ++l) {statement};\n")


def _inside(condition: str) -> str:
    """Return a condition without the brackets around all of it, but for its own."""
    condition = re.sub(r"\s+", " ", condition.strip())
    return condition[1:-1].strip() if condition.startswith("((") else condition


def _indices(dims: tuple[int, ...]) -> list[str]:
    """Return the indices of all elements of an array."""
    indices = [""]
    for size in dims:
        indices = [f"{index}[{number}U]" for index in indices for number in range(size)]
    return indices
