"""Proves, on its netlist, that the split multiplier multiplies, for operands of their real widths.

Each operand is cut into slices, the top one signed, and each slice is a variable. Products of slices,
shifts and sums are then polynomials in these, modulo the width of the result, and the last one must be the
product of the two operands: the sums of their slices, each at its place. Where a word is sign-extended, the
value that it holds must fit it, by the ranges of the slices.
"""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import prod
from pathlib import Path

from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.programs import read_slang
from triaxis.verif.formal.cone import of_cells
from triaxis.verif.formal.definition import ZERO, Polynomial, variable
from triaxis.verif.formal.netlist import (
    Bit,
    Cell,
    Netlist,
    NetlistError,
    flat,
    read_netlist,
    run_yosys,
)
from triaxis.verif.formal.proof import Finding, Proof
from triaxis.verif.testbench.rtl_package import Package

_TOP = "triaxis_mul"
# Multiplies a narrow piece, in so many clocks; it has a proof of its own.
_NARROW, _NARROW_LATENCY = "triaxis_narrow_mul", 2


@dataclass(frozen=True)
class _Slice:
    """Bits low .. high of an operand, as a number with or without a sign."""

    operand: str
    low: int
    high: int
    signed: bool

    @property
    def largest(self) -> int:
        """Return the largest absolute."""
        bits = self.high - self.low + 1
        return 1 << (bits - 1) if self.signed else (1 << bits) - 1


@dataclass(frozen=True)
class _Value:
    """What a word holds, a polynomial in slices by their numbers, modulo its bits; and its age."""

    polynomial: Polynomial
    bits: int
    age: int

    @property
    def is_slice(self) -> bool:
        """Return whether this is one slice of an operand, and not a result."""
        return [len(monomial) for monomial, _ in self.polynomial.terms] == [1]


class _Multiplier:
    """The netlist of one multiplier."""

    def __init__(self, netlist: Netlist) -> None:
        self._netlist = netlist
        self._inputs = {
            bit: (name, place) for name in ("a_i", "b_i") for place, bit in enumerate(netlist.inputs[name])
        }
        self._known: dict[str, _Value] = {}
        self._slices: list[_Slice] = []
        # The names of the registers on the way.
        self.passed: set[str] = set()

    def prove(self) -> int:
        """Prove that the output is the product; return its age."""
        found = self._word(self._netlist.outputs["product_o"])
        modulus = 1 << len(self._netlist.outputs["product_o"])
        left, right = (self._operand(found.polynomial, name) for name in ("a_i", "b_i"))
        beyond = (left * right - found.polynomial).terms
        if any(factor % modulus for _, factor in beyond):
            raise NetlistError("the pieces do not add up to the product")
        return found.age

    def _operand(self, product: Polynomial, operand: str) -> Polynomial:
        """Return the sum of the slices of an operand, after the check that they are all of it."""
        slices = [self._slices[number] for number in product.variables]
        parts = sorted((one for one in slices if one.operand == operand), key=lambda one: one.low)
        ends = [-1, *(one.high for one in parts)]
        whole = ends[-1] == len(self._netlist.inputs[operand]) - 1
        joined = all(one.low == end + 1 for one, end in zip(parts, ends, strict=False))
        if not (whole and joined and [one.signed for one in parts] == [False] * (len(parts) - 1) + [True]):
            raise NetlistError(f"the slices of {operand} are not the operand")
        return sum((self._variable(one).scaled(1 << one.low) for one in parts), ZERO)

    def _variable(self, one: _Slice) -> Polynomial:
        if one not in self._slices:
            self._slices.append(one)
        return variable(self._slices.index(one))

    def _largest(self, polynomial: Polynomial) -> int:
        """Return a bound of the absolute, where the value has no modulus."""
        return sum(
            abs(factor) * prod(self._slices[number].largest for number in monomial)
            for monomial, factor in polynomial.terms
        )

    def _origin(self, bit: Bit) -> tuple[Bit, int]:
        age = 0
        while (driver := self._netlist.drivers.get(bit)) is not None and driver[0].kind == "$dff":
            self.passed.add(driver[0].name)
            bit, age = driver[0].ports["D"][driver[2]], age + 1
        return bit, age

    def _word(self, bits: Sequence[Bit]) -> _Value:
        """Return what a word holds: a shifted value, then zeros or copies of its highest bit."""
        origins = [self._origin(bit) for bit in bits]
        low = next((place for place, (bit, _) in enumerate(origins) if bit != "0"), len(origins))
        core = origins[low:]
        zeros = 0
        while core and core[-1][0] == "0":
            core, zeros = core[:-1], zeros + 1
        copies = 0
        while not zeros and len(core) > 1 and core[-1] == core[-2]:
            core, copies = core[:-1], copies + 1
        ages = {age for _, age in core}
        if len(ages) != 1:
            raise NetlistError("bits of several clocks in a word")
        value = self._slice([bit for bit, _ in core], unsigned=zeros > 0)
        if copies and not value.is_slice and self._largest(value.polynomial) >= 1 << (len(core) - 1):
            raise NetlistError("a piece's product does not fit its bits")
        if zeros and not value.is_slice:
            raise NetlistError("zeros above a value with a sign")
        return _Value(value.polynomial.scaled(1 << low), len(bits), value.age + ages.pop())

    def _slice(self, bits: Sequence[Bit], unsigned: bool) -> _Value:
        """Return the value that consecutive bits are: a slice of an operand, or what a cell puts out."""
        if bits[0] in self._inputs:
            places = [self._inputs.get(bit) for bit in bits]
            name, low = self._inputs[bits[0]]
            if places != [(name, low + place) for place in range(len(bits))]:
                raise NetlistError("not a slice of an operand")
            one = _Slice(name, low, low + len(bits) - 1, not unsigned)
            return _Value(self._variable(one), len(bits), 0)
        driver = self._netlist.drivers.get(bits[0])
        if driver is None or list(bits) != list(driver[0].ports[driver[1]][: len(bits)]):
            raise NetlistError("not the value of a cell")
        return self._cell(driver[0])

    def _narrow(self, cell: Cell) -> _Value:
        wide, narrow = self._word(cell.ports["wide_i"]), self._word(cell.ports["narrow_i"])
        if wide.age != narrow.age or not (wide.is_slice and narrow.is_slice):
            raise NetlistError(f"{cell.name}: it multiplies what are no slices of operands, of one clock")
        bits = len(cell.ports["product_o"])
        return _Value(wide.polynomial * narrow.polynomial, bits, wide.age + _NARROW_LATENCY)

    def _cell(self, cell: Cell) -> _Value:
        if cell.kind == _NARROW:
            return self._known.setdefault(cell.name, self._narrow(cell))
        if cell.name not in self._known:
            left, right = self._word(cell.ports["A"]), self._word(cell.ports["B"])
            if left.age != right.age:
                raise NetlistError(f"{cell.name}: values of several clocks meet")
            if cell.kind == "$mul" and not (left.is_slice and right.is_slice):
                raise NetlistError(f"{cell.name}: it multiplies what is no slice of an operand")
            bits = cell.parameters["Y_WIDTH"]
            if min(len(cell.ports["A"]), len(cell.ports["B"])) < bits:
                raise NetlistError(f"{cell.name}: operands narrower than the result")
            if cell.kind not in ("$mul", "$add"):
                raise NetlistError(f"{cell.name}: a cell {cell.kind} in a multiplier")
            first, second = left.polynomial, right.polynomial
            found = first * second if cell.kind == "$mul" else first + second
            self._known[cell.name] = _Value(found, bits, left.age)
        return self._known[cell.name]


def shapes(package: Package) -> list[tuple[int, int]]:
    """Return the widths of operands that the core and the certifier multiply, at every W and M."""
    found = set()
    for width in range(MIN_WIDTH, MAX_WIDTH + 1):
        difference, cross = package.call("diff_width", width), package.call("cross_width", width)
        axis, height = package.call("axis_width", width), package.call("height_width", width)
        found |= {(difference, difference), (cross, height), (axis, difference)}
        found |= {(operand, bits) for operand in (axis + 1, difference + 1) for bits in range(2, width + 2)}
    return sorted(found)


class PiecesProof(Proof):
    """The split multiplier, at all widths of operands that the core has."""

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Prove all shapes; see `Proof`."""
        package = Package(dut)
        every = shapes(package)
        names = [
            "core/triaxis_pkg.sv",
            "core/triaxis_sum.sv",
            "core/triaxis_narrow_mul.sv",
            "core/triaxis_mul.sv",
        ]
        closed = f"--blackboxed-module {_NARROW}"
        script = "; ".join(
            f"{read_slang(flat(names), _TOP, {'AWidth': a, 'BWidth': b}, closed)}; opt_clean; "
            f"write_json mul_{a}_{b}.json; design -reset"
            for a, b in every
        )
        run_yosys(script, dut, names, folder, f"mul_{every[-1][0]}_{every[-1][1]}.json")
        passed: set[str] = set()
        for a, b in every:
            text = (folder / f"mul_{a}_{b}.json").read_text(encoding="utf-8")
            multiplier = _Multiplier(read_netlist(_TOP, json.loads(text)["modules"][_TOP], (_NARROW,)))
            age = multiplier.prove()
            passed |= multiplier.passed
            if age != package.call("mul_latency", a, b):
                raise NetlistError(f"{a} x {b} bits: the product comes after {age} clocks")
        registers = of_cells(passed, _TOP, dut)
        return Finding(log=folder / "yosys.log", facts={"netlists": len(every)}, registers=registers)


def multiply_wide() -> Proof:
    """Return the proof."""
    return PiecesProof(
        "multiply_wide",
        "The pieces of the split multiplier add up to the product, without overflow and at the documented "
        "latency, for operands of all widths the core and the certifier multiply at any W and M.",
        "polynomial identities on the elaborated netlist",
        {"W": f"{MIN_WIDTH}..{MAX_WIDTH}", "M": "0..W"},
        ("the product of two pieces is their product; of narrow ones `multiply_narrow` shows it",),
    )
