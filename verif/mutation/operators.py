"""The operators on expressions that are evaluated at run time: each gives edits of one expression.

Standard terms of mutation analysis. What an operator cannot change observably is not generated:

- a type or size in a cast, a width in a select: they are fixed at elaboration (see elaboration.py);
- the top bit of {1'b0, ..}: it is the zero already;
- a cast of a number that is known at elaboration, or of a number of bits: it fits, or Verilator says so;
- a cast to unsigned of what is;
- the next element of an array of one;
- signals named unused..: they exist to say that something is not used;
- the clock.
"""

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

from triaxis.verif.mutation.mutant import Edit
from triaxis.verif.mutation.syntax import Declared, Node, SourceFile, base_name, children, kind, span

_ARITHMETIC = {"AddExpression": "-", "SubtractExpression": "+", "MultiplyExpression": "+"}
_RELATIONAL = {
    "LessThanExpression": ("<=", ">"),
    "GreaterThanExpression": (">=", "<"),
    "LessThanEqualExpression": ("<", ">="),
    "GreaterThanEqualExpression": (">", "<="),
}
_EQUALITY = {"EqualityExpression": "!=", "InequalityExpression": "=="}
_LOGICAL = {"LogicalAndExpression": "||", "LogicalOrExpression": "&&"}
_BITWISE = {"BinaryAndExpression": "|", "BinaryOrExpression": "&", "BinaryXorExpression": "|"}
_SHIFT = {"ArithmeticShiftLeftExpression": ">>>", "ArithmeticShiftRightExpression": "<<<"}
_UNARY = {
    "UnaryLogicalNotExpression": "",
    "UnaryBitwiseNotExpression": "",
    "UnaryMinusExpression": "",
    "UnaryBitwiseAndExpression": "|",
    "UnaryBitwiseOrExpression": "&",
    "UnaryBitwiseXorExpression": "~^",
}
_BINARY = {**_ARITHMETIC, **_RELATIONAL, **_EQUALITY, **_LOGICAL, **_BITWISE, **_SHIFT}
_RANGES = ("SimpleRangeSelect", "AscendingRangeSelect", "DescendingRangeSelect")

Change = tuple[str, Edit]


@dataclass(frozen=True)
class Scope:
    """What the operators need of the surroundings: the file, the module's names, what is assigned."""

    source: SourceFile
    declared: Mapping[str, Declared]
    target: str = ""


def changes(node: Node, scope: Scope) -> Iterator[Change]:
    """Iterate over the changes of an expression: the operator's name, and the edit."""
    name = kind(node)
    if name in _BINARY:
        yield from _binary(node, scope)
    elif name in _UNARY:
        yield from _unary(node, scope)
    elif special := _SPECIAL.get(name):
        yield from special(node, scope)
    else:
        for child in children(node):
            yield from changes(child, scope)


def _replaced(node: Node, text: str) -> Edit:
    start, end = span(node)
    return Edit(start, end, text)


def _binary(node: Node, scope: Scope) -> Iterator[Change]:
    name, text = kind(node), scope.source.of
    left, right = text(node.left), text(node.right)
    if name in _RELATIONAL:
        for operator in _RELATIONAL[name]:
            yield "relational", _replaced(node, f"{left} {operator} {right}")
    elif name in _SHIFT:
        yield "shift", _replaced(node, f"{left} {_SHIFT[name]} {right}")
        yield "shift", _replaced(node, f"{left} <<< (({right}) + 1)")
        yield from changes(node.left, scope)
        return
    else:
        operators = {
            "arithmetic": _ARITHMETIC, "equality": _EQUALITY, "logical": _LOGICAL, "bitwise": _BITWISE,
        }  # fmt: skip
        operator = next(key for key, table in operators.items() if name in table)
        yield operator, _replaced(node, f"{left} {operators[operator][name]} {right}")
        if operator in ("arithmetic", "logical"):
            yield "operand", _replaced(node, left)
            yield "operand", _replaced(node, right)
        if name == "SubtractExpression":
            yield "operand", _replaced(node, f"{right} - {left}")
    yield from changes(node.left, scope)
    yield from changes(node.right, scope)


def _unary(node: Node, scope: Scope) -> Iterator[Change]:
    operand = scope.source.of(node.operand)
    yield "unary", _replaced(node, f"({_UNARY[kind(node)]}{operand})")
    yield from changes(node.operand, scope)


def _conditional(node: Node, scope: Scope) -> Iterator[Change]:
    text = scope.source.of
    condition, left, right = text(node.predicate), text(node.left), text(node.right)
    yield "condition", _replaced(node, f"!({condition}) ? {left} : {right}")
    yield "condition", _replaced(node, left)
    yield "condition", _replaced(node, right)
    for part in (node.predicate, node.left, node.right):
        yield from changes(part, scope)


def _cast(node: Node, scope: Scope) -> Iterator[Change]:
    text = scope.source.of
    inner = text(node.right)[1:-1]
    type_ = text(node.left)
    if re.fullmatch(r"\w+", inner) and inner not in scope.declared:
        return
    # The names in it, without those of fields and those in casts.
    names = re.findall(r"(?<![.$\w'])[A-Za-z_]\w*(?!['\w])", inner)
    if inner.lstrip().startswith("$countones") or not any(name in scope.declared for name in names):
        yield from changes(node.right, scope)
        return
    unsigned = inner.lstrip().startswith("{")
    # A concatenation keeps what is inside from growing to the width of the cast.
    shifted = f"{{({inner}) <<< 1}}"
    drop = f"{shifted} >> 1" if unsigned else f"$signed({shifted}) >>> 1"
    widens = not re.search(r"\s[-+*]\s", inner)
    if widens:
        if not inner.lstrip().startswith("{1'b0,"):
            yield "cast", _replaced(node, f"{type_}'({drop})")
        if not unsigned and _may_be_signed(names, scope):
            yield "cast", _replaced(node, f"{type_}'({{{inner}}})")
    else:
        yield "cast", _replaced(node, f"{type_}'($signed({{{type_}'({inner}) <<< 1}}) >>> 1)")
    yield from changes(node.right, scope)


def _may_be_signed(names: Sequence[str], scope: Scope) -> bool:
    # What is not declared is a parameter or a constant.
    return any(scope.declared[name].signed for name in names if name in scope.declared)


def _signed_cast(node: Node, scope: Scope) -> Iterator[Change]:
    inner = scope.source.of(node.inner)
    yield "cast", _replaced(node, f"unsigned'{inner}")
    yield from changes(node.inner, scope)


def _integer(node: Node, scope: Scope) -> Iterator[Change]:
    text = scope.source.of(node)
    yield "constant", _replaced(node, f"({text} + 1)" if text != "1" else "0")


def _vector(node: Node, scope: Scope) -> Iterator[Change]:
    match = re.fullmatch(r"(\d+)'([bdh])([0-9a-f]+)", scope.source.of(node))
    if match is None:
        return
    size, base, digits = int(match[1]), {"b": 2, "d": 10, "h": 16}[match[2]], match[3]
    value = (int(digits, base) + 1) % (1 << size)
    yield "constant", _replaced(node, f"{size}'d{value}")


def _unsized(node: Node, scope: Scope) -> Iterator[Change]:
    yield "constant", _replaced(node, "'1" if scope.source.of(node) == "'0" else "'0")


def _neighbour(text: str, scope: Scope) -> str | None:
    """Return the expression with the neighbour of the name with which it begins."""
    name = base_name(text)
    neighbour = scope.declared[name].neighbour if name in scope.declared else None
    if neighbour is None or neighbour == scope.target:
        return None
    return text.replace(name, neighbour, 1)


def _identifier(node: Node, scope: Scope) -> Iterator[Change]:
    text = scope.source.of(node)
    changed = _neighbour(text, scope)
    if changed is not None:
        yield "identifier", _replaced(node, changed)


def _selected(node: Node, scope: Scope) -> Iterator[Change]:
    yield from _identifier(node, scope)
    text = scope.source.of(node)
    start = span(node)[0]
    for select in node.selectors:
        selector = getattr(select, "selector", None)
        if selector is None:
            continue
        if kind(selector) in _RANGES:
            yield "range", _replaced(node, f"({text} >> 1)")
            continue
        base = scope.source.text[start : span(select)[0]]
        if _size(base, scope) == "[1]":
            continue
        yield "index", _replaced(selector, _next_index(scope.source.of(selector), base))


def _size(base: str, scope: Scope) -> str | None:
    """Return the dimension, as declared, that selects an element of an expression; None where unknown."""
    declared, before = scope.declared.get(base_name(base)), base.count("[")
    return declared.sizes[before] if declared and before < len(declared.sizes) else None


def _next_index(index: str, base: str) -> str:
    return f"$low({base}) + (({index}) - $low({base}) + 1) % $size({base})"


def _concatenation(node: Node, scope: Scope) -> Iterator[Change]:
    items = [child for child in children(node) if kind(child) != "SeparatedList"]
    texts = [scope.source.of(item) for item in items]
    for left, right in zip(range(len(items)), range(1, len(items)), strict=False):
        if base_name(texts[left]) and base_name(texts[right]):
            start, end = span(items[left])[0], span(items[right])[1]
            yield "concatenation", Edit(start, end, f"{texts[right]}, {texts[left]}")
    for item in items:
        yield from changes(item, scope)


def _invocation(node: Node, scope: Scope) -> Iterator[Change]:
    # Other functions are of what is known at elaboration.
    if scope.source.of(node.left) == "$countones":
        yield from changes(node.arguments, scope)


def _nothing(node: Node, scope: Scope) -> Iterator[Change]:
    del node, scope
    yield from ()


_SPECIAL: dict[str, Callable[[Node, Scope], Iterator[Change]]] = {
    "ConditionalExpression": _conditional,
    "CastExpression": _cast,
    "SignedCastExpression": _signed_cast,
    "IntegerLiteralExpression": _integer,
    "IntegerVectorExpression": _vector,
    "UnbasedUnsizedLiteralExpression": _unsized,
    "IdentifierName": _identifier,
    "IdentifierSelectName": _selected,
    "ConcatenationExpression": _concatenation,
    "SimpleAssignmentPattern": _concatenation,
    # A zero for every element: "stuck" changes the whole.
    "StructuredAssignmentPattern": _nothing,
    "ScopedName": _nothing,
    "InvocationExpression": _invocation,
}
