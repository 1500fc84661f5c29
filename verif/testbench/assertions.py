"""The assertions of a folder, by name."""

from pathlib import Path
from typing import TypeVar

import pyslang

from triaxis.golden.errors import InputError

Node = TypeVar("Node", bound=pyslang.syntax.SyntaxNode)


def assertion_names(path: Path) -> list[str]:
    """Return the assertions of a file as "<module>.<label>"; raise InputError where one has no label."""
    tree = pyslang.syntax.SyntaxTree.fromFile(str(path))
    if any(found.isError() for found in tree.diagnostics):
        raise InputError(f"{path}: no valid SystemVerilog: correct it, its assertions cannot be read")
    return [
        f"{module.header.name.valueText}.{_label(path, assertion)}"
        for module in _nodes(tree.root, pyslang.syntax.ModuleDeclarationSyntax)
        for assertion in _nodes(module, pyslang.syntax.ConcurrentAssertionStatementSyntax)
    ]


def _nodes(root: pyslang.syntax.SyntaxNode, kind: type[Node]) -> list[Node]:
    found: list[Node] = []

    def visit(node: object) -> None:
        if isinstance(node, kind):
            found.append(node)

    root.visit(visit)
    return found


def _label(path: Path, assertion: pyslang.syntax.ConcurrentAssertionStatementSyntax) -> str:
    if assertion.label is None:
        raise InputError(f"{path}: an assertion without a label: give it one, the testplan names it so")
    return assertion.label.name.valueText
