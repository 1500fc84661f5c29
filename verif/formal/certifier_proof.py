"""Proves, on its netlist, that the certifier looks at the axis that its number names, for each of the 32.

Words are read as `triaxis.verif.formal.algebra` says, once for each number. What chooses the vectors of the
axis depends on the number alone, so it is evaluated; what it chooses must have the age of the number that
chose it, so that no pair is looked at along the axis of another. Then, with the ports of the modules left
closed, for all coordinates:

- the components of what is compared are those of the axis by definition, up to one sign;
- the projections are those of all six vertices, from the first of A on, in whose place the comparison has 0;
- margin and axis reach the threshold at one age, and this the comparison when it is due;
- all sums fit, and the answer leaves at the documented age.

The closed modules (products of two numbers, threshold, comparison) have proofs of their own, at the latencies
that are used here.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from pathlib import Path

from triaxis.golden.axes import NUM_AXES
from triaxis.golden.pairs import MAX_WIDTH, MIN_WIDTH
from triaxis.sim.configuration import Configuration
from triaxis.verif.formal.algebra import DataPath, Inputs, Word
from triaxis.verif.formal.cone import Register, of_cells
from triaxis.verif.formal.definition import (
    MARGIN,
    ZERO,
    Polynomial,
    at_corners,
    axes,
    same_up_to_signs,
    variable,
)
from triaxis.verif.formal.netlist import Bit, Cell, Netlist, NetlistError, elaborate
from triaxis.verif.formal.pieces import shapes
from triaxis.verif.formal.proof import Finding, Proof, prove_each
from triaxis.verif.testbench.rtl_package import Package

_TOP = "triaxis_certifier"
_CLOSED = ("triaxis_mul", "triaxis_reach", "triaxis_apart")
_SELECTORS = ("$mux", "$bmux")
# Of a triangle. A port that is an array begins, at its lowest bit, with its last element.
_COORDINATES = 9
# Clocks from the projections to the reach, at the comparison.
_REACH_WAIT = 3


# --- What the number chooses --------------------------------------------------------------------------


@dataclass(frozen=True)
class _Level:
    """What a net of the control is, None where that is not known, and its age; a constant has none (None)."""

    value: bool | None
    age: int | None


_Operands = Sequence[int]
_OPERATIONS: dict[str, Callable[[_Operands], int]] = {
    "$add": lambda of: of[0] + of[1],
    "$sub": lambda of: of[0] - of[1],
    "$div": lambda of: of[0] // of[1],
    "$mod": lambda of: of[0] % of[1],
    "$not": lambda of: ~of[0],
    "$logic_not": lambda of: int(of[0] == 0),
    "$ge": lambda of: int(of[0] >= of[1]),
    "$lt": lambda of: int(of[0] < of[1]),
    "$eq": lambda of: int(of[0] == of[1]),
}
# Of numbers below 0 Python's own answers are others.
_UNSIGNED = ("$div", "$mod")


class _Control:
    """The nets of a netlist that depend on one input alone, for one number at it."""

    def __init__(self, netlist: Netlist, bits: Sequence[Bit], number: int) -> None:
        self._netlist = netlist
        self._known: dict[Bit, _Level] = {"0": _Level(False, None), "1": _Level(True, None)}
        self._known |= {bit: _Level(bool(number >> place & 1), 0) for place, bit in enumerate(bits)}
        self.registers: set[str] = set()

    def level(self, bit: Bit) -> _Level:
        """Return what a net is."""
        if bit not in self._known:
            driver = self._netlist.drivers.get(bit)
            self._known[bit] = _Level(None, None) if driver is None else self._driven(driver[0], driver[2])
        return self._known[bit]

    def _driven(self, cell: Cell, place: int) -> _Level:
        if cell.kind == "$dff":
            self.registers.add(cell.name)
            before = self.level(cell.ports["D"][place])
            return _Level(before.value, None if before.age is None else before.age + 1)
        if cell.kind in _SELECTORS:
            (bit,), age = self.chosen(cell, [place])
            found = self.level(bit)
            return _Level(found.value, self._common_age(cell, [_Level(True, age), found]))
        if cell.kind in _OPERATIONS:
            return self._operation(cell, place)
        raise NetlistError(f"{cell.name}: a cell {cell.kind} on the way of what chooses an axis")

    def chosen(self, cell: Cell, places: Sequence[int]) -> tuple[list[Bit], int | None]:
        """Return the bits that come out of a selector at some places, and the age of what chose them."""
        levels = [self.level(bit) for bit in cell.ports["S"]]
        if any(level.value is None for level in levels):
            raise NetlistError(f"{cell.name}: what it selects by is no function of the axis number")
        number = sum(1 << place for place, level in enumerate(levels) if level.value)
        # The word for 0 first.
        words = cell.ports["A"] if cell.kind == "$bmux" else (*cell.ports["A"], *cell.ports["B"])
        size = cell.parameters["WIDTH"]
        return [words[number * size + place] for place in places], self._common_age(cell, levels)

    def _operation(self, cell: Cell, place: int) -> _Level:
        signed = all(cell.parameters.get(f"{port}_SIGNED", 1) for port in ("A", "B"))
        if signed and cell.kind in _UNSIGNED:
            raise NetlistError(f"{cell.name}: a cell {cell.kind} of numbers with signs")
        operands, every = [], []
        for port in ("A", "B"):
            if port in cell.ports:
                levels = [self.level(bit) for bit in cell.ports[port]]
                value = sum(1 << at for at, level in enumerate(levels) if level.value)
                operands.append(value - (1 << len(levels)) if signed and levels[-1].value else value)
                every += levels
        age = self._common_age(cell, every)
        if any(level.value is None for level in every):
            return _Level(None, age)
        return _Level(bool(_OPERATIONS[cell.kind](operands) >> place & 1), age)

    @staticmethod
    def _common_age(cell: Cell, levels: Sequence[_Level]) -> int | None:
        ages = {level.age for level in levels} - {None}
        if len(ages) > 1:
            raise NetlistError(f"{cell.name}: numbers of several clocks meet")
        return ages.pop() if ages else None


class _ChosenPath(DataPath):
    """The data path of a netlist in which one number chooses between words, for one of its values."""

    def __init__(
        self, netlist: Netlist, inputs: Inputs, package: Package, built: Configuration, control: _Control
    ) -> None:
        super().__init__(netlist, inputs, package, built.width, built.margin_bits)
        self._control = control

    def _gated(self, cell: Cell, bit: Bit, selected: Bit) -> Bit:
        # No operand gates here: selectors choose words, which `word` follows.
        return selected

    def word(self, bits: Sequence[Bit], where: str) -> Word:
        """Return what a word holds, where it was chosen as well: it has the age of the choice then."""
        origins = [self.origin(bit) for bit in bits]
        drivers = [self._netlist.drivers.get(source) for source, _ in origins]
        if any(driver is not None and driver[0].kind == "$eq" for driver in drivers):
            return self._evaluated(bits, where)
        selectors = [driver[0] for driver in drivers if driver is not None and driver[0].kind in _SELECTORS]
        if not selectors:
            return super().word(bits, where)
        cell, clocks = selectors[0], {age for _, age in origins}
        places = [driver[2] for driver in drivers if driver is not None and driver[0] is cell]
        if len(places) != len(bits) or len(clocks) != 1:
            raise NetlistError(f"{where}: bits of several choices, or of several clocks")
        chosen, age = self._control.chosen(cell, places)
        found = self.word(chosen, where)
        at = self.common_age(cell.name, found, Word(ZERO, len(bits), age))
        return Word(found.polynomial, found.bits, at + clocks.pop())

    def _evaluated(self, bits: Sequence[Bit], where: str) -> Word:
        """Return a word that the number alone decides: a component of a unit vector."""
        levels = [self._control.level(bit) for bit in bits]
        ages = {level.age for level in levels} - {None}
        if any(level.value is None for level in levels) or len(ages) != 1:
            raise NetlistError(f"{where}: no function of the axis number, or of several clocks")
        constant = super().word(["1" if level.value else "0" for level in levels], where)
        return Word(constant.polynomial, constant.bits, ages.pop())


# --- What is compared -----------------------------------------------------------------------------------


@cache
def _gaps(number: int) -> tuple[Polynomial, ...]:
    """Return the nine differences of a projection of B and one of A."""
    axis = axes()[number]
    return tuple(b - a for a in axis.on_a for b in axis.on_b)


@cache
def _norm(number: int) -> tuple[int, int, int]:
    """Return n, c and d such that |axis|1 is at most n L^d, and each component c L^d.

    Both are convex in each coordinate, so largest at a corner.
    """
    vector = axes()[number].vector
    variables = sorted({one for component in vector for one in component.variables})
    (degree,) = {component.degree for component in vector if component != ZERO}
    components = abs(at_corners(vector, variables))
    return int(components.sum(0).max()), int(components.max()), degree or 0


class _CertifierProof:
    """Compares what the certifier compares with the definition. Raises NetlistError where they differ."""

    def __init__(self, netlist: Netlist, built: Configuration, package: Package, number: int) -> None:
        """Take an elaborated certifier, and the number of an axis."""
        bits = {
            netlist.inputs[port][place * built.width + bit]: (first + _COORDINATES - 1 - place, bit)
            for port, first in (("a_i", 0), ("b_i", _COORDINATES))
            for place in range(_COORDINATES)
            for bit in range(built.width)
        }
        margin = netlist.inputs["margin_i"][: built.margin_bits]
        bits |= {bit: (MARGIN, place) for place, bit in enumerate(margin)}
        self._netlist, self._built, self._package, self._number = netlist, built, package, number
        self._control = _Control(netlist, netlist.inputs["axis_i"], number)
        self._path = _ChosenPath(netlist, Inputs(bits, "1"), package, built, self._control)

    def registers(self) -> set[str]:
        """Return the names of the registers that values and the number were followed through."""
        return self._path.registers() | self._control.registers

    def age(self) -> int:
        """Prove everything; return the age of the answer."""
        source, late = self._path.origin(self._netlist.outputs["holds_o"][0])
        driver = self._netlist.drivers.get(source)
        if driver is None or driver[0].kind != "triaxis_apart":
            raise NetlistError("its answer is not that of a comparison")
        cell = driver[0]
        on_a, on_b = self._path.elements(cell, "a_i", 2), self._path.elements(cell, "b_i", 3)
        self._projections(cell, on_a, on_b)
        age = self._path.common_age(cell.name, *on_a, *on_b)
        self._reach(cell, age + _REACH_WAIT)
        self._room(cell)
        return age + self._package.call("ApartLatency") + late

    def _projections(self, cell: Cell, on_a: Sequence[Word], on_b: Sequence[Word]) -> None:
        axis = axes()[self._number]
        first = axis.on_a[0]
        for factor in (1, -1):
            wanted_a = {(value - first).scaled(factor) for value in axis.on_a[1:]}
            wanted_b = {(value - first).scaled(factor) for value in axis.on_b}
            if {word.polynomial for word in on_a} == wanted_a and {
                word.polynomial for word in on_b
            } == wanted_b:
                return
        raise NetlistError(f"{cell.name}: what it compares are not the projections on the axis")

    def _reach(self, cell: Cell, age: int) -> None:
        """Prove that the reach of a comparison is margin * |axis|1, and comes at that age."""
        bits = cell.ports["reach_i"]
        if not self._built.margin_bits:
            if set(bits) != {"0"}:
                raise NetlistError(f"{cell.name}: a reach without margins")
            return
        found = self._path.output(bits, "triaxis_reach", "reach_o")
        if found is None:
            raise NetlistError(f"{cell.name}: its reach is not that of triaxis_reach")
        source, late = found
        components = self._path.elements(source, "axis_i", 3)
        if not same_up_to_signs([word.polynomial for word in components], axes()[self._number].vector):
            raise NetlistError(f"{source.name}: not the components of the axis")
        margin = self._path.word(source.ports["margin_i"], source.name)
        if margin.polynomial != variable(MARGIN) or margin.bits != self._built.margin_bits:
            raise NetlistError(f"{source.name}: not the margin")
        start = self._path.common_age(source.name, *components, margin)
        due = start + self._package.call("reach_latency", self._built.width, self._built.margin_bits)
        if due + late != age:
            raise NetlistError(f"{cell.name}: its reach comes at another clock than its projections")

    def _room(self, cell: Cell) -> None:
        """Prove that the sum of absolutes, the reach and the differences fit, by their largest values."""
        width = self._built.width
        norm, component, degree = _norm(self._number)
        bits, largest = self._package.call("axis_width", width), ((1 << width) - 1) ** degree
        if norm * largest >= 1 << bits or component * largest >= 1 << (bits - 1):
            raise NetlistError(f"{cell.name}: an absolute, or the sum of them, does not fit")
        size = self._package.call("span_width", width)
        if len(cell.ports["reach_i"]) >= size:
            raise NetlistError(f"{cell.name}: the reach does not fit what it is compared with")
        for gap in _gaps(self._number):
            extent = gap.extent(width)
            if extent is None or max(extent[1], -1 - extent[0]) >= 1 << (size - 1):
                raise NetlistError(f"{cell.name}: a difference of two projections does not fit")


def prove_certifier(built: Configuration, dut: Path, folder: Path) -> frozenset[Register]:
    """Prove a configuration of the certifier, for each axis; return the registers on the way.

    Raises NetlistError where it fails.
    """
    netlist = elaborate(dut, _TOP, {"W": built.width, "M": built.margin_bits}, _CLOSED, folder)
    package = Package(dut)
    _parameters(netlist, built, package)
    documented = package.call("certifier_latency", built.width)
    passed: set[str] = set()
    for number in range(NUM_AXES):
        proof = _CertifierProof(netlist, built, package, number)
        try:
            age = proof.age()
        except NetlistError as error:
            raise NetlistError(f"axis {number}: {error}") from error
        if age != documented:
            raise NetlistError(f"axis {number}: the answer comes after {age} clocks instead of {documented}")
        passed |= proof.registers()
    return of_cells(passed, _TOP, dut)


def _parameters(netlist: Netlist, built: Configuration, package: Package) -> None:
    """Prove that the closed modules are built for the width and the margin, as their own proofs have them."""
    wanted: Mapping[str, int] = {"W": built.width, "M": built.margin_bits, "Comb": 0}
    products = set(shapes(package))
    for cell in netlist.cells:
        if cell.kind not in _CLOSED:
            continue
        for name, value in wanted.items():
            if cell.parameters.get(name, value) != value:
                raise NetlistError(f"{cell.name}: its {name} is not {value}")
        if cell.kind == "triaxis_mul" and _shape(cell) not in products:
            raise NetlistError(f"{cell.name}: {_shape(cell)} bits are in no proof of the multiplier")


def _shape(cell: Cell) -> tuple[int, int]:
    return cell.parameters["AWidth"], cell.parameters["BWidth"]


@dataclass(frozen=True)
class CertificateProof(Proof):
    """The algebra of the certifier in some configurations."""

    configurations: tuple[Configuration, ...]

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Prove all of them; see `Proof`."""
        late = _late(Package(dut))
        found = prove_each(
            self.name, {one.name: partial(prove_certifier, one, dut) for one in self.configurations}, folder
        )
        problems, facts = (*late, *found.problems), {**found.facts, "axes": NUM_AXES}
        return replace(found, problems=problems, facts=facts)


def _late(package: Package) -> list[str]:
    """Return at which widths and margins the reach would come after the projections that it is for."""
    return [
        f"certificate: the reach comes late at W = {width}, M = {bits}"
        for width in range(MIN_WIDTH, MAX_WIDTH + 1)
        for bits in range(1, width + 1)
        if package.call("reach_latency", width, bits) > package.call("inner_latency", width) + _REACH_WAIT
    ]


def certificate(configurations: tuple[Configuration, ...]) -> Proof:
    """Return the proof for these configurations of the certifier."""
    return CertificateProof(
        "certificate",
        "For each number from 0 to 31 the certifier compares exactly the projections of all six vertices on "
        "the axis of the definition that has this number, with a reach of margin * |axis|1, all of one pair, "
        "without overflow, for all coordinates; its answer comes after exactly the documented latency; the "
        "reach is in time at every W and M.",
        "polynomial identities on the elaborated netlist, the axis number case by case",
        {"configurations": ", ".join(one.name for one in configurations)},
        (
            "multipliers, reach and comparison do what their own proofs say (`multiply_wide`, `reach`, "
            "`apart`), the last two of which are at the widths of W = 16 or smaller ones",
        ),
        configurations,
    )
