"""Proves, on the elaborated netlist, that the core tests the 32 axes of the definition, for all coordinates.

Every word of the data path is given two things, from the inputs on: the polynomial in the 18 coordinates
and the margin that it holds, and its age, the clocks since those came in. Adders, subtractors and
multipliers act on polynomials; registers add a clock. Then, with the ports of the modules left closed:

- all that meets in a cell has one age, so that no pair is mixed with another;
- where a word is sign-extended, multiplied or compared, its polynomial fits its bits, at every corner of
  the coordinates and so for all of them. Elsewhere two's complement is exact modulo its width;
- the interval test of axis n compares exactly the projections, by definition, of the six vertices on the
  axis, and its threshold is made of the components of that axis, up to signs, and of the margin;
- flags come from the normals and the ten orientations of the definition;
- axis n arrives at bit n of the verdict, all 32 at one age, and the verdict at the queue at the age
  that the package documents, with the tag of its own pair;
- operands are taken exactly where the pair is valid and (with gating) its boxes do not decide it, and the
  flags are masked exactly where they do.

The closed modules (products of two numbers, thresholds, interval and box tests, flags, claim) have proofs of
their own, at the latencies that are used here.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

from triaxis.verif.formal.definition import (
    FIRST_PLANE_AXIS,
    MARGIN,
    ZERO,
    Axis,
    Polynomial,
    at_corners,
    axes,
    normals,
    orientations,
    variable,
)
from triaxis.verif.formal.netlist import Bit, Cell, Netlist, NetlistError, Package

CLOSED = (
    "triaxis_mul", "triaxis_threshold", "triaxis_interval", "triaxis_box", "triaxis_flags", "triaxis_verdict",
)  # fmt: skip

_BOXES = 3


@dataclass(frozen=True)
class Word:
    """A polynomial in so many bits, modulo their number, and its age; a constant has none (None)."""

    polynomial: Polynomial
    bits: int
    age: int | None


@dataclass(frozen=True)
class Inputs:
    """The bits of the inputs: variable and place of each, and the bit that says that a pair is there."""

    bits: Mapping[Bit, tuple[int, int]]
    valid: Bit


@dataclass(frozen=True)
class _Origin:
    """Where a bit comes from before registers: a net, and the clocks since."""

    bit: Bit
    age: int


class DataPath:
    """The data path of a netlist, read as polynomials and ages. Raises NetlistError where it is not so."""

    def __init__(self, netlist: Netlist, inputs: Inputs, package: Package, width: int, margin: int) -> None:
        """Take a netlist in which the modules of `CLOSED` are closed."""
        self._netlist, self._inputs, self._package = netlist, inputs, package
        self._width, self._margin = width, margin
        self._registered = not any(cell.parameters.get("Comb") for cell in netlist.cells)
        self._origins: dict[Bit, _Origin] = {}
        self._values: dict[str, Word] = {}
        self.gates: set[tuple[Bit, int]] = set()

    # --- Bits ---------------------------------------------------------------------------------------

    def origin(self, bit: Bit) -> tuple[Bit, int]:
        """Return the net that a bit comes from through registers and operand gates, and the clocks since."""
        path: list[tuple[Bit, int]] = []
        while bit not in self._origins:
            step = self._register(bit)
            if step is None:
                self._origins[bit] = _Origin(bit, 0)
            else:
                path.append((bit, 1))
                bit = step
        found = self._origins[bit]
        for passed, clocks in reversed(path):
            found = _Origin(found.bit, found.age + clocks)
            self._origins[passed] = found
        return found.bit, found.age

    def _register(self, bit: Bit) -> Bit | None:
        """Return the bit that a register took at the last clock, None where the bit is no register."""
        driver = self._netlist.drivers.get(bit)
        if driver is None or driver[0].kind not in ("$dff", "$aldff"):
            return None
        cell, _, place = driver
        if not cell.parameters["CLK_POLARITY"]:
            raise NetlistError(f"{cell.name}: a register at the wrong edge")
        data = cell.ports["D"][place]
        selecting = self._netlist.drivers.get(data)
        if selecting is None or selecting[0].kind != "$mux":
            return data
        mux, _, lane = selecting
        if mux.ports["A"][lane] != bit:
            raise NetlistError(f"{cell.name}: a register that is selected, and not an operand gate")
        taken = mux.ports["B"][lane]
        self.gates.add((mux.ports["S"][0], self._age(taken)))
        return taken

    def _age(self, bit: Bit) -> int:
        """Return the age of a bit, that of the cell that it comes from included."""
        source, age = self.origin(bit)
        driver = self._netlist.drivers.get(source)
        if source in self._inputs.bits or source == self._inputs.valid:
            return age
        if driver is None:
            raise NetlistError(f"{self._netlist.top}: net {source} is driven by nothing that is known")
        return age + self._require_age(self.value(driver[0]))

    @staticmethod
    def _require_age(word: Word) -> int:
        if word.age is None:
            raise NetlistError("a constant where a value of the pair is expected")
        return word.age

    # --- Words --------------------------------------------------------------------------------------

    def word(self, bits: Sequence[Bit], where: str) -> Word:
        """Return what a word holds: the low bits of one value, then possibly copies of the highest."""
        origins = [self.origin(bit) for bit in bits]
        if {source for source, _ in origins} == {"0"}:
            return Word(ZERO, len(bits), None)
        kept = len(bits)
        while kept > 1 and origins[kept - 1] == origins[kept - 2]:
            kept -= 1
        ages = {age for _, age in origins}
        places = [self._place(source, where) for source, _ in origins[:kept]]
        if len(ages) != 1 or [place for _, place in places] != list(range(kept)):
            raise NetlistError(f"{where}: not one value, or bits of several clocks")
        if len({id(value) for value, _ in places}) != 1:
            raise NetlistError(f"{where}: bits of several values")
        value, age = places[0][0], ages.pop()
        if kept > value.bits:
            raise NetlistError(f"{where}: more bits than the value has")
        found = Word(value.polynomial, kept, self._require_age(value) + age)
        if kept < len(bits):
            self._check_fits(found, where)
        return Word(found.polynomial, len(bits), found.age)

    def exact(self, bits: Sequence[Bit], where: str) -> Word:
        """Return what a word holds, after the check that the polynomial fits its bits."""
        found = self.word(bits, where)
        self._check_fits(found, where)
        return found

    def _check_fits(self, word: Word, where: str) -> None:
        largest = word.polynomial.largest(self._width)
        is_coordinate = len(word.polynomial.terms) == 1 and word.polynomial.degree == 1
        if is_coordinate and word.bits >= self._width:
            return
        if largest is None:
            raise NetlistError(f"{where}: no bound is known for what it holds")
        if largest >= 1 << (word.bits - 1):
            raise NetlistError(f"{where}: {word.bits} bits are too few: values reach {largest}")

    def _place(self, source: Bit, where: str) -> tuple[Word, int]:
        """Return the value that a net is a bit of, and which."""
        if source in self._inputs.bits:
            number, place = self._inputs.bits[source]
            return self._input(number), place
        driver = self._netlist.drivers.get(source)
        if driver is None:
            raise NetlistError(f"{where}: net {source} is no value of the pair")
        return self.value(driver[0]), driver[2]

    def _input(self, number: int) -> Word:
        key = f"input {number}"
        if key not in self._values:
            bits = self._margin if number == MARGIN else self._width
            self._values[key] = Word(variable(number), bits, 0)
        return self._values[key]

    # --- Cells --------------------------------------------------------------------------------------

    def value(self, cell: Cell) -> Word:
        """Return what a cell puts out."""
        if cell.name not in self._values:
            self._values[cell.name] = self._evaluate(cell)
        return self._values[cell.name]

    def _evaluate(self, cell: Cell) -> Word:
        if cell.kind in ("$add", "$sub", "$neg"):
            return self._sum(cell)
        if cell.kind == "triaxis_mul":
            left, right = self.exact(cell.ports["a_i"], cell.name), self.exact(cell.ports["b_i"], cell.name)
            sizes = cell.parameters["AWidth"], cell.parameters["BWidth"]
            age = self.common_age(cell.name, left, right) + self.latency("mul_latency", *sizes)
            return Word(left.polynomial * right.polynomial, sum(sizes), age)
        raise NetlistError(f"{cell.name}: a cell {cell.kind} on the way of a value")

    def _sum(self, cell: Cell) -> Word:
        bits = cell.parameters["Y_WIDTH"]
        ports = [port for port in ("A", "B") if port in cell.ports]
        words = []
        for port in ports:
            extended = cell.parameters[f"{port}_WIDTH"] < bits
            if extended and not cell.parameters[f"{port}_SIGNED"]:
                raise NetlistError(f"{cell.name}: an operand extended without its sign")
            read = self.exact if extended else self.word
            words.append(read(cell.ports[port], cell.name))
        age = self.common_age(cell.name, *words)
        if cell.kind == "$neg":
            return Word(-words[0].polynomial, bits, age)
        left, right = (word.polynomial for word in words)
        return Word(left + right if cell.kind == "$add" else left - right, bits, age)

    def common_age(self, where: str, *words: Word) -> int:
        """Return the one age of all the words, constants aside."""
        ages = {word.age for word in words} - {None}
        if len(ages) != 1:
            raise NetlistError(f"{where}: values of several clocks meet, {sorted(map(str, ages))}")
        return self._require_age(next(word for word in words if word.age is not None))

    def latency(self, name: str, *arguments: int) -> int:
        """Return a documented latency; 0 without registers."""
        if not self._registered:
            return 0
        return self._package.call(name, *arguments) if arguments else self._package.constant(name)

    # --- Conditions -----------------------------------------------------------------------------------

    def condition(self, bit: Bit) -> tuple[list[Bit], Callable[[Mapping[Bit, bool]], bool]]:
        """Return the nets that a Boolean net depends on, before its gates, and the function of them."""
        driver = self._netlist.drivers.get(bit)
        if driver is None or driver[0].kind not in _BOOLEAN:
            return [bit], lambda values: values[bit]
        cell, function = driver[0], _BOOLEAN[driver[0].kind]
        ports = [
            [self.condition(one) for one in cell.ports[port]] for port in ("A", "B") if port in cell.ports
        ]
        leaves = [leaf for port in ports for found, _ in port for leaf in found]

        def evaluate(values: Mapping[Bit, bool]) -> bool:
            return function([[one(values) for _, one in port] for port in ports])

        return leaves, evaluate


_BOOLEAN: dict[str, Callable[[list[list[bool]]], bool]] = {
    "$logic_and": lambda ports: any(ports[0]) and any(ports[1]),
    "$logic_or": lambda ports: any(ports[0]) or any(ports[1]),
    "$logic_not": lambda ports: not any(ports[0]),
    "$reduce_bool": lambda ports: any(ports[0]),
    "$reduce_or": lambda ports: any(ports[0]),
}


@dataclass(frozen=True)
class Core:
    """What is to be proved of: parameters, and where the verdict is."""

    width: int
    margin: int
    edge_box: bool
    gating: bool


class AxisProof:
    """Compares the closed modules' inputs with the definition. Raises NetlistError where they differ."""

    def __init__(self, netlist: Netlist, inputs: Inputs, core: Core, dut: Path) -> None:
        """Take an elaborated core."""
        self._netlist, self._inputs, self._core = netlist, inputs, core
        self._path = DataPath(netlist, inputs, Package(dut), core.width, core.margin)

    def origin(self, bit: Bit) -> tuple[Bit, int]:
        """Return the net that a bit comes from through registers, and the clocks since."""
        return self._path.origin(bit)

    def verdict_age(self) -> int:
        """Prove everything up to the verdict; return its age."""
        self._parameters()
        cell = self._only("triaxis_verdict")
        bits = cell.ports["separated_i"]
        last = len(axes()) if self._core.edge_box else FIRST_PLANE_AXIS
        ages = {self._axis(number, bits[number]) for number in range(last)}
        if set(bits[last:]) - {"0"}:
            raise NetlistError("the edge x box axes are left out, and yet arrive")
        ages.add(self._flags(cell))
        ages |= self._mask(cell)
        self._gates()
        if len(ages) != 1:
            raise NetlistError(f"{cell.name}: axes and flags of several clocks meet, {sorted(ages)}")
        return ages.pop() + self._path.latency("VerdictLatency")

    def _parameters(self) -> None:
        """Prove that the closed modules are built for the core's width and margin, registered all or none."""
        wanted = {"W": self._core.width, "M": self._core.margin}
        closed = [cell for cell in self._netlist.cells if cell.kind in CLOSED]
        for cell in closed:
            for name, value in wanted.items():
                if cell.parameters.get(name, value) != value:
                    raise NetlistError(f"{cell.name}: its {name} is not the core's, {value}")
        if len({cell.parameters["Comb"] for cell in closed if "Comb" in cell.parameters}) != 1:
            raise NetlistError(f"{self._netlist.top}: modules with registers and without")

    def _only(self, kind: str) -> Cell:
        found = [cell for cell in self._netlist.cells if cell.kind == kind]
        if len(found) != 1:
            raise NetlistError(f"{self._netlist.top}: {len(found)} modules {kind} instead of one")
        return found[0]

    # --- Axes ---------------------------------------------------------------------------------------

    def _axis(self, number: int, bit: Bit) -> int:
        """Prove that a bit tests the axis of that number; return its age."""
        source, age = self._path.origin(bit)
        driver = self._netlist.drivers.get(source)
        kind = "triaxis_box" if number < _BOXES else "triaxis_interval"
        if driver is None or driver[0].kind != kind:
            raise NetlistError(f"axis {number}: its bit comes from no {kind}")
        test = self._box if number < _BOXES else self._interval
        return age + test(driver[0], axes()[number])

    def _box(self, cell: Cell, axis: Axis) -> int:
        points = [self._elements(cell, port, 3) for port in ("a_i", "b_i")]
        for found, wanted in zip(points, (axis.on_a, axis.on_b), strict=True):
            if {word.polynomial for word in found} != set(wanted):
                raise NetlistError(f"{cell.name}: not the coordinates of its axis")
        margin = self._margin(cell.ports["margin_i"], cell.name)
        age = self._path.common_age(cell.name, *points[0], *points[1], margin)
        return age + self._path.latency("BoxLatency")

    def _interval(self, cell: Cell, axis: Axis) -> int:
        own = self._path.exact(cell.ports["own_i"], cell.name)
        points = self._elements(cell, "points_i", cell.parameters["Points"])
        if not _is_test_of(axis, own.polynomial, [word.polynomial for word in points]):
            raise NetlistError(f"{cell.name}: what it compares are not the projections on its axis")
        age = self._path.common_age(cell.name, own, *points)
        self._threshold(cell, axis, own, points, age)
        return age + self._path.latency("interval_latency", self._core.margin)

    def _elements(self, cell: Cell, port: str, count: int) -> list[Word]:
        """Return the elements of an array, in an order that does not matter."""
        bits = cell.ports[port]
        size = len(bits) // count
        return [
            self._path.exact(bits[place * size : (place + 1) * size], f"{cell.name}.{port}")
            for place in range(count)
        ]

    def _margin(self, bits: Sequence[Bit], where: str) -> Word:
        found = self._path.word(bits, where)
        wanted = variable(MARGIN) if self._core.margin else ZERO
        if found.polynomial != wanted or found.bits != max(1, self._core.margin):
            raise NetlistError(f"{where}: not the margin")
        return found

    def _threshold(self, cell: Cell, axis: Axis, own: Word, points: Sequence[Word], age: int) -> None:
        """Prove that a threshold is margin * |axis|1, due when it is needed, and that nothing overflows."""
        bits = cell.ports["threshold_i"]
        if not self._core.margin:
            if set(bits) - {"0", "x"}:
                raise NetlistError(f"{cell.name}: a threshold without margins")
            return
        origins = [self._path.origin(bit) for bit in bits]
        drivers = [self._netlist.drivers.get(source) for source, _ in origins]
        source = drivers[0][0] if drivers[0] else None
        whole = len(source.ports.get("threshold_o", ())) if source else 0
        expected = [(source, "threshold_o", place) for place in range(whole)]
        late = {clocks for _, clocks in origins}
        if source is None or source.kind != "triaxis_threshold" or drivers != expected or len(late) != 1:
            raise NetlistError(f"{cell.name}: its threshold is not one of triaxis_threshold")
        components = self._elements(source, "axis_i", source.parameters["Components"])
        margin = self._margin(source.ports["margin_i"], source.name)
        if not _same_up_to_signs([word.polynomial for word in components], axis.vector):
            raise NetlistError(f"{source.name}: not the components of the axis of {cell.name}")
        size = source.parameters["CWidth"]
        start = self._path.common_age(source.name, *components, margin)
        due = start + self._path.latency("threshold_latency", len(components), size, self._core.margin)
        # One register before the threshold is added: with registers, it is due a clock after the points.
        if due + late.pop() != age + self._path.latency("DiffLatency"):
            raise NetlistError(f"{cell.name}: its threshold comes at another clock than its points")
        self._room(cell, source, own, points, axis)

    def _room(self, cell: Cell, source: Cell, own: Word, points: Sequence[Word], axis: Axis) -> None:
        """Prove that the sum of absolutes and the moved bounds fit, by their largest values at corners."""
        side = (1 << self._core.width) - 1
        margin = (1 << self._core.margin) - 1
        norm, reach, degree = _extremes(axis, own.polynomial, tuple(word.polynomial for word in points))
        if norm * side ** (degree - 1) >= 1 << source.parameters["CWidth"]:
            raise NetlistError(f"{source.name}: the sum of absolutes does not fit")
        if reach * side ** (degree - 1) * max(side, margin) >= 1 << (cell.parameters["Width"] - 1):
            raise NetlistError(f"{cell.name}: a bound moved by its threshold does not fit")

    # --- Flags and gates ------------------------------------------------------------------------------

    def _flags(self, verdict: Cell) -> int:
        cell = self._only("triaxis_flags")
        for name in ("degenerate_a", "degenerate_b", "coplanar"):
            if verdict.ports[f"{name}_i"] != cell.ports[f"{name}_o"]:
                raise NetlistError(f"{verdict.name}: {name} is not that of {cell.name}")
        found = [self._elements(cell, f"normal_{name}_i", 3) for name in ("a", "b")]
        for words, normal in zip(found, normals(), strict=True):
            if not _same_up_to_signs([word.polynomial for word in words], normal):
                raise NetlistError(f"{cell.name}: not the normal")
        ten = [word for name in ("pqr_i", "pf_i", "qf_i") for word in self._elements(cell, name, 3)]
        ten += self._elements(cell, "rst_i", 1)
        _check_plane([word.polynomial for word in ten], cell.name)
        waits = [cell.parameters[name] for name in ("NormalWait", "DetWait")]
        ages = {
            self._path.common_age(cell.name, *found[0], *found[1]) + waits[0],
            self._path.common_age(cell.name, *ten) + waits[1],
        }
        if len(ages) != 1:
            raise NetlistError(f"{cell.name}: flags of several clocks")
        return ages.pop()

    def _box_bits(self, leaves: Iterable[Bit]) -> dict[Bit, tuple[str, int]]:
        """Return what each net of a condition is, and its age: a box axis by name, or "valid"."""
        known: dict[Bit, tuple[str, int]] = {}
        boxes = self._only("triaxis_verdict").ports["separated_i"][:_BOXES]
        names = {self._path.origin(bit)[0]: f"box {number}" for number, bit in enumerate(boxes)}
        names[self._inputs.valid] = "valid"
        for leaf in leaves:
            source, age = self._path.origin(leaf)
            if source not in names:
                raise NetlistError(f"{self._netlist.top}: net {leaf} decides on operands or flags")
            driver = self._netlist.drivers.get(source)
            if driver is not None and driver[0].kind == "triaxis_box":
                number = int(names[source].split()[1])
                age += self._box(driver[0], axes()[number])
            known[leaf] = names[source], age
        return known

    def _mask(self, verdict: Cell) -> set[int]:
        """Prove that flags are masked where the boxes decide; return the ages of what says so."""
        bit = verdict.ports["gated_i"][0]
        if not self._core.gating or self._path.latency("VerdictLatency") == 0:
            if bit != "0":
                raise NetlistError(f"{verdict.name}: flags are masked without operand gating")
            return set()
        return self._condition(bit, {"box 0", "box 1", "box 2"}, lambda on: any(on.values()))

    def _gates(self) -> None:
        """Prove that operands are taken where they are wanted, and at the pair's own clock."""
        names = {"valid"} | ({"box 0", "box 1", "box 2"} if self._core.gating else set())

        def wanted(on: Mapping[str, bool]) -> bool:
            return on["valid"] and not any(value for name, value in on.items() if name != "valid")

        for bit, age in sorted(self._path.gates, key=str):
            if self._condition(bit, names, wanted) != {age}:
                raise NetlistError(f"{self._netlist.top}: operands are gated at another clock than their own")
        if self._path.latency("GateLatency") and not self._path.gates:
            raise NetlistError(f"{self._netlist.top}: no operand gate")

    def _condition(self, bit: Bit, names: set[str], wanted: Callable[[Mapping[str, bool]], bool]) -> set[int]:
        """Prove that a condition is the wanted function of those names; return its ages."""
        leaves, function = self._path.condition(bit)
        known = self._box_bits(leaves)
        if {name for name, _ in known.values()} != names:
            raise NetlistError(f"{self._netlist.top}: a gate depends on {sorted(known.values())}")
        for values in product((False, True), repeat=len(names)):
            on = dict(zip(sorted(names), values, strict=True))
            if function({leaf: on[name] for leaf, (name, _) in known.items()}) != wanted(on):
                raise NetlistError(f"{self._netlist.top}: a gate opens wrongly at {on}")
        return {age for _, age in known.values()}


def _is_test_of(axis: Axis, own: Polynomial, points: Sequence[Polynomial]) -> bool:
    """Return whether {0, own} and the points are the projections of one triangle and of the other.

    The axis may serve with either sign, and any vertex of the first triangle may be the origin.
    """
    for first, second in ((axis.on_a, axis.on_b), (axis.on_b, axis.on_a)):
        for start in first:
            for flip in (False, True):
                interval = {_flipped(value - start, flip) for value in first}
                others = {_flipped(value - start, flip) for value in second}
                if interval == {ZERO, own} and others == set(points):
                    return True
    return False


def _flipped(polynomial: Polynomial, flip: bool) -> Polynomial:
    return -polynomial if flip else polynomial


def _unsigned(polynomial: Polynomial) -> frozenset[Polynomial]:
    return frozenset({polynomial, -polynomial})


def _same_up_to_signs(found: Sequence[Polynomial], wanted: Sequence[Polynomial]) -> bool:
    """Return whether the nonzero polynomials of both are the same, each up to its sign."""

    def nonzero(polynomials: Sequence[Polynomial]) -> list[frozenset[Polynomial]]:
        return sorted((_unsigned(one) for one in polynomials if one != ZERO), key=hash)

    return nonzero(found) == nonzero(wanted)


def _check_plane(ten: Sequence[Polynomial], where: str) -> None:
    """Prove that all six vertices lie in a plane where these ten orientations are zero."""
    known = {one for polynomial in ten for one in _unsigned(polynomial)}
    for numbers, orientation in orientations().items():
        if numbers[0] == 0:
            if orientation not in known:
                raise NetlistError(f"{where}: the orientation of vertices {numbers} is missing")
        else:
            total = ZERO
            for place in range(4):
                face = (0, *(number for at, number in enumerate(numbers) if at != place))
                total += _flipped(orientations()[face], bool(place % 2))
            if total != orientation:
                raise NetlistError(f"the orientation of vertices {numbers} does not follow from the others")


_EXTREMES: dict[tuple[Axis, Polynomial, tuple[Polynomial, ...]], tuple[int, int, int]] = {}


def _extremes(axis: Axis, own: Polynomial, points: tuple[Polynomial, ...]) -> tuple[int, int, int]:
    """Return the largest |axis|1 and the largest reach of an interval test, in powers of L, and the degree.

    The reach is that of 0 and own moved by a margin of L, and of the points. Absolutes of what is affine in
    each variable are convex in it, so their sums are largest at corners too.
    """
    key = (axis, own, points)
    if key not in _EXTREMES:
        every = (*axis.vector, own, *points)
        variables = sorted({number for polynomial in every for number in polynomial.variables})
        values = abs(at_corners(every, variables))
        norms = values[:3].sum(0)
        reach = max(int((values[3] + norms).max()), int(values[4:].max()))
        degree = next(polynomial.degree for polynomial in points if polynomial != ZERO)
        _EXTREMES[key] = int(norms.max()), reach, degree or 0
    return _EXTREMES[key]
