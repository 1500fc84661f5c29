"""The RTL as slang elaborates it: what of it is looked for, counted and described, without a simulator."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any


def compiled(sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int]) -> Any:
    """Return a module as slang elaborates it. ``sources`` in the order in which they compile."""
    # Only where it is needed: what it says of RTL is asked for seldom, and loading it takes its time.
    import pyslang
    from pyslang.ast import Compilation, CompilationOptions
    from pyslang.syntax import SyntaxTree

    options = CompilationOptions()
    options.topModules = {top}
    options.paramOverrides = [f"{name}={value}" for name, value in parameters.items()]
    bag = pyslang.Bag()
    bag.compilationOptions = options
    manager = pyslang.SourceManager()
    manager.addUserDirectories(str(include))
    compilation = Compilation(bag)
    for source in sources:
        compilation.addSyntaxTree(SyntaxTree.fromFile(str(source), manager, bag))
    return compilation
