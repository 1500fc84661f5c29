"""The assertions of a file: their names, and what makes each of them look."""

from pathlib import Path
from typing import TypeVar

import pyslang

from triaxis.golden.errors import InputError

Node = TypeVar("Node", bound=pyslang.syntax.SyntaxNode)


def assertion_names(path: Path) -> list[str]:
    """Return the assertions of a file as "<module>.<label>"; raise InputError where one has no label."""
    tree = _parsed(path)
    return [
        f"{module.header.name.valueText}.{_label(path, assertion)}"
        for module in nodes(tree.root, pyslang.syntax.ModuleDeclarationSyntax)
        for assertion in nodes(module, pyslang.syntax.ConcurrentAssertionStatementSyntax)
    ]


def with_antecedents(path: Path) -> str:
    """Return a file's text with a cover property of the left side of each assertion that has one.

    It is named as the assertion is: one that never fires its left side asserts nothing.
    """
    # The tree must outlive its nodes.
    text, tree, added = path.read_text(encoding="utf-8"), _parsed(path), dict[int, str]()
    for assertion in nodes(tree.root, pyslang.syntax.ConcurrentAssertionStatementSyntax):
        rule = assertion.propertySpec
        if isinstance(rule.expr, pyslang.syntax.BinaryPropertyExprSyntax):
            when = f"{rule.clocking}{'' if rule.disable is None else rule.disable} {rule.expr.left}"
            end = assertion.sourceRange.end.offset
            added[end] = f" {_label(path, assertion)}Antecedent : cover property ({' '.join(when.split())});"
    for end in sorted(added, reverse=True):
        text = text[:end] + added[end] + text[end:]
    return text


def _parsed(path: Path) -> pyslang.syntax.SyntaxTree:
    tree = pyslang.syntax.SyntaxTree.fromFile(str(path))
    if any(found.isError() for found in tree.diagnostics):
        raise InputError(f"{path}: no valid SystemVerilog: correct it, its assertions cannot be read")
    return tree


def nodes(root: pyslang.syntax.SyntaxNode, kind: type[Node]) -> list[Node]:
    """Return the nodes of a kind in a tree of syntax, in the order of the text."""
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
