"""A file of RTL as a syntax tree, and what the operators need to know of it: text, declarations, ports."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.verif.mutation.mutant import normalised

# pyslang's nodes have one class for each of hundreds of productions; they are told apart by their kind.
Node = Any

_BLOCKS = ("GenerateBlock", "ModuleDeclaration", "PackageDeclaration")
_STAGE = re.compile(r"`TRIAXIS_STAGE\((\w+), (\w+)\)")
# Never moved to another net: what the core does without them is no question of its function.
_NO_NEIGHBOUR = frozenset({"clk_i", "rst_ni"})


def kind(node: Node) -> str:
    """Return the kind of a node: "AddExpression", .."""
    return str(node.kind).rpartition(".")[2]


def span(node: Node) -> tuple[int, int]:
    """Return where a node's text begins and ends."""
    return node.sourceRange.start.offset, node.sourceRange.end.offset


def children(node: Node) -> Iterator[Node]:
    """Iterate over the nodes directly below, without tokens."""
    return (child for child in node if hasattr(child, "sourceRange"))


def below(node: Node) -> Iterator[Node]:
    """Iterate over a node and all nodes below it, in the order of the text."""
    yield node
    for child in children(node):
        yield from below(child)


@dataclass(frozen=True)
class Stage:
    """A use of the macro TRIAXIS_STAGE: where it stands, its register and what that takes."""

    start: int
    end: int
    register: str
    value: str


@dataclass(frozen=True)
class Declared:
    """A name that a module declares: its unpacked dimensions, and the next one of the same type.

    ``signed``: whether its type is. ``sizes``: its own dimensions as text, without those of its type.
    """

    dimensions: int
    neighbour: str | None
    signed: bool = False
    sizes: tuple[str, ...] = ()


@dataclass(frozen=True)
class SourceFile:
    """One file of RTL. Uses of the macro TRIAXIS_STAGE are no part of the tree: see ``stages``."""

    name: str
    text: str
    stages: tuple[Stage, ...]
    root: Node = field(repr=False)

    def of(self, node: Node) -> str:
        """Return a node's text, without comments before it."""
        start, end = span(node)
        return self.text[start:end]

    def line(self, offset: int) -> int:
        """Return the number of the line of an offset."""
        return self.text.count("\n", 0, offset) + 1

    @cached_property
    def modules(self) -> list[Node]:
        """Return the modules and packages of the file."""
        return [
            node for node in below(self.root) if kind(node) in ("ModuleDeclaration", "PackageDeclaration")
        ]


def read_source(path: Path, dut: Path) -> SourceFile:
    """Parse a file of ``dut``, by whose place there it is named; InputError where it is no SystemVerilog."""
    from pyslang.syntax import SyntaxTree

    text = path.read_text()
    if not text.isascii():
        raise InputError(f"{path}: not ASCII: offsets of mutants count bytes; write it in ASCII")
    stages = tuple(Stage(match.start(), match.end(), match[1], match[2]) for match in _STAGE.finditer(text))
    bare = re.sub(r"^`include.*$", lambda match: " " * len(match[0]), text, flags=re.MULTILINE)
    for stage in stages:
        bare = bare[: stage.start] + " " * (stage.end - stage.start) + bare[stage.end :]
    tree = SyntaxTree.fromText(bare, path.name)
    errors = [item for item in tree.diagnostics if item.isError()]
    if errors:
        line = bare.count("\n", 0, errors[0].location.offset) + 1
        raise InputError(f"{path}:{line}: does not parse: correct it before it is mutated")
    return SourceFile(path.relative_to(dut).as_posix(), text, stages, tree.root)


def module_name(module: Node) -> str:
    """Return the name of a module or package."""
    return str(module.header.name.valueText)


def blocks(module: Node) -> list[tuple[int, int]]:
    """Return where a module, and the generate blocks in it, begin and end."""
    return [span(node) for node in below(module) if kind(node) in _BLOCKS]


def _dimensions(declarator: Node) -> list[Node]:
    return [child for child in children(declarator) if kind(child) == "VariableDimension"]


def _declarators(node: Node) -> list[Node]:
    return [child for child in children(node) if kind(child) == "Declarator"]


def _declared(source: SourceFile, module: Node) -> Iterator[tuple[int, str, tuple[str, ...], str]]:
    """Iterate over declarations: scope, name, unpacked dimensions, and the type with these as text."""
    for node in below(module):
        if kind(node) in ("ImplicitAnsiPort", "DataDeclaration"):
            header = source.of(next(iter(children(node))))
            scope = span(module)[0] if kind(node) == "ImplicitAnsiPort" else span(node.parent)[0]
            for declarator in _declarators(node):
                sizes = tuple(normalised(source.of(dimension)) for dimension in _dimensions(declarator))
                yield scope, str(declarator.name.valueText), sizes, normalised(header) + "".join(sizes)


def type_dimensions(source: SourceFile, module: Node) -> dict[str, int]:
    """Return the unpacked dimensions of the types that a module defines."""
    result: dict[str, int] = {}
    for node in below(module):
        if kind(node) == "TypedefDeclaration":
            named = result.get(source.of(node.type).strip(), 0)
            result[str(node.name.valueText)] = named + len(_dimensions(node))
    return result


def _signed_types(source: SourceFile, module: Node) -> re.Pattern[str]:
    """Return a pattern of the texts of types that are signed. Those of other modules may be."""
    known = [
        str(node.name.valueText)
        for node in below(module)
        if kind(node) == "TypedefDeclaration" and "signed" in source.of(node)
    ]
    return re.compile(rf"\b({'|'.join(['signed', 'int', 'T', *known])})\b")


def declarations(source: SourceFile, module: Node) -> dict[str, Declared]:
    """Return what a module declares, ports included.

    A name's neighbour is the next one, cyclically, of the same direction and type in the same scope: of
    those with the same suffix (the same stage) where there are any.
    """
    types = type_dimensions(source, module)
    signed = _signed_types(source, module)
    found = list(_declared(source, module))
    result: dict[str, Declared] = {}
    for scope, name, sizes, text in found:
        alike = [
            other
            for its_scope, other, _, its_text in found
            if (its_scope, its_text) == (scope, text) and other not in _NO_NEIGHBOUR
        ]
        extra = next((count for name_, count in types.items() if re.match(rf"{name_}\b", text)), 0)
        result[name] = Declared(len(sizes) + extra, _neighbour(name, alike), bool(signed.search(text)), sizes)
    return result


def enumerators(module: Node) -> dict[str, Declared]:
    """Return the values of enumerations that a module or package defines; the neighbour is the next value."""
    result: dict[str, Declared] = {}
    for node in below(module):
        if kind(node) == "EnumType":
            names = [str(value.name.valueText) for value in _declarators(node)]
            nexts = names[1:] + names[:1]
            result |= {name: Declared(0, after) for name, after in zip(names, nexts, strict=True)}
    return result


def _neighbour(name: str, alike: list[str]) -> str | None:
    if name not in alike:
        return None
    same_stage = [other for other in alike if other.rpartition("_")[2] == name.rpartition("_")[2]]
    choice = same_stage if len(same_stage) > 1 else alike
    return choice[(choice.index(name) + 1) % len(choice)] if len(choice) > 1 else None


def inputs(module: Node) -> frozenset[str]:
    """Return the names of a module's input ports."""
    ports = (node for node in below(module) if kind(node) == "ImplicitAnsiPort")
    return frozenset(
        str(_declarators(port)[0].name.valueText)
        for port in ports
        if str(port.header).strip().startswith("input") or "input " in str(port.header)
    )


def base_name(text: str) -> str:
    """Return the name with which an expression begins."""
    match = re.match(r"\s*([A-Za-z_]\w*)", text)
    return match[1] if match else ""
