"""The data path of an elaborated netlist, read as polynomials and ages.

Every word is given two things, from the inputs on: the polynomial that it holds in the 18 coordinates and
the margin, and its age, the clocks since those came in. Adders, subtractors and multipliers act on
polynomials; registers add a clock. All that meets in a cell must have one age, so that no pair is mixed
with another. Where a word is sign-extended, multiplied or compared, its polynomial must fit its bits, at
every corner of the coordinates and so for all of them; elsewhere two's complement is exact modulo its
width.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from triaxis.verif.formal.definition import MARGIN, ONE, Polynomial, variable
from triaxis.verif.formal.netlist import REGISTERS, Bit, Cell, Netlist, NetlistError
from triaxis.verif.testbench.rtl_package import Package


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


class DataPath:
    """The data path of a netlist, read as polynomials and ages. Raises NetlistError where it is not so."""

    def __init__(self, netlist: Netlist, inputs: Inputs, package: Package, width: int, margin: int) -> None:
        """Take a netlist in which the modules with proofs of their own are closed."""
        self._netlist, self._inputs, self._package = netlist, inputs, package
        self._width, self._margin = width, margin
        self._registered = not any(cell.parameters.get("Comb") for cell in netlist.cells)
        # Where bits come from before registers: a net, and the clocks since.
        self._origins: dict[Bit, tuple[Bit, int]] = {}
        self._values: dict[str, Word] = {}
        self.gates: set[tuple[Bit, int]] = set()

    def registers(self) -> set[str]:
        """Return the names of the registers passed so far, of the netlist's cells."""
        drivers = (self._netlist.drivers.get(bit) for bit in self._origins)
        return {driver[0].name for driver in drivers if driver and driver[0].kind in REGISTERS}

    # --- Bits ---------------------------------------------------------------------------------------

    def origin(self, bit: Bit) -> tuple[Bit, int]:
        """Return the net that a bit comes from through registers and operand gates, and the clocks since."""
        path: list[Bit] = []
        while bit not in self._origins:
            step = self._register(bit)
            if step is None:
                self._origins[bit] = bit, 0
            else:
                path.append(bit)
                bit = step
        found = self._origins[bit]
        for passed in reversed(path):
            found = self._origins[passed] = found[0], found[1] + 1
        return found

    def _register(self, bit: Bit) -> Bit | None:
        """Return the bit that a register took at the last clock, None where the bit is no register."""
        driver = self._netlist.drivers.get(bit)
        if driver is None or driver[0].kind not in REGISTERS:
            return None
        cell, _, place = driver
        data = cell.ports["D"][place]
        selecting = self._netlist.drivers.get(data)
        if selecting is None or selecting[0].kind != "$mux":
            return data
        return self._gated(cell, bit, data)

    def _gated(self, cell: Cell, bit: Bit, selected: Bit) -> Bit:
        """Return the bit that a register took which keeps its own as long as its gate is closed."""
        mux, _, lane = self._netlist.drivers[selected]
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
        if {source for source, _ in origins} <= {"0", "1"}:
            return Word(_constant([source for source, _ in origins]), len(bits), None)
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

    def elements(self, cell: Cell, port: str, count: int) -> list[Word]:
        """Return the elements of an array, in an order that does not matter."""
        bits = cell.ports[port]
        size = len(bits) // count
        return [
            self.exact(bits[place * size : (place + 1) * size], f"{cell.name}.{port}")
            for place in range(count)
        ]

    def output(self, bits: Sequence[Bit], kind: str, port: str) -> tuple[Cell, int] | None:
        """Return the cell of that kind whose output the bits are, from its lowest on, and the clocks since.

        None where they are none, or of several clocks.
        """
        origins = [self.origin(bit) for bit in bits]
        drivers = [self._netlist.drivers.get(source) for source, _ in origins]
        cell = drivers[0][0] if drivers[0] else None
        if cell is None or cell.kind != kind:
            return None
        clocks = {age for _, age in origins}
        whole = [(cell, port, place) for place in range(len(cell.ports.get(port, ())))]
        return (cell, clocks.pop()) if drivers == whole and len(clocks) == 1 else None

    def _check_fits(self, word: Word, where: str) -> None:
        extent = word.polynomial.extent(self._width)
        if extent is None:
            raise NetlistError(f"{where}: no bound is known for what it holds")
        lowest, highest = extent
        if max(highest, -1 - lowest) >= 1 << (word.bits - 1):
            raise NetlistError(f"{where}: {word.bits} bits are too few: values reach {max(highest, -lowest)}")

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
        return self._package.call(name, *arguments) if self._registered else 0

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


def _constant(bits: Sequence[Bit]) -> Polynomial:
    """Return the number, with a sign, that constant bits are."""
    value = sum(1 << place for place, bit in enumerate(bits) if bit == "1")
    return ONE.scaled(value - (1 << len(bits)) if bits[-1] == "1" else value)


_BOOLEAN: dict[str, Callable[[list[list[bool]]], bool]] = {
    "$logic_and": lambda ports: any(ports[0]) and any(ports[1]),
    "$logic_or": lambda ports: any(ports[0]) or any(ports[1]),
    "$logic_not": lambda ports: not any(ports[0]),
    "$reduce_bool": lambda ports: any(ports[0]),
    "$reduce_or": lambda ports: any(ports[0]),
}
