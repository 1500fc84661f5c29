"""Waivers: bins of code coverage that need not be hit, each with the reason why none can hit them.

A waiver says where it applies (modules, instances, models, a condition on parameters) and what it
covers there. For toggles it gives the values that a signal can have, ``range`` and ``step``, as
expressions in the parameters, and from these follows which bits are constant: only they are waived. So
the proof that a reviewer checks is a bound, not a list of bits, and one waiver holds for every width.

Fields of a waiver (coverage/waivers.toml):

    category    why such bins exist at all: one of CATEGORIES
    reason      the proof
    owner       who answers for it (dut)
    rests_on    names of modules that the proof speaks of, where they are others (modules)
    kind        line, branch, expression, toggle, fsm, antecedent, generate
    modules     names of modules
    instances   patterns of paths, one must fit (all)
    models      patterns of names of models (all)
    where       a condition on the parameters (always)
    let         names for expressions, usable in those after it
    what        patterns of bins, one must fit: not for toggles
    at          patterns, one must fit the line of the source, but for spaces around it: not for toggles (any)
    signals     patterns of signals, one must fit: toggles
    range       the smallest and the largest value, or
    bits        the numbers of the constant bits, as in ["4..7", "12"], all of which exist: toggles
    step        what every value is a multiple of, a power of two (1): toggles with range

In a pattern ``*`` stands for anything, ``{name}`` for a number that expressions then know by that
name. Expressions know the parameters of the instance and of all around it, and of the top: W, M,
L = 2^W - 1 and margin = 2^M - 1, the largest.

A table ``reviewed`` holds the hash of each module that they speak of, as it was when their proofs were read
against it last, see `module_hash`.

Expressions are whole-number arithmetic. Operators: + - * // % ** << >>, comparisons (1 or 0), and, or, not,
parentheses. Nothing else: no calls, no attributes, no real numbers.
"""

import ast
import hashlib
import re
import tomllib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from types import CodeType
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.input_file import read_input
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import DUT


class BoundError(ValueError):
    """The text is no such expression, or has no value."""


_ARITHMETIC = (
    ast.Expression, ast.Constant, ast.Name, ast.Load, ast.UnaryOp, ast.USub, ast.Not,
    ast.BoolOp, ast.And, ast.Or, ast.Compare, ast.Eq, ast.NotEq, ast.Lt, ast.LtE, ast.Gt, ast.GtE,
    ast.BinOp, ast.Add, ast.Sub, ast.Mult, ast.FloorDiv, ast.Mod, ast.Pow, ast.LShift, ast.RShift,
)  # fmt: skip


@cache
def _compiled(text: str) -> CodeType:
    """Compile an expression that holds nothing but arithmetic; raise BoundError for any other."""
    try:
        tree = ast.parse(text, mode="eval")
    except SyntaxError as error:
        raise BoundError(f"{text}: not an expression") from error
    for node in ast.walk(tree):
        whole = not isinstance(node, ast.Constant) or type(node.value) is int
        if not isinstance(node, _ARITHMETIC) or not whole:
            raise BoundError(f"{text}: not allowed in a bound: {type(node).__name__}")
    return compile(tree, text, "eval")


def evaluate(text: str, variables: Mapping[str, int]) -> int:
    """Return the value of an expression; raise BoundError where it has none."""
    code = _compiled(text)
    try:
        value = eval(code, {"__builtins__": {}}, dict(variables))
    except NameError as error:
        raise BoundError(f"{error.name}: no such parameter here") from error
    except (ArithmeticError, TypeError, ValueError) as error:
        raise BoundError(f"{text}: {error}") from error
    if not isinstance(value, int):
        raise BoundError(f"{text}: no whole number")
    return int(value)


WAIVERS = Path(__file__).with_name("waivers.toml")

# Why there are bins that nothing can hit; every waiver is of one of these.
CATEGORIES = {
    "constant by contract": "the value is fixed in every build: a literal, a reserved bit, the origin",
    "constant by parameter": "the parameters of a build leave nothing to change or to run",
    "ruled out": "the logic around it never lets it happen, by an argument that names what does not",
    "beyond simulation": "it takes more clocks than any run has; what else shows that it is right is named",
    "bounded": "the width holds more than the largest value that can occur, by a bound that is proved",
    "split operand": "a piece of an operand that is multiplied in pieces fills its port only in part",
    "unused input": "an input that the contract has and the logic does not need",
    "parity": "a parity has more ways than can be counted; what it shows is tried bit by bit",
    "elaboration guard": "a block that refuses parameters, so that no build has it",
}
KINDS = ("line", "branch", "expression", "toggle", "fsm", "antecedent", "generate")
_REQUIRED = ("category", "reason", "kind", "modules")
_INCLUDED = re.compile(r'^\s*`include\s+"([^"]+)"', re.MULTILINE)
_COMMENTS = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
_SHORTEST_REASON = 20
# The table, to the next one or the end.
_REVIEWED = re.compile(r"^\[reviewed\]\n(?:[^\[].*\n|\n)*", re.MULTILINE)


@cache
def _pattern(text: str) -> re.Pattern[str]:
    """Return the regular expression of a pattern; see the module's docstring."""
    parts = re.split(r"(\*|\{\w+\})", text)
    return re.compile("".join(map(_part, parts)), re.DOTALL)


def _part(part: str) -> str:
    if part == "*":
        return ".*"
    if part.startswith("{") and part.endswith("}"):
        return rf"(?P<{part[1:-1]}>\d+)"
    return re.escape(part)


def fit(patterns: tuple[str, ...], text: str) -> dict[str, int] | None:
    """Return the numbers in ``text`` by name, from the first pattern that fits; None where none does."""
    for pattern in patterns:
        if match := _pattern(pattern).fullmatch(text):
            return {name: int(number) for name, number in match.groupdict().items()}
    return None


@dataclass(frozen=True)
class Waiver:
    """One waiver; see the module's docstring. ``number`` counts from 1 in the file.

    ``values`` is the field ``range`` of the file; ``reviewed`` has the modules that the proof speaks of.
    """

    number: int
    category: str
    reason: str
    kind: str
    modules: tuple[str, ...]
    owner: str = "dut"
    instances: tuple[str, ...] = ("*",)
    models: tuple[str, ...] = ("*",)
    where: str = "1"
    let: Mapping[str, str] = field(default_factory=dict)
    what: tuple[str, ...] = ()
    at: tuple[str, ...] = ("*",)
    signals: tuple[str, ...] = ()
    values: tuple[str, str] | None = None
    bits: tuple[str, ...] = ()
    step: str = "1"
    rests_on: tuple[str, ...] = ()
    reviewed: Mapping[str, str] = field(default_factory=dict)

    def hashes(self, code: Mapping[str, str]) -> dict[str, str]:
        """Return the hash of each module that the proof speaks of, in the RTL as `module_code` gives it."""
        return {name: module_hash(name, code) for name in self.rests_on or self.modules}

    @property
    def name(self) -> str:
        """Return how messages call it."""
        return f"waiver {self.number} ({self.kind}, {', '.join(self.modules)})"

    def _variables(self, known: Mapping[str, int]) -> dict[str, int] | None:
        """Return the variables with those of ``let``, None where the condition does not hold."""
        variables = dict(known)
        if not evaluate(self.where, variables):
            return None
        for name, text in self.let.items():
            variables[name] = evaluate(text, variables)
        return variables

    def applies(self, model: str, instance: str) -> dict[str, int] | None:
        """Return the numbers in the instance's path, None where the waiver is not for it."""
        return None if fit(self.models, model) is None else fit(self.instances, instance)

    def waives(self, what: str, known: Mapping[str, int], line: str = "") -> bool:
        """Return whether it covers a bin that is no toggle; ``line``: of the source."""
        numbers = fit(self.what, what)
        return (
            numbers is not None
            and fit(self.at, line) is not None
            and self._variables({**known, **numbers}) is not None
        )

    def constant_bits(self, signal: str, bits: range, known: Mapping[str, int]) -> list[int]:
        """Return which of the bits of a signal it says are constant; bit 0 for a signal without range."""
        numbers = fit(self.signals, signal)
        if numbers is None:
            return []
        variables = self._variables({**known, **numbers})
        if variables is None:
            return []
        places = bits or range(1)
        if self.values is None:
            listed = set(_listed(self.bits, variables))
            beyond = sorted(listed.difference(places))
            if beyond:
                raise BoundError(f"{signal} has no bit {beyond[0]}")
            return [bit for bit in places if bit in listed]
        low, high, step = (evaluate(text, variables) for text in (*self.values, self.step))
        if low > high or step < 1 or step & (step - 1):
            raise BoundError(f"{signal}: range {low}..{high} in steps of {step}")
        # Over consecutive values bit b changes exactly where value >> b does; below the step it is 0.
        first = bits.start
        return [b for b in places if low >> (b - first) == high >> (b - first) or 1 << (b - first) < step]


def _listed(texts: tuple[str, ...], variables: Mapping[str, int]) -> Iterator[int]:
    for text in texts:
        first, _, last = text.partition("..")
        yield from range(evaluate(first, variables), evaluate(last or first, variables) + 1)


def _texts(value: Any) -> tuple[str, ...]:
    if not isinstance(value, list) or not value or not all(isinstance(text, str) for text in value):
        raise ValueError("must be a list of texts")
    return tuple(value)


def _patterns(value: Any) -> tuple[str, ...]:
    found = _texts(value)
    for text in found:
        try:
            _pattern(text)
        except re.error as error:
            raise ValueError(f"{text}: {error.msg}: no pattern") from error
    return found


def _bounds(value: Any) -> tuple[str, str]:
    match _texts(value):
        case (low, high):
            return low, high
        case _:
            raise ValueError("must be two texts, the smallest and the largest value")


def _text(value: Any) -> str:
    if not isinstance(value, str) or not value.strip():
        raise ValueError("must be a text")
    return value


def _named(value: Any) -> dict[str, str]:
    if not isinstance(value, dict):
        raise ValueError("must be a table")
    return {name: _text(text) for name, text in value.items()}


_READERS = {
    **dict.fromkeys(("category", "reason", "owner", "kind", "where", "step"), _text),
    **dict.fromkeys(("modules", "instances", "models", "what", "at", "signals"), _patterns),
    **dict.fromkeys(("bits", "rests_on"), _texts),
    "range": _bounds,
    "let": _named,
}


def _waiver(number: int, entry: Any, reviewed: Mapping[str, str], path: Path) -> Waiver:
    place = f"{path}: waiver {number}"
    if not isinstance(entry, dict):
        raise InputError(f"{place}: must be a table")
    fields: dict[str, Any] = {}
    for name, value in entry.items():
        if name not in _READERS:
            raise InputError(f"{place}: {name}: no such field; one of: {', '.join(_READERS)}")
        try:
            fields[name] = _READERS[name](value)
        except ValueError as error:
            raise InputError(f"{place}: {name}: {error}") from error
    for name in _REQUIRED:
        if name not in fields:
            raise InputError(f"{place}: {name} is missing")
    if fields["category"] not in CATEGORIES:
        raise InputError(f"{place}: category {fields['category']}: one of: {', '.join(CATEGORIES)}")
    if fields["kind"] not in KINDS:
        raise InputError(f"{place}: kind {fields['kind']}: one of: {', '.join(KINDS)}")
    if len(fields["reason"].strip()) < _SHORTEST_REASON:
        raise InputError(f"{place}: reason: say why no input can hit these bins")
    _check_subject(fields, place)
    if "range" in fields:
        fields["values"] = fields.pop("range")
    spoken_of = fields.get("rests_on") or fields["modules"]
    known = {name: reviewed[name] for name in spoken_of if name in reviewed}
    return Waiver(number, **fields, reviewed=known)


def _check_subject(fields: dict[str, Any], place: str) -> None:
    given = {name for name in ("what", "signals", "range", "bits") if name in fields}
    if fields["kind"] != "toggle":
        if given != {"what"}:
            raise InputError(f"{place}: no toggle waiver: has `what`, no `signals`, `range` or `bits`")
    elif given not in ({"signals", "range"}, {"signals", "bits"}):
        raise InputError(f"{place}: a toggle waiver has `signals`, and either `range` or `bits`")


def module_code(dut: Path = DUT) -> dict[str, str]:
    """Return the RTL of each module, with the headers that it includes, without comments and spacing, in the
    order of the files.
    """
    headers = {one.name: one.read_text("utf-8") for one in sorted(dut.rglob("*.svh"))}
    found: dict[str, str] = {}
    for one in sorted(dut.rglob("*.sv")):
        text = one.read_text("utf-8")
        included = (headers.get(name, "") for name in _INCLUDED.findall(text))
        found[one.stem] = " ".join(_COMMENTS.sub(" ", "\n".join((text, *included))).split())
    return found


def module_hash(module: str, code: Mapping[str, str]) -> str:
    """Return a short hash of the RTL of a module; ``*``: of all."""
    found = " ".join(code.values()) if module == "*" else code.get(module, "")
    return hashlib.sha256(found.encode()).hexdigest()[:12]


def confirm_waivers(path: Path = WAIVERS, dut: Path = DUT) -> int:
    """Write into the file that the reasons were read against the RTL as it is; return how many changed."""
    waivers = read_waivers(path)
    code = module_code(dut)
    hashes = [waiver.hashes(code) for waiver in waivers]
    known = {name: text for one in hashes for name, text in one.items()}
    lines = [f'"{name}" = "{known[name]}"' for name in sorted(known)]
    text = _REVIEWED.sub("", path.read_text(encoding="utf-8"))
    write_whole(path, "\n".join((f"{text.rstrip()}\n", "[reviewed]", *lines, "")))
    return sum(waiver.reviewed != now for waiver, now in zip(waivers, hashes, strict=True))


def read_waivers(path: Path = WAIVERS) -> list[Waiver]:
    """Read the waivers; raise InputError naming the first that is not well formed."""
    data = read_input(path)
    try:
        content = tomllib.loads(data.decode())
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: not TOML: {error}") from error
    entries, reviewed = content.get("waiver", []), content.get("reviewed", {})
    if content.keys() - {"waiver", "reviewed"} or not isinstance(entries, list):
        raise InputError(f"{path}: must hold [[waiver]] tables, one [reviewed], and nothing else")
    try:
        hashes = _named(reviewed)
    except ValueError as error:
        raise InputError(f"{path}: reviewed: {error}") from error
    return [_waiver(number, entry, hashes, path) for number, entry in enumerate(entries, 1)]
