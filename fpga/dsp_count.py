"""DSP blocks that a build takes, exactly and in half a second, counted on the elaborated RTL.

`triaxis_mul` splits its operands into pieces and takes one DSP48E1 for each product of two wide ones; narrow
pieces are multiplied by additions. fpga/tests/test_dsp_count.py compares the counts with those of the
synthesiser.
"""

import json
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.fpga.board_build import TOP, bitstream_sources
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash
from triaxis.sim.configuration import CORE_TOP
from triaxis.sim.paths import ROOT
from triaxis.sim.slang import compiled

_MULTIPLIER = "triaxis_mul"
# Its generate blocks for the product of two pieces, and for that of two wide ones.
_PIECE, _WIDE = "g_product", "g_wide"
# Ports of a DSP48E1 for numbers without a sign, and what is too narrow for one; see `synth_xilinx` in yosys.
_PORT_A, _PORT_B = 24, 17
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


def count_dsps(sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int]) -> DspCount:
    """Elaborate a top module and count. ``sources`` in the order in which they compile.

    Raises InputError where the RTL does not elaborate.
    """
    from pyslang import ast

    total: Counter[str] = Counter()

    def visit(node: Any) -> Any:
        kind = node.kind.name
        if kind == "GenerateBlock" and node.isUninstantiated:
            return ast.VisitAction.Skip
        if kind == "Instance" and node.definition.name == _MULTIPLIER:
            node.body.visit(visit_pieces)
            total["products"] += 1
            return ast.VisitAction.Skip
        # What a constant is computed with is no hardware; of a function its calls are, with other arguments.
        if kind in ("Parameter", "Subroutine"):
            return ast.VisitAction.Skip
        if kind == "Call" and isinstance(node.subroutine, ast.SubroutineSymbol) and not node.eval(context):
            node.subroutine.body.visit(visit)
        if kind == "BinaryOp" and node.op == ast.BinaryOperator.Multiply:
            total.update(_of_expression(node, context))
        return ast.VisitAction.Advance

    def visit_pieces(node: Any) -> Any:
        if node.kind.name == "GenerateBlock" and not node.isUninstantiated:
            total["pieces"] += node.hierarchicalPath.rpartition(".")[2].startswith(f"{_PIECE}[")
            total["dsps"] += node.name == _WIDE
        return ast.VisitAction.Advance

    compilation = compiled(sources, include, top, parameters)
    instances = compilation.getRoot().topInstances
    errors = [str(d) for d in compilation.getAllDiagnostics() if d.isError()]
    if errors or not instances:
        values = ", ".join(f"{name} = {value}" for name, value in parameters.items())
        raise InputError(f"{top} with {values}: does not elaborate: check the parameters' ranges")
    context = ast.EvalContext(instances[0])
    for instance in instances:
        instance.visit(visit)
    return DspCount(total["products"], total["pieces"], total["dsps"])


def _of_expression(node: Any, context: Any) -> dict[str, int]:
    """Return what a multiplication outside `triaxis_mul` takes, of unsigned numbers; none of constants."""
    constants = [_constant(side, context) for side in (node.left, node.right)]
    known = [value for value in constants if value is not None]
    # Powers of two are shifts.
    if len(known) == 2 or any(value & (value - 1) == 0 for value in known):
        return {}
    narrow, wide = sorted(
        _stripped(side).type.bitWidth if value is None else value.bit_length()
        for side, value in zip((node.left, node.right), constants, strict=True)
    )
    blocks = min(-(-wide // _PORT_A) * -(-narrow // _PORT_B), -(-wide // _PORT_B) * -(-narrow // _PORT_A))
    takes = narrow >= _LEAST_OPERAND and narrow + wide >= _LEAST_PRODUCT
    return {"products": 1, "pieces": blocks, "dsps": blocks * takes}


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
        counting = Path(__file__), ROOT / "sim" / "slang.py"
        self._key = content_hash([*counting, *self._board, *sorted((dut / "core").glob("*.svh"))])
        self._counts = self._read()

    def core(self, width: int, margin_bits: int, edge_box: bool = True) -> DspCount:
        """Return the count of `triaxis_core`."""
        return self._count(CORE_TOP, {"W": width, "M": margin_bits, "EdgeBox": int(edge_box)})

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
