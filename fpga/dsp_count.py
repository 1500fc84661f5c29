"""DSP blocks that a build takes, exactly and in half a second: the elaborated RTL's multiplications, counted
by the rule by which the synthesiser maps each of them.

`triaxis_mul` splits its operands into pieces, each of which fits one DSP48E1. The synthesiser (synth_xilinx
of yosys) leaves a piece to look-up tables where an operand has fewer than 2 bits, or what is used of the
product fewer than 9, once it has dropped what is constant or unused:

  - where both operands have a sign bit that is always 0, both lose it. Lower pieces have such a bit; the top
    piece of a margin has one too;
  - a threshold leaves out the two highest bits of its product, which are always equal to the sign.

fpga/tests/test_dsp_count.py compares the counts with those of the synthesiser.
"""

import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.fpga.board_build import CORE, TOP, bitstream_sources
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole

_MULTIPLIER = "triaxis_mul"
# The multiplier whose second operand is a margin with a leading 0, and how much of its product is not used.
_THRESHOLD, _UNUSED = "triaxis_threshold", 2
# Ports of a DSP48E1, and what is too narrow for one; see `synth_xilinx` in yosys.
_PORT_A, _PORT_B = 25, 18
_LEAST_OPERAND, _LEAST_PRODUCT = 2, 9


@dataclass(frozen=True)
class DspCount:
    """What a build multiplies.

    ``products``: multiplications of the algorithm; ``pieces``: multiplier cells that they are split into;
    ``dsps``: the cells that become a DSP48E1 each, the rest being look-up tables.
    """

    products: int
    pieces: int
    dsps: int


@dataclass(frozen=True)
class _Product:
    """Operands as wide as this, in bits; ``unused`` high bits of the product; b with a leading 0 or not."""

    a: int
    b: int
    unused: int = 0
    b_leads_with_0: bool = False

    def count(self) -> DspCount:
        """Return what the product takes, split as `triaxis_mul` splits it."""
        first_on_a = _cells(self.a, self.b) <= _cells(self.b, self.a)
        x, y = (self.a, self.b) if first_on_a else (self.b, self.a)
        cells = [
            (i, j) for i in _pieces(x, _PORT_A, self.b_leads_with_0 and not first_on_a)
            for j in _pieces(y, _PORT_B, self.b_leads_with_0 and first_on_a)
        ]  # fmt: skip
        return DspCount(1, len(cells), sum(_takes_dsp(i, j, self.unused) for i, j in cells))


@dataclass(frozen=True)
class _Piece:
    """Bits of an operand that one cell takes; ``leads_with_0``: the highest of them is constant."""

    bits: int
    top: bool
    leads_with_0: bool


def _pieces(bits: int, port: int, leads_with_0: bool) -> list[_Piece]:
    """Return the pieces of an operand, lowest first: the lower ones hold one bit less than the port."""
    count = 1 + max(0, -(-(bits - port) // (port - 1)))
    lower = [_Piece(port, top=False, leads_with_0=True) for _ in range(count - 1)]
    return [*lower, _Piece(bits - (count - 1) * (port - 1), top=True, leads_with_0=leads_with_0)]


def _cells(x: int, y: int) -> int:
    return len(_pieces(x, _PORT_A, False)) * len(_pieces(y, _PORT_B, False))


def _takes_dsp(x: _Piece, y: _Piece, unused: int) -> bool:
    """Return whether the synthesiser makes a DSP block of the product of two pieces."""
    used = x.bits + y.bits - (unused if x.top and y.top else 0)
    dropped = int(x.leads_with_0 and y.leads_with_0)
    narrow, wide = sorted((x.bits - dropped, y.bits - dropped))
    return narrow >= _LEAST_OPERAND and min(used, narrow + wide) >= _LEAST_PRODUCT


def count_dsps(sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int]) -> DspCount:
    """Elaborate a top module and count. ``sources`` in the order in which they compile.

    Raises InputError where the RTL does not elaborate.
    """
    total: Counter[str] = Counter()
    for product, times in _products(sources, include, top, parameters).items():
        total.update({name: times * value for name, value in asdict(product.count()).items()})
    return DspCount(total["products"], total["pieces"], total["dsps"])


def _products(
    sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int]
) -> Counter[_Product]:
    """Return the multiplications of the elaborated design: those of `triaxis_mul`, and all others."""
    from pyslang import ast

    found: Counter[_Product] = Counter()

    def visitor(module: str) -> Any:
        def visit(node: Any) -> Any:
            kind = node.kind.name
            if kind == "GenerateBlock" and node.isUninstantiated:
                return ast.VisitAction.Skip
            if kind == "Instance" and node.definition.name == _MULTIPLIER:
                found[_of_multiplier(node, module)] += 1
                return ast.VisitAction.Skip
            if kind == "Instance":
                node.body.visit(visitor(node.definition.name))
                return ast.VisitAction.Skip
            if kind == "BinaryOp" and node.op == ast.BinaryOperator.Multiply:
                found.update(_of_expression(node, context))
            return ast.VisitAction.Advance

        return visit

    compilation = _compilation(sources, include, top, parameters)
    instances = compilation.getRoot().topInstances
    errors = [str(d) for d in compilation.getAllDiagnostics() if d.isError()]
    if errors or not instances:
        values = ", ".join(f"{name} = {value}" for name, value in parameters.items())
        raise InputError(f"{top} with {values}: does not elaborate: check the parameters' ranges")
    context = ast.EvalContext(instances[0])
    for instance in instances:
        instance.visit(visitor(top))
    return found


def _compilation(sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int]) -> Any:
    try:
        import pyslang
        from pyslang.ast import Compilation, CompilationOptions
        from pyslang.syntax import SyntaxTree
    except ImportError as error:
        raise InputError("pyslang: not installed: run `make setup`") from error
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


def _of_multiplier(instance: Any, within: str) -> _Product:
    a, b = (int(instance.body.find(name).value.value) for name in ("AWidth", "BWidth"))
    if within == _THRESHOLD:
        return _Product(a, b, unused=_UNUSED, b_leads_with_0=True)
    return _Product(a, b)


def _of_expression(node: Any, context: Any) -> Iterable[_Product]:
    """Yield a multiplication outside `triaxis_mul`, which works on unsigned numbers; none of constants."""
    constants = [_constant(side, context) for side in (node.left, node.right)]
    known = [value for value in constants if value is not None]
    # Powers of two are shifts.
    if len(known) == 2 or any(value & (value - 1) == 0 for value in known):
        return
    widths = [
        _stripped(side).type.bitWidth if value is None else value.bit_length()
        for side, value in zip((node.left, node.right), constants, strict=True)
    ]
    yield _Product(widths[0], widths[1])


def _stripped(expression: Any) -> Any:
    while expression.kind.name == "Conversion":
        expression = expression.operand
    return expression


def _constant(expression: Any, context: Any) -> int | None:
    value = expression.eval(context)
    return int(value.value) if value else None


class DspCounts:
    """Counts of the core and of the whole board in a folder of RTL, kept in a file from run to run."""

    def __init__(self, dut: Path, kept: Path | None = None) -> None:
        """Count the RTL in ``dut``; ``kept``: the file, which holds for these very sources only."""
        self._dut, self._kept = dut, kept
        self._board = bitstream_sources(dut)
        digest = hashlib.sha256(Path(__file__).read_bytes())
        for source in (*self._board, *sorted((dut / "core").glob("*.svh"))):
            digest.update(source.name.encode() + b"\0" + source.read_bytes() + b"\0")
        self._key = digest.hexdigest()
        self._counts = self._read()

    def core(self, width: int, margin_bits: int, edge_box: bool = True) -> DspCount:
        """Return the count of `triaxis_core`."""
        return self._count(CORE, {"W": width, "M": margin_bits, "EdgeBox": int(edge_box)})

    def board(self, width: int, margin_bits: int, depth: int, group: int, lanes: int) -> DspCount:
        """Return the count of the board's top."""
        sizes = {"Depth": depth, "Group": group, "Lanes": lanes}
        return self._count(TOP, {"W": width, "M": margin_bits, **sizes})

    def _count(self, top: str, parameters: Mapping[str, int]) -> DspCount:
        name = " ".join([top, *(f"{key}={value}" for key, value in sorted(parameters.items()))])
        if name not in self._counts:
            # The files of the core come first in the board's list, and know nothing of what follows.
            self._counts[name] = count_dsps(self._board, self._dut / "core", top, parameters)
            self._write()
        return self._counts[name]

    def _read(self) -> dict[str, DspCount]:
        """Return what is kept; nothing where it is of other sources or damaged: it is soon made anew."""
        if self._kept is None:
            return {}
        try:
            content = json.loads(self._kept.read_text(encoding="utf-8"))
            if content["sources"] != self._key:
                return {}
            return {name: DspCount(**count) for name, count in content["counts"].items()}
        except (OSError, ValueError, KeyError, TypeError, AttributeError):
            return {}

    def _write(self) -> None:
        if self._kept is not None:
            counts = {name: asdict(count) for name, count in self._counts.items()}
            write_whole(self._kept, json.dumps({"sources": self._key, "counts": counts}, indent=2) + "\n")
