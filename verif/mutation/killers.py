"""What decides a mutant's fate beside the RTL: a result is of today's where none of it has changed."""

import ast
from collections.abc import Iterator
from pathlib import Path

from triaxis.sim.build import content_hash
from triaxis.sim.paths import ROOT, VERIF
from triaxis.sim.toolchain import verilator

_PACKAGE = "triaxis"
_OTHER_THAN_PYTHON = (
    (VERIF / "mutation", ("*.cpp", "*.h", "*.toml")),
    (VERIF / "mutation" / "exact_core", ("*.sv", "*.cpp")),
    (VERIF / "core" / "sva", ("*.sv", "*.vlt")),
    (VERIF / "mesh" / "sva", ("*.sv", "*.vlt")),
    (VERIF / "core" / "kept", ("*.json",)),
    (VERIF / "formal" / "rtl", ("*.sv",)),
    (ROOT / "golden", ("bulk.cpp", "*.h")),
)


def killers() -> list[Path]:
    """Return the files that generate, play, judge and excuse mutants, in a fixed order."""
    others = [
        path
        for folder, patterns in _OTHER_THAN_PYTHON
        for pattern in patterns
        for path in sorted(folder.glob(pattern))
    ]
    return [*sorted(_with_what_they_import(sorted((VERIF / "mutation").glob("*.py")))), *others]


def killers_hash() -> str:
    """Return the hash of these files and of Verilator's version."""
    return content_hash(killers(), str(verilator()))


def _with_what_they_import(modules: list[Path]) -> set[Path]:
    """Return the files, and those of this package that they import, however far away."""
    found: set[Path] = set()
    waiting = list(modules)
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _imported(path)
    return found


def _imported(path: Path) -> Iterator[Path]:
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        names: list[str] = []
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module:
            # What is imported from a package can be one of its modules.
            names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
        for name in names:
            package, *parts = name.split(".")
            file = ROOT.joinpath(*parts).with_suffix(".py")
            if package == _PACKAGE and file.exists():
                yield file
