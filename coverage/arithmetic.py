"""Whole-number arithmetic written as text, for bounds that depend on parameters.

Operators: + - * // % ** << >>, comparisons (1 or 0), and, or, not, parentheses. Names are looked up in
the variables given. Nothing else: no calls, no attributes, no real numbers.
"""

import ast
import operator
from collections.abc import Callable, Mapping
from functools import cache


class BoundError(ValueError):
    """The text is no such expression, or has no value."""


def _power(base: int, exponent: int) -> int:
    if exponent < 0:
        raise BoundError(f"{base} ** {exponent}: no whole number")
    return base**exponent


_BINARY: dict[type[ast.operator], Callable[[int, int], int]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: _power,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
}
_COMPARE: dict[type[ast.cmpop], Callable[[int, int], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}


@cache
def _parsed(text: str) -> ast.expr:
    try:
        return ast.parse(text, mode="eval").body
    except SyntaxError as error:
        raise BoundError(f"{text}: not an expression") from error


def _value(node: ast.expr, variables: Mapping[str, int]) -> int:
    match node:
        case ast.Constant(value=int(number)):
            return int(number)
        case ast.Name(id=name):
            if name not in variables:
                raise BoundError(f"{name}: no such parameter here")
            return variables[name]
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return -_value(operand, variables)
        case ast.UnaryOp(op=ast.Not(), operand=operand):
            return int(not _value(operand, variables))
        case ast.BinOp(left=left, op=op, right=right) if type(op) in _BINARY:
            return _BINARY[type(op)](_value(left, variables), _value(right, variables))
        case ast.Compare(left=left, ops=[op], comparators=[right]) if type(op) in _COMPARE:
            return int(_COMPARE[type(op)](_value(left, variables), _value(right, variables)))
        case ast.BoolOp(op=ast.And(), values=values):
            return int(all(_value(value, variables) for value in values))
        case ast.BoolOp(op=ast.Or(), values=values):
            return int(any(_value(value, variables) for value in values))
    raise BoundError(f"{ast.unparse(node)}: not allowed in a bound")


def evaluate(text: str, variables: Mapping[str, int]) -> int:
    """Return the value of an expression; raise BoundError where it has none."""
    try:
        return _value(_parsed(text), variables)
    except (ZeroDivisionError, OverflowError, ValueError) as error:
        if isinstance(error, BoundError):
            raise
        raise BoundError(f"{text}: {error}") from error
