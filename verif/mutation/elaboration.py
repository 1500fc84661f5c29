"""Mutants of what is fixed when the design elaborates; each needs a build of its own.

Not generated, because nothing could show them:

- a width that grows: results stay the same by construction;
- parameters' defaults, and widths of ports: every instance sets the first, and the functions of triaxis_pkg
  that give the second are mutated there;
- loops over signals named unused..;
- guards that end elaboration with $fatal: no configuration in range meets them.
"""

import re
from collections.abc import Iterator

from triaxis.verif.mutation.mutant import ELABORATION, Edit, Mutant, applied, named, normalised
from triaxis.verif.mutation.syntax import Node, SourceFile, base_name, below, blocks, kind, module_name, span

_FLAGS = frozenset({"Comb", "EdgeBox", "Gating", "FirstOnA"})
_MODULO = re.compile(r"\((.+)\) % 3")


def elaboration_mutants(source: SourceFile) -> list[Mutant]:
    """Return the elaboration mutants of a file, named."""
    found: list[Mutant] = []
    for module in source.modules:
        around = blocks(module)
        for node in below(module):
            for operator, context, edit in _changes(source, node):
                needs = max(start for start, end in around if start <= context[0] < end)
                found.append(_mutant(source, module, operator, context, edit, needs))
    return named(mutant for mutant in found if mutant.original != mutant.changed)


def _mutant(
    source: SourceFile, module: Node, operator: str, context: tuple[int, int], edit: Edit, needs: int
) -> Mutant:
    start, end = context
    original = source.text[start:end]
    after = applied(original, [Edit(edit.start - start, edit.end - start, edit.text)])
    return Mutant(
        "", module_name(module), operator, ELABORATION, source.name, source.line(edit.start),
        normalised(original), normalised(after), edit, start, needs,
    )  # fmt: skip


_Change = tuple[str, tuple[int, int], Edit]


def _changes(source: SourceFile, node: Node) -> Iterator[_Change]:
    name = kind(node)
    if name == "IfGenerate":
        yield from _generate_if(source, node)
    elif name == "LoopGenerate":
        yield from _generate_loop(source, node)
    elif name == "NamedParamAssignment":
        yield from _parameter(source, node)
    elif name == "ParameterDeclarationStatement":
        yield from _constant(source, node)
    elif name == "TypedefDeclaration":
        yield from _type(source, node)
    elif name == "FunctionDeclaration":
        yield from _function(source, node)


def _at(node: Node, text: str) -> Edit:
    return Edit(*span(node), text)


def _generate_if(source: SourceFile, node: Node) -> Iterator[_Change]:
    if "$fatal" in source.of(node.block) or re.search(r"\bunused_padding\b", source.of(node.block)):
        return
    context = (span(node)[0], span(node.condition)[1] + 1)
    yield "generate_condition", context, _at(node.condition, f"!({source.of(node.condition)})")


def _generate_loop(source: SourceFile, node: Node) -> Iterator[_Change]:
    if not any(_does_something(source, child) for child in below(node.block)):
        return
    context = (span(node)[0], span(node.stopExpr)[1])
    stop = node.stopExpr
    yield "generate_loop", context, _at(stop.right, f"{source.of(stop.right)} - 1")


def _does_something(source: SourceFile, node: Node) -> bool:
    """Return whether an item is more than an assignment to what is not used."""
    if kind(node) == "ContinuousAssign":
        return not base_name(source.of(node.assignments[0].left)).startswith("unused")
    return kind(node) in ("HierarchyInstantiation", "AlwaysFFBlock", "AlwaysCombBlock")


def _parameter(source: SourceFile, node: Node) -> Iterator[_Change]:
    name, value = str(node.name.valueText), source.of(node.expr)
    context = span(node)
    if name in _FLAGS:
        yield "parameter", context, _at(node.expr, f"!({value})")
    elif name == "M" and value == "0":
        # A width that grows.
        return
    elif name == "M":
        yield "parameter", context, _at(node.expr, f"({value}) == 0 ? 1 : 0")
    elif name in ("Cycles", "NormalWait", "DetWait") or (name == "Depth" and _of_queue(source, node)):
        yield "parameter", context, _at(node.expr, f"({value}) + 1")
        yield "parameter", context, _at(node.expr, f"({value}) == 0 ? 1 : ({value}) - 1")
    elif name != "T":
        # A width, or a number of terms.
        yield "parameter", context, _at(node.expr, f"({value}) - 1")


def _of_queue(source: SourceFile, node: Node) -> bool:
    """Return whether a parameter is one of a queue. The depth of a memory is a width of its addresses."""
    while kind(node) != "HierarchyInstantiation":
        node = node.parent
    return "fifo" in base_name(source.of(node))


def _constant(source: SourceFile, node: Node) -> Iterator[_Change]:
    declaration = next(child for child in below(node) if kind(child) == "Declarator")
    name = str(declaration.name.valueText)
    value = declaration.initializer.expr
    text, context = source.of(value), span(node)
    modulo = _MODULO.fullmatch(text)
    if name in _FLAGS:
        yield "constant", context, _at(value, f"!({text})")
    elif modulo:
        yield "constant", context, _at(value, f"({modulo[1]} + 1) % 3")
    else:
        yield "constant", context, _at(value, f"({text}) - 1")
        if "Width" not in name and not name.endswith("Bits"):
            yield "constant", context, _at(value, f"({text}) + 1")


def _type(source: SourceFile, node: Node) -> Iterator[_Change]:
    for dimension in below(node.type):
        if kind(dimension) == "SimpleRangeSelect":
            high = dimension.left
            yield "type", span(node), _at(high, f"{source.of(high)} - 1")


def _function(source: SourceFile, node: Node) -> Iterator[_Change]:
    widths = str(node.prototype.name).strip().endswith("width")
    for child in below(node):
        if kind(child) == "ConditionalStatement":
            condition = child.predicate
            yield "function", span(condition), _at(condition, f"!({source.of(condition)})")
        elif kind(child) == "ReturnStatement":
            value, context = child.returnValue, span(child)
            text = source.of(value)
            if base_name(source.of(node.prototype)) and " bit " in f" {source.of(node.prototype)} ":
                yield "function", context, _at(value, f"!({text})")
                continue
            yield "function", context, _at(value, f"({text}) - 1")
            if not widths:
                yield "function", context, _at(value, f"({text}) + 1")
