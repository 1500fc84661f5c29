"""Parameters and expressions of a program: `#1`, `#<name>`, `[..]`, functions.

They mean what they do to the interpreter of LinuxCNC (its manual, "G code: overview"), the only public one
that says all of it: expressions are evaluated in double precision, as a control does, so that a loop ends
where the control's ends. A number that stands alone stays the exact decimal that it is.

Of some numbers a control may have other last digits: of where it is, which it adds up in its own order and
unit, and of sines, powers, .., which no two libraries compute alike. They are `Approximate`, as is what is
computed with them, and no step may hang on those digits: a comparison, a rounding, the sign of a zero.
"""

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from fractions import Fraction

from triaxis.golden.exact import Rational

Value = Fraction | float
# The number of a parameter, or its name.
Key = int | str

# Digits of a number: more than any control takes, few enough to keep exact sums small.
_DIGITS = 18
NUMBER = r"\d+\.?\d*|\.\d+"
_NUMBER, _NAME = re.compile(NUMBER, re.ASCII), re.compile(r"<([^<>\[\]#]+)>")
_OPERATOR = re.compile(r"\*\*|[-+*/]|(?:mod|and|xor|or|eq|ne|gt|ge|lt|le)", re.IGNORECASE)
_WORD = re.compile(r"[a-z]+", re.IGNORECASE)
# Numbers nearer than this are equal to some controls, and to some versions of one, and not to others.
_EQUAL = 1e-4
# Positions and functions differ by less than 10^-10: made so many times as large, by less than `_EQUAL`.
_SCALED = 1e6
# Of a number that moves anything: beyond it no machine goes, and double precision is coarse.
LARGEST = 10**9
# Of a parameter that only what ran before could tell.
NO_VALUE = "has a value that the program does not give it: set it before"
# Parameters that belong to a subroutine: its arguments.
ARGUMENTS = 30
_LARGEST_PARAMETER = 5601
# Names whose values the control alone gives (LinuxCNC's manual, G code: overview).
_CONTROLS_OWN = (
    "vmajor vminor metric_machine line motion_mode plane ccomp metric imperial absolute incremental "
    "inverse_time units_per_minute units_per_rev coord_system tool_offset retract_r_plane retract_old_z "
    "spindle_rpm_mode spindle_css_mode ijk_absolute_mode lathe_diameter_mode lathe_radius_mode "
    "spindle_on spindle_cw mist flood speed_override feed_override adaptive_feed feed_hold feed rpm "
    "current_tool current_pocket selected_pocket selected_tool x y z a b c u v w abs_x abs_y abs_z abs_a "
    "abs_b abs_c abs_u abs_v abs_w value value_returned task call_level remap_level"
)
CONTROL_NAMES = frozenset(f"_{name}" for name in _CONTROLS_OWN.split())


def exact(value: Value) -> Fraction:
    """Return a value as a decimal number: a computed one to 10^-9, which its error may exceed anyway.

    Raises ValueError where no machine has such a number.
    """
    if not abs(value) <= LARGEST:
        raise ValueError(f"more than {LARGEST:g}: correct it")
    return Rational(round(value * 10**9), 10**9) if isinstance(value, (float, int)) else value


class Approximate(float):
    """A number of which controls have different last digits."""


class NoParameterError(ValueError):
    """A number that no parameter has."""


class InexactError(ValueError):
    """A comparison, or a rounding, whose outcome controls differ in."""


@dataclass
class Memory:
    """What parameters hold. ``ask``: what those of the control do (its position, ..), None for any other.

    Names without a leading _ and the arguments belong to the subroutine that runs.
    """

    ask: Callable[[Key], Value | None]
    common: dict[Key, Value] = field(default_factory=dict)
    frames: list[dict[Key, Value]] = field(default_factory=lambda: [{}])
    # What the line sets that is being read.
    being_set: frozenset[Key] = frozenset()

    def _of(self, key: Key) -> dict[Key, Value]:
        own = key <= ARGUMENTS if isinstance(key, int) else not key.startswith("_")
        return self.frames[-1] if own else self.common

    def exists(self, key: Key) -> bool:
        """Return whether there is such a parameter; ValueError for a name that only the control may know."""
        if isinstance(key, int) or key in self._of(key) or self.ask(key) is not None:
            return True
        if key.startswith("_"):
            raise ValueError(f"#<{key}> may be the control's: set it before")
        if key in self.being_set:
            raise ValueError(f"#<{key}> is set on the very line that asks for it: ask on a line before")
        return False

    def get(self, key: Key) -> Value:
        """Return a parameter's value; raise ValueError where it has none that is known."""
        if (value := self._of(key).get(key)) is not None:
            return value
        if (value := self.ask(key)) is not None:
            return value
        shown = f"#{key}" if isinstance(key, int) else f"#<{key}>"
        raise ValueError(f"{shown} {NO_VALUE}")

    def set(self, key: Key, value: Value) -> None:
        """Give a parameter a value; raise ValueError where the control alone does."""
        if isinstance(key, int) and not 1 <= key < 5000:
            raise ValueError(f"#{key} is the control's own: set none but #1 to #4999")
        if key in CONTROL_NAMES:
            raise ValueError(f"#<{key}> is the control's own: take another name")
        self._of(key)[key] = value


Expression = Callable[[Memory], Value]


@dataclass(frozen=True)
class Parameter:
    """A parameter as it stands in a text, from ``start`` to ``end``. ``key``: None where it is computed.

    ``asked``: whether it exists is what is asked, by the EXISTS around it.
    """

    key: Key | None
    start: int
    end: int
    asked: bool = False


def number(text: str) -> Fraction:
    """Return a decimal; raise ValueError where it has more digits than any control takes."""
    whole, _, part = text.partition(".")
    if len((whole + part).lstrip("+-0")) > _DIGITS or len(part) > 2 * _DIGITS:
        raise ValueError(f"more than {_DIGITS} digits: round it")
    return Rational(int(whole + part), 10 ** len(part)) if part else Rational(int(whole))


@dataclass
class Scanner:
    """Reads values from a text, one after another, from ``at`` on. All of it raises ValueError.

    ``parameters``: those that have been read.
    """

    text: str
    at: int = 0
    parameters: list[Parameter] = field(default_factory=list)

    def blanks(self) -> str:
        """Go to the next character that is not blank; return it, or nothing at the end."""
        while self.text[self.at : self.at + 1] in (" ", "\t"):
            self.at += 1
        return self.text[self.at : self.at + 1]

    def expect(self, character: str, what: str) -> None:
        """Read one character."""
        if self.blanks() != character:
            raise ValueError(f"{what}: add '{character}'")
        self.at += 1

    def _match(self, pattern: re.Pattern[str]) -> str | None:
        self.blanks()
        if match := pattern.match(self.text, self.at):
            self.at = match.end()
            return match[0]
        return None

    def value(self) -> Expression:
        """Read a number, a parameter, an expression in brackets, or a function of one."""
        sign = self.blanks()
        if sign and sign in "+-":
            self.at += 1
            inner = self.value()
            return inner if sign == "+" else lambda memory: _negated(inner(memory))
        if text := self._match(_NUMBER):
            found = number(text)
            return lambda _: found
        if sign == "#":
            key = self.parameter()
            return lambda memory: memory.get(key(memory))
        if sign == "[":
            return self.bracket()
        if name := self._match(_WORD):
            return self._function(name.lower())
        raise ValueError("no decimal number: give one")

    def bracket(self) -> Expression:
        """Read an expression in brackets."""
        self.expect("[", "an expression stands in brackets")
        inner = self._binary(0)
        self.expect("]", "an expression does not end")
        return inner

    def parameter(self) -> Callable[[Memory], Key]:
        """Read a parameter; return what says which it is."""
        self.expect("#", "no parameter")
        start = self.at - 1
        if self.blanks() == "<":
            match = _NAME.match(self.text, self.at)
            if match is None:
                raise ValueError("a name with <, #, [ or ] in it, or without an end: take another")
            self.at = match.end()
            name = "".join(match[1].split()).lower()
            self.parameters.append(Parameter(name, start, self.at))
            return lambda _: name
        before = self.at
        inner = self.value()
        digits = self.text[before : self.at]
        self.parameters.append(Parameter(int(digits) if digits.isdigit() else None, start, self.at))
        return lambda memory: _key(inner(memory))

    def _function(self, name: str) -> Expression:
        if name == "exists":
            start = self.at - len(name)
            self.expect("[", "EXISTS takes a name")
            key = self.parameter()
            self.expect("]", "EXISTS takes one name")
            self.parameters.append(replace(self.parameters.pop(), start=start, end=self.at, asked=True))
            return lambda memory: _exists(memory, key)
        if name == "atan":
            above = self.bracket()
            self.expect("/", "ATAN takes two values")
            below = self.bracket()
            return _applied(_atan, above, below)
        function = _FUNCTIONS.get(name)
        if function is None:
            raise ValueError(f"{name.upper()} is no function: correct it")
        inner = self.bracket()
        return lambda memory: _checked(function, _double(inner(memory)))

    def _binary(self, level: int) -> Expression:
        """Read operations that bind as much as those of a level, or more."""
        if level == len(_LEVELS):
            return self.value()
        left = self._binary(level + 1)
        while True:
            before = self.at
            name = (self._match(_OPERATOR) or "").lower()
            if name not in _LEVELS[level]:
                self.at = before
                return left
            left = _applied(_LEVELS[level][name], left, self._binary(level + 1))


def _applied(operation: Callable[[float, float], float], left: Expression, right: Expression) -> Expression:
    return lambda memory: _checked(operation, _double(left(memory)), _double(right(memory)))


def _double(value: Value) -> float:
    return value if isinstance(value, float) else float(value)


def _negated(value: Value) -> Value:
    if isinstance(value, Approximate):
        return Approximate(-value)
    # A zero keeps its sign, which the angle to the left of it shows.
    return -value if value else -float(value)


def _checked(function: Callable[..., float], *values: float) -> float:
    try:
        result = _double(function(*values))
    except InexactError:
        raise
    except (ValueError, OverflowError, ZeroDivisionError):
        result = math.nan
    if not math.isfinite(result):
        raise ValueError("has no value: correct the expression")
    return result


def _key(value: Value) -> int:
    key = int(value + Fraction(1, 2) if value > 0 else 0)
    if abs(value - key) > 1e-4 or not 1 <= key <= _LARGEST_PARAMETER:
        raise NoParameterError(f"there is no parameter {float(value):g}: give a whole number from 1 on")
    return key


def _exists(memory: Memory, key: Callable[[Memory], Key]) -> Fraction:
    try:
        return Fraction(memory.exists(key(memory)))
    except NoParameterError:
        return Fraction(0)


def _known(*values: Value) -> bool:
    return not any(isinstance(value, Approximate) for value in values)


def _like(operation: Callable[..., float]) -> Callable[..., float]:
    """Return an operation whose result is approximate where an operand is."""

    def apply(*values: float) -> float:
        result = operation(*values)
        return result if _known(*values) else _approximate(result)

    return apply


def _approximate(result: float) -> Approximate:
    if abs(result) > LARGEST:
        raise InexactError(f"{result!r} is made of digits that controls do not share: go from a number")
    return Approximate(result)


def _product(a: float, b: float) -> float:
    for one, other in ((a, b), (b, a)):
        if not _known(one) and abs(other) > _SCALED:
            raise InexactError(f"{other!r} times {one!r} is made of digits that controls do not share")
    return a * b


def _library(function: Callable[[float], float], exact_at: float) -> Callable[[float], float]:
    """Return a function that no two libraries compute alike, but at one place."""

    def apply(value: float) -> float:
        result = function(value)
        return result if _known(value) and value == exact_at else _approximate(result)

    return apply


def _rounding(function: Callable[[float], float], jumps_at: float = 0.0) -> Callable[[float], float]:
    """Return a function to whole numbers, which jumps at those, or beside them."""

    def apply(value: float) -> float:
        from_jump = value - jumps_at
        # Beyond what moves anything, one more or less is as little as the error.
        if not _known(value) and abs(value) <= LARGEST and abs(from_jump - round(from_jump)) < _EQUAL:
            raise InexactError(
                f"{value!r} is rounded up by some controls, and down by others: go from a number"
            )
        return function(value)

    return apply


def _differ(a: float, b: float) -> bool:
    if (a != b or not _known(a, b)) and abs(a - b) < _EQUAL:
        raise InexactError(f"{a!r} and {b!r} are equal to some controls only: compare with a number between")
    return a != b


def _greater(a: float, b: float) -> bool:
    return a > b if _known(a, b) else _differ(a, b) and a > b


def truth(value: Value) -> bool:
    """Return whether a value counts as true; raise InexactError where that depends on the control."""
    if not _known(value) and abs(value) < _EQUAL:
        raise InexactError(f"{value!r} is 0 to some controls only: compare it with a number")
    return bool(value)


def times(value: Value) -> int:
    """Return how often something is repeated; raise InexactError where that depends on the control."""
    return int(_rounding(round, 0.5)(_double(value)))


def _mod(a: float, b: float) -> float:
    rest = math.fmod(a, b)
    if not _known(a, b) and min(abs(rest), abs(b) - abs(rest)) < _EQUAL:
        raise InexactError(f"{a!r} is a multiple of {b!r} to some controls only: go from a number")
    return rest + abs(b) if rest < 0 else rest


def _power(a: float, b: float) -> float:
    result = math.pow(a, b)
    # Libraries agree on whole powers of whole numbers.
    whole = a.is_integer() and b.is_integer() and result.is_integer() and abs(result) < 1 << 53
    return result if whole and _known(a, b) else Approximate(result)


def _quotient(a: float, b: float) -> float:
    if not _known(b) and abs(b) < _EQUAL:
        raise InexactError(f"{b!r} divides, and has another sign to some controls: go from a number")
    if not _known(a) and b and abs(b) < 1 / _SCALED:
        raise InexactError(f"{a!r} by {b!r} is made of digits that controls do not share: go from a number")
    return a / b


def _atan(a: float, b: float) -> float:
    sign_of_a, side_of_b = not _known(a) and b < _EQUAL, not _known(b) and abs(b) < _EQUAL
    if abs(a) < _EQUAL and (sign_of_a or side_of_b):
        raise InexactError(f"{a!r} above {b!r} has another angle to other controls")
    result = math.degrees(math.atan2(a, b))
    return result if _known(a, b) and a == 0 else Approximate(result)


def _round(value: float) -> float:
    if abs(value) >= 1 << 31:
        raise InexactError(f"{value!r} is rounded to a number of 32 bits by some controls: make it smaller")
    # No zero has a sign that was a whole number once.
    return math.floor(abs(value) + 0.5) * math.copysign(1, value) + 0.0


def _signed(function: Callable[[float], int]) -> Callable[[float], float]:
    """Return a function to whole numbers whose zeros keep the sign of what they are made of."""
    return lambda value: float(function(value)) or math.copysign(0.0, value)


_FUNCTIONS: dict[str, Callable[[float], float]] = {
    "abs": _like(lambda x: -x if x < 0 else x), "sqrt": _like(math.sqrt),
    "exp": _library(math.exp, 0), "ln": _library(math.log, 1),
    "sin": _library(lambda x: math.sin(math.radians(x)), 0),
    "cos": _library(lambda x: math.cos(math.radians(x)), 0),
    "tan": _library(lambda x: math.tan(math.radians(x)), 0),
    "asin": _library(lambda x: math.degrees(math.asin(x)), 0),
    "acos": _library(lambda x: math.degrees(math.acos(x)), 1),
    "fix": _rounding(_signed(math.floor)), "fup": _rounding(_signed(math.ceil)),
    "round": _rounding(_round, 0.5),
}  # fmt: skip
# From those that bind least to those that bind most.
_LEVELS: tuple[dict[str, Callable[[float, float], float]], ...] = (
    {
        "and": lambda a, b: truth(a) and truth(b), "or": lambda a, b: truth(a) or truth(b),
        "xor": lambda a, b: truth(a) != truth(b),
    },
    {
        "eq": lambda a, b: not _differ(a, b), "ne": _differ,
        "gt": _greater, "lt": lambda a, b: _greater(b, a),
        "ge": lambda a, b: _greater(a, b) or not _differ(a, b),
        "le": lambda a, b: _greater(b, a) or not _differ(a, b),
    },
    {"+": _like(lambda a, b: a + b), "-": _like(lambda a, b: a - b)},
    {"*": _like(_product), "/": _like(_quotient), "mod": _like(_mod)},
    {"**": _power},
)  # fmt: skip
