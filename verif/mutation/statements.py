"""Mutants that are selected at run time: every item of a module that does something, with its changes.

Four kinds of items, hosts of mutants: continuous assignments, always blocks, connections of instances'
inputs, and the registers that the macro TRIAXIS_STAGE makes. Of an always block that reads nothing that
changes, as one that fills a table does, mutants need a build each: it has run before one can be selected.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

from triaxis.verif.mutation.mutant import ELABORATION, RUNTIME, Edit, Mutant, applied, named, normalised
from triaxis.verif.mutation.operators import Change, Scope, changes
from triaxis.verif.mutation.syntax import (
    Declared,
    Node,
    SourceFile,
    Stage,
    base_name,
    below,
    blocks,
    children,
    declarations,
    enumerators,
    inputs,
    kind,
    module_name,
    span,
)

ASSIGN, ALWAYS, PORT, STAGE = "assign", "always", "port", "stage"
# Operators of a whole statement.
STUCK, DELETION, BYPASS, LATE = "stuck", "deletion", "bypass", "late"

_CLOCKS = frozenset({"clk_i"})
# The neighbour of an array's element, as operators.py writes it: long to read.
_NEXT = re.compile(r"\$low\((.+?)\) \+ \(\((.+?)\) - \$low\(\1\) \+ 1\) % \$size\(\1\)")
_UNUSED = re.compile(r"unused")


@dataclass(frozen=True)
class Host:
    """An item that holds mutants: its text, from ``start`` to ``end``, and its parts.

    ``target``: what an assignment writes. ``body``: where the text that mutants change begins and ends: the
    value of an assignment, the statement of an always block, the expression of a port. ``anchor``: where
    declarations that go with it can stand.
    """

    kind: str
    start: int
    end: int
    target: str
    body: tuple[int, int]
    anchor: int
    mutants: tuple[Mutant, ...]
    stage: Stage | None = None

    def with_mutants(self, mutants: tuple[Mutant, ...]) -> "Host":
        """Return the host with other mutants."""
        return replace(self, mutants=mutants)


@dataclass(frozen=True)
class _Module:
    """A module under mutation."""

    source: SourceFile
    node: Node
    declared: Mapping[str, Declared]
    inputs: Mapping[str, frozenset[str]]

    def scope(self, target: str = "") -> Scope:
        return Scope(self.source, self.declared, target)

    @cached_property
    def _blocks(self) -> list[tuple[int, int]]:
        return blocks(self.node)

    def block(self, offset: int) -> int:
        """Return the start of the innermost block around an offset."""
        return max(start for start, end in self._blocks if start <= offset < end)

    def mutant(
        self, host: int, context: tuple[int, int], change: Change, changed: str | None = None
    ) -> Mutant:
        operator, edit = change
        start, end = context
        original = self.source.text[start:end]
        inner = Edit(edit.start - start, edit.end - start, edit.text)
        after = applied(original, [inner]) if changed is None else changed
        return Mutant(
            "", module_name(self.node), operator, RUNTIME, self.source.name, self.source.line(edit.start),
            normalised(original), _NEXT.sub(r"next(\2)", normalised(after)), edit, host, self.block(start),
        )  # fmt: skip


def hosts(
    source: SourceFile,
    ports: Mapping[str, frozenset[str]],
    shared: Mapping[str, Declared] = MappingProxyType({}),
) -> list[Host]:
    """Return the hosts of a file with their mutants, named.

    ``ports``: the inputs of each module; ``shared``: what packages declare for all modules.
    """
    found: list[Host] = []
    for node in source.modules:
        if kind(node) == "ModuleDeclaration":
            known = {**shared, **enumerators(node), **declarations(source, node)}
            module = _Module(source, node, known, ports)
            found.extend(_hosts(module))
    mutants = named(_distinct([mutant for host in found for mutant in host.mutants]))
    by_host: dict[int, list[Mutant]] = {}
    for mutant in mutants:
        by_host.setdefault(mutant.host, []).append(mutant)
    return [host.with_mutants(tuple(by_host[host.start])) for host in found if host.start in by_host]


def input_ports(sources: Sequence[SourceFile]) -> dict[str, frozenset[str]]:
    """Return the input ports of each module."""
    return {
        module_name(node): inputs(node)
        for source in sources
        for node in source.modules
        if kind(node) == "ModuleDeclaration"
    }


def shared_enumerators(sources: Sequence[SourceFile]) -> dict[str, Declared]:
    """Return the values of the enumerations that packages define."""
    packages = (node for source in sources for node in source.modules if kind(node) == "PackageDeclaration")
    return {name: value for package in packages for name, value in enumerators(package).items()}


def _distinct(mutants: list[Mutant]) -> list[Mutant]:
    """Leave out changes that change nothing, or read as an earlier one of the same host."""
    seen: set[tuple[int, int, str]] = set()
    kept: list[Mutant] = []
    for mutant in mutants:
        # Of one place in the text: the whole statement would join what differs only in its place.
        key = (mutant.host, mutant.line, mutant.changed)
        if mutant.changed != mutant.original and key not in seen:
            kept.append(mutant)
            seen.add(key)
    return kept


def _hosts(module: _Module) -> Iterator[Host]:
    for node in below(module.node):
        name = kind(node)
        if name == "ContinuousAssign":
            yield from _assignment(module, node)
        elif name in ("AlwaysFFBlock", "AlwaysCombBlock"):
            yield _always(module, node)
        elif name == "HierarchyInstantiation":
            yield from _connections(module, node)
    start, end = span(module.node)
    for stage in module.source.stages:
        if start <= stage.start < end:
            yield _stage(module, stage)


def _zero(module: _Module, target: str) -> str:
    """Return a zero of the type of what is assigned, as text."""
    name = base_name(target)
    declared = module.declared.get(name)
    selects = len(re.findall(r"\[", target))
    return "'{default: '0}" if declared and declared.dimensions > selects else "'0"


def _assignment(module: _Module, node: Node) -> Iterator[Host]:
    expression = node.assignments[0]
    left, right = expression.left, expression.right
    target = module.source.of(left)
    if _UNUSED.match(base_name(target)):
        return
    start, body = span(node)[0], span(right)
    context = span(expression)
    found = list(changes(right, module.scope(base_name(target))))
    zero = _zero(module, target)
    if normalised(module.source.of(right)) not in (zero, "'0", "'{default: '0}"):
        found.append((STUCK, Edit(*body, zero)))
    mutants = tuple(module.mutant(start, context, change) for change in found)
    yield Host(ASSIGN, start, span(node)[1], target, body, start, mutants)


def _always(module: _Module, node: Node) -> Host:
    statement = node.statement
    if kind(statement) == "TimingControlStatement":
        statement = statement.statement
    start = span(node)[0]
    mutants = tuple(_procedural(module, statement, start))
    if kind(node) == "AlwaysCombBlock" and not _reads(module, node):
        mutants = tuple(replace(mutant, kind=ELABORATION) for mutant in mutants)
    return Host(ALWAYS, start, span(node)[1], "", span(statement), start, mutants)


def _reads(module: _Module, block: Node) -> set[str]:
    """Return what an always block reads of that which it does not write itself, and which may change."""
    text = module.source.of(block)
    written = {base_name(module.source.of(n.left)) for n in below(block) if kind(n) == "AssignmentExpression"}
    return {name for name in module.declared if re.search(rf"\b{name}\b", text)} - written


def _procedural(module: _Module, statement: Node, host: int) -> Iterator[Mutant]:
    """Iterate over the mutants of a statement; each is told by the innermost statement that it changes."""
    for node in below(statement):
        name = kind(node)
        if name == "ConditionalStatement":
            yield from _branch(module, node.predicate, host)
        elif name == "ForLoopStatement":
            for part in (node.stopExpr, *(item for item in node.initializers if hasattr(item, "kind"))):
                for change in _loop_changes(part, module.scope()):
                    yield module.mutant(host, _header(node), change)
        elif name == "ExpressionStatement":
            context = span(node)
            assignment = node.expr
            scope = module.scope(base_name(module.source.of(assignment.left)))
            for change in (*_indices(assignment.left, scope), *changes(assignment.right, scope)):
                yield module.mutant(host, context, change)
            # Without its default, a variable of always_comb would be a latch, which lint refuses.
            if "Nonblocking" in kind(assignment) or not _is_default(module, node):
                yield module.mutant(host, context, (DELETION, Edit(*context, ";")))


def _is_default(module: _Module, statement: Node) -> bool:
    """Return whether a blocking assignment gives a value that later ones in its block may override."""
    target = normalised(module.source.of(statement.expr.left))
    later = (
        normalised(module.source.of(node.left))
        for node in below(statement.parent)
        if kind(node) == "AssignmentExpression" and span(node)[0] > span(statement)[1]
    )
    return module.source.of(statement.expr.right) == "'0" or target in later


def _header(loop: Node) -> tuple[int, int]:
    return span(loop)[0], span(loop.closeParen if hasattr(loop.closeParen, "sourceRange") else loop.stopExpr)[
        1
    ]


def _loop_changes(node: Node, scope: Scope) -> Iterator[Change]:
    if kind(node) != "ForVariableDeclaration":
        # A loop that counts down from 0 for as long as it is below: the simulator would not end.
        yield from (change for change in changes(node, scope) if not change[1].text.endswith("<= 0"))
        return
    for child in below(node):
        if kind(child) == "EqualsValueClause":
            start, end = span(child.expr)
            yield "constant", Edit(start, end, f"{scope.source.of(child.expr)} - 1")


def _branch(module: _Module, predicate: Node, host: int) -> Iterator[Mutant]:
    context = span(predicate)
    text = module.source.of(predicate)
    found: list[Change] = [("condition", Edit(*context, new)) for new in (f"!({text})", "1'b1", "1'b0")]
    for change in (*found, *changes(predicate, module.scope())):
        mutant = module.mutant(host, context, change)
        yield _with_words(mutant, "if ({})")


def _with_words(mutant: Mutant, form: str) -> Mutant:
    return replace(mutant, original=form.format(mutant.original), changed=form.format(mutant.changed))


def _indices(left: Node, scope: Scope) -> Iterator[Change]:
    """Iterate over changes of the indices at which an assignment writes."""
    for select in getattr(left, "selectors", ()):
        for child in children(select):
            for expression in children(child):
                yield from (change for change in changes(expression, scope) if change[0] != "constant")


def _connections(module: _Module, node: Node) -> Iterator[Host]:
    target = module.source.of(node)
    type_ = base_name(target)
    known = module.inputs.get(type_, frozenset())
    for connection in below(node):
        if kind(connection) != "NamedPortConnection":
            continue
        name = str(connection.name.valueText)
        if name not in known or name in _CLOCKS:
            continue
        host = _connection(module, connection, name, span(node)[0])
        if host is not None:
            yield host


def _connection(module: _Module, node: Node, name: str, anchor: int) -> Host | None:
    start, end = span(node)
    if node.expr is None:
        # `.name` alone stands for `.name(name)`.
        declared = module.declared.get(name)
        found: list[Change] = [(STUCK, Edit(start, end, f".{name}({_zero(module, name)})"))]
        if declared and declared.neighbour:
            found.append(("identifier", Edit(start, end, f".{name}({declared.neighbour})")))
        body, text = (start, end), name
    else:
        body, text = span(node.expr), module.source.of(node.expr)
        found = list(changes(node.expr, module.scope()))
        if re.fullmatch(r"'0|\d+'b0+", text) is None:
            found.append((STUCK, Edit(*body, _zero(module, text))))
    mutants = tuple(module.mutant(start, (start, end), change) for change in found)
    return Host(PORT, start, end, text, body, anchor, mutants) if mutants else None


def _stage(module: _Module, stage: Stage) -> Host:
    q, d = stage.register, stage.value
    context = (stage.start, stage.end)
    wire = f"if (Comb) begin : g_{q}_wire assign {q} = {d}; end"
    later = (
        f"{wire} else begin : g_{q}_reg var type({q}) early; "
        f"always_ff @(posedge clk_i) begin early <= {d}; {q} <= early; end end"
    )
    texts = {BYPASS: f"assign {q} = {d};", LATE: later, STUCK: f"assign {q} = {_zero(module, q)};"}
    words = {BYPASS: f"{q} = {d}", LATE: f"{q} one clock later", STUCK: f"{q} = 0"}
    mutants = tuple(
        module.mutant(stage.start, context, (operator, Edit(*context, text)), words[operator])
        for operator, text in texts.items()
    )
    return Host(STAGE, stage.start, stage.end, q, context, stage.start, mutants, stage)
