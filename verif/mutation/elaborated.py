"""Which parts of dut/ a target elaborates, and what the package's functions give: by pyslang, in no time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.verif.mutation.targets import Target
from triaxis.verif.paths import DUT, rtl_sources


@dataclass(frozen=True)
class Elaborated:
    """Where the modules and generate blocks begin that a target elaborates: (file, offset)."""

    blocks: frozenset[tuple[str, int]]

    def holds(self, file: str, block: int) -> bool:
        """Return whether the block that begins there is elaborated."""
        return (file, block) in self.blocks


def _compilation(dut: Path, top: str, parameters: Iterable[str]) -> tuple[Any, Any]:
    import pyslang
    from pyslang.ast import Compilation, CompilationOptions
    from pyslang.syntax import SyntaxTree

    options = CompilationOptions()
    options.topModules = {top}
    options.paramOverrides = list(parameters)
    bag = pyslang.Bag()
    bag.compilationOptions = options
    manager = pyslang.SourceManager()
    manager.addUserDirectories(str(dut))
    compilation = Compilation(bag)
    for source in rtl_sources():
        compilation.addSyntaxTree(SyntaxTree.fromFile(str(dut / source.name), manager, bag))
    return compilation, manager


def elaborated(target: Target, dut: Path = DUT) -> Elaborated:
    """Return what a target elaborates."""
    import pyslang.ast as ast

    parameters = [f"{name}={value}" for name, value in target.parameters.items()]
    compilation, manager = _compilation(dut, target.top, parameters)
    blocks: set[tuple[str, int]] = set()

    def visit(symbol: Any) -> Any:
        name = str(symbol.kind).rpartition(".")[2]
        if name == "GenerateBlock" and symbol.isUninstantiated:
            return ast.VisitAction.Skip
        if name in ("GenerateBlock", "InstanceBody") and symbol.syntax is not None:
            start = symbol.syntax.sourceRange.start
            if name == "GenerateBlock" and symbol.isUninstantiated:
                return ast.VisitAction.Skip
            blocks.add((Path(manager.getFileName(start)).name, start.offset))
        return ast.VisitAction.Advance

    for instance in compilation.getRoot().topInstances:
        instance.visit(visit)
    # Functions and constants of the package serve every target.
    blocks.update((source.name, offset) for source, offset in _packages(dut))
    return Elaborated(frozenset(blocks))


def _packages(dut: Path) -> list[tuple[Path, int]]:
    from triaxis.verif.mutation.syntax import kind, read_source, span

    found: list[tuple[Path, int]] = []
    for source in rtl_sources():
        if source.name.endswith("_pkg.sv"):
            parsed = read_source(dut / source.name)
            found += [(source, span(m)[0]) for m in parsed.modules if kind(m) == "PackageDeclaration"]
    return found


def core_latencies(dut: Path, points: Sequence[tuple[int, int]]) -> list[int] | None:
    """Return core_latency(W, M) of the package for each (W, M); None where it does not evaluate."""
    import pyslang.ast as ast
    from pyslang.syntax import SyntaxTree

    asked = " ".join(
        f"localparam int unsigned V{number} = triaxis_pkg::core_latency({width}, {margin});"
        for number, (width, margin) in enumerate(points)
    )
    compilation = ast.Compilation()
    compilation.addSyntaxTree(SyntaxTree.fromFile(str(dut / "triaxis_pkg.sv")))
    compilation.addSyntaxTree(SyntaxTree.fromText(f"module asked; {asked} endmodule"))
    body = compilation.getRoot().topInstances[0].body
    values = [str(body.find(f"V{number}").value) for number in range(len(points))]
    numbers = [value.rpartition("d")[2] for value in values]
    return [int(number) for number in numbers] if all(map(str.isdigit, numbers)) else None
