"""Which parts of dut/ a target elaborates, and what the package's functions give: by pyslang, in no time."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.sim.paths import DUT
from triaxis.verif.mutation.syntax import kind, read_source, span
from triaxis.verif.mutation.targets import AnyTarget


@dataclass(frozen=True)
class Elaborated:
    """Where the modules and generate blocks begin that a target elaborates: (file, offset).

    Only of files whose mutants are looked for there.
    """

    blocks: frozenset[tuple[str, int]]

    def holds(self, file: str, block: int) -> bool:
        """Return whether the block that begins there is elaborated."""
        return (file, block) in self.blocks


def _compilation(dut: Path, target: AnyTarget, parameters: Iterable[str]) -> tuple[Any, Any]:
    import pyslang
    from pyslang.ast import Compilation, CompilationOptions
    from pyslang.syntax import SyntaxTree

    options = CompilationOptions()
    options.topModules = {target.top}
    options.paramOverrides = list(parameters)
    bag = pyslang.Bag()
    bag.compilationOptions = options
    manager = pyslang.SourceManager()
    manager.addUserDirectories(str(dut))
    compilation = Compilation(bag)
    for source in target.sources(dut):
        compilation.addSyntaxTree(SyntaxTree.fromFile(str(source), manager, bag))
    return compilation, manager


def elaborated(target: AnyTarget, dut: Path = DUT) -> Elaborated:
    """Return what a target elaborates."""
    import pyslang.ast as ast

    parameters = [f"{name}={value}" for name, value in target.parameters.items()]
    compilation, manager = _compilation(dut, target, parameters)
    blocks: set[tuple[str, int]] = set()

    def visit(symbol: Any) -> Any:
        name = str(symbol.kind).rpartition(".")[2]
        if name == "GenerateBlock" and symbol.isUninstantiated:
            return ast.VisitAction.Skip
        if name in ("GenerateBlock", "InstanceBody") and symbol.syntax is not None:
            start = symbol.syntax.sourceRange.start
            if name == "GenerateBlock" and symbol.isUninstantiated:
                return ast.VisitAction.Skip
            blocks.add((_file(manager.getFileName(start), dut), start.offset))
        return ast.VisitAction.Advance

    for instance in compilation.getRoot().topInstances:
        instance.visit(visit)
    # Functions and constants of the package serve every target.
    blocks.update(_packages(target, dut))
    return Elaborated(frozenset(block for block in blocks if target.mutates(block[0])))


def _file(name: str, dut: Path) -> str:
    return Path(name).resolve().relative_to(dut.resolve()).as_posix()


def _packages(target: AnyTarget, dut: Path) -> list[tuple[str, int]]:
    found: list[tuple[str, int]] = []
    for source in target.sources(dut):
        if source.name.endswith("_pkg.sv"):
            parsed = read_source(source, dut)
            found += [(parsed.name, span(m)[0]) for m in parsed.modules if kind(m) == "PackageDeclaration"]
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
    compilation.addSyntaxTree(SyntaxTree.fromFile(str(dut / "core" / "triaxis_pkg.sv")))
    compilation.addSyntaxTree(SyntaxTree.fromText(f"module asked; {asked} endmodule"))
    body = compilation.getRoot().topInstances[0].body
    values = [str(body.find(f"V{number}").value) for number in range(len(points))]
    numbers = [value.rpartition("d")[2] for value in values]
    return [int(number) for number in numbers] if all(map(str.isdigit, numbers)) else None
