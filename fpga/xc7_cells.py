"""How paths go through each kind of cell of the 7 series, and how long they take there.

LUTs, wide multiplexers and inverters are combinational as a whole. Carry chains are taken bit by bit, as a
bit does not depend on higher ones. A DSP48E1 depends on which of its registers are in use; where some are,
a path ends or begins inside it. Source: 7 Series FPGAs CLB (UG474) and DSP48E1 Slice (UG479) user guides.

Times are those of the slow corner in public timing data, in ns: Project X-Ray's database, prjxray-db,
artix7/timings, whose look-up table, 0.124 ns, is that of the slowest speed grade. Of kinds of slices the
slower counts. They are of the cell itself: what lies between it and the wires of the fabric counts as wire.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import product

from triaxis.golden.errors import InputError

# A net, or a register inside a cell.
Point = int | str

_LUT = re.compile(r"LUT[1-6](_2)?|INV")
_WIDE = re.compile(r"MUXF[78]")
_COMBINATIONAL = re.compile(rf"{_LUT.pattern}|{_WIDE.pattern}|BUF|IBUF|OBUF|BUFG")
FLIP_FLOP = re.compile(r"FD[RSCP]E(_1)?")
# Memories of LUTs, shift registers among them: read without a clock, written with it.
_LUT_MEMORY = re.compile(r"RAM\d+(X1[DS]|M)(_1)?|SRL(16E|C32E)")
_READ_ADDRESS = re.compile(r"A\d*|DPRA\d*|ADDR[A-D]")
_BLOCK_MEMORY = re.compile(r"RAMB(18|36)E1")
_CLOCK = re.compile(r"C|W?CLK\w*")

_LUT_NS, _WIDE_NS = 0.124, 0.296
# What a path of a register, or of a port, begins with; its data pin asks for nothing before the clock.
REGISTER_NS = 0.362
_REGISTER_CONTROL_NS = 0.404
_LUT_MEMORY_NS, _LUT_MEMORY_SETUP_NS = 1.472, 0.654
# Yosys uses no registers behind a block.
_BLOCK_NS, _BLOCK_SETUP_NS = 2.454, 0.737

# CARRY4: from the bit of an input pin to the four bits of CO and of O.
_CARRY_NS: Mapping[tuple[str, int], Mapping[str, Sequence[float]]] = {
    ("CI", 0): {"CO": (0.271, 0.157, 0.228, 0.114), "O": (0.222, 0.334, 0.239, 0.313)},
    ("CYINIT", 0): {"CO": (0.536, 0.494, 0.592, 0.580), "O": (0.482, 0.598, 0.584, 0.642)},
    ("S", 0): {"CO": (0.340, 0.433, 0.512, 0.508), "O": (0.223, 0.400, 0.523, 0.582)},
    ("S", 1): {"CO": (0, 0.469, 0.548, 0.528), "O": (0, 0.205, 0.558, 0.618)},
    ("S", 2): {"CO": (0, 0, 0.292, 0.376), "O": (0, 0, 0.226, 0.330)},
    ("S", 3): {"CO": (0, 0, 0, 0.380), "O": (0, 0, 0, 0.227)},
    ("DI", 0): {"CO": (0.379, 0.465, 0.540, 0.526), "O": (0, 0.407, 0.556, 0.615)},
    ("DI", 1): {"CO": (0, 0.445, 0.520, 0.507), "O": (0, 0, 0.537, 0.596)},
    ("DI", 2): {"CO": (0, 0, 0.356, 0.398), "O": (0, 0, 0, 0.438)},
    ("DI", 3): {"CO": (0, 0, 0, 0.385), "O": (0, 0, 0, 0)},
}

# DSP48E1. From one register to the next inside it no time is public: what is known of a longer way counts.
_P_REGISTER_NS, _M_TO_P_NS, _A_TO_P_NS, _C_TO_P_NS = 0.434, 2.305, 4.009, 1.820
_A_TO_M_NS = {"A": 1.928, "B": 1.743}
_DSP_SETUP_NS = {"A": 0.362, "B": 0.450, "C": 0.233}
_DSP_CONTROL_NS = 0.543


@dataclass(frozen=True)
class Cell:
    """A cell of a flat netlist: nets by pin, lowest bit first. Constants are left out of ``pins``."""

    name: str
    kind: str
    pins: Mapping[str, Sequence[tuple[int, int]]]  # pin: (place, net)
    outputs: frozenset[str]
    parameters: Mapping[str, int]

    def nets(self, *pins: str) -> list[int]:
        """Return the nets at pins."""
        return [net for pin in pins for _, net in self.pins.get(pin, ())]

    def inputs(self) -> list[str]:
        """Return the pins that are no outputs."""
        return [pin for pin in self.pins if pin not in self.outputs]

    @property
    def in_slice(self) -> bool:
        """Return whether what it gives can reach the next cell inside a slice, without a wire."""
        return self.kind == "CARRY4" or bool(_LUT.fullmatch(self.kind) or _WIDE.fullmatch(self.kind))

    def near(self, pin: str) -> bool:
        """Return whether a slice has a way of its own to that pin."""
        if _WIDE.fullmatch(self.kind):
            return pin != "S"
        return pin == ("S" if self.kind == "CARRY4" else "D" if FLIP_FLOP.fullmatch(self.kind) else "")


@dataclass(frozen=True)
class Arc:
    """``target`` depends on ``source`` through a cell, which takes so long.

    ``pin``: where it comes in; empty where it does so by no wire of the fabric. ``carry``: by the carry
    chain's own wire.
    """

    source: Point
    target: Point
    ns: float
    pin: str = ""
    carry: bool = False


@dataclass(frozen=True)
class End:
    """What takes a net in, that long before the clock. ``pin`` is as in an arc."""

    point: Point
    ns: float
    pin: str = ""


@dataclass
class Ways:
    """How paths go through one cell, begin there, that long after the clock, and end."""

    arcs: list[Arc] = field(default_factory=list)
    starts: dict[Point, float] = field(default_factory=dict)
    ends: list[End] = field(default_factory=list)

    def join(self, sources: Iterable[Point], targets: Iterable[Point], ns: float, pin: str = "") -> None:
        """Let all targets depend on all sources."""
        self.arcs += [Arc(source, target, ns, pin) for source, target in product(sources, targets)]

    def store(self, cell: Cell, ns: float, *pins: str) -> None:
        """Let what comes in at pins be stored."""
        self.ends += [End(net, ns, pin) for pin in pins for net in cell.nets(pin)]


def ways(cell: Cell) -> Ways:
    """Return how paths go through a cell; raise InputError where that is not known."""
    found, outputs = Ways(), cell.nets(*cell.outputs)
    # What stores what comes in has a clock: all pins but that.
    stored = [pin for pin in cell.inputs() if not _CLOCK.fullmatch(pin)]
    if _COMBINATIONAL.fullmatch(cell.kind):
        ns = _WIDE_NS if _WIDE.fullmatch(cell.kind) else _LUT_NS
        for pin in cell.inputs():
            found.join(cell.nets(pin), outputs, ns, pin)
    elif cell.kind == "CARRY4":
        found.arcs += _carry(cell)
    elif cell.kind == "DSP48E1":
        _add_dsp(found, cell)
    elif FLIP_FLOP.fullmatch(cell.kind):
        found.starts = dict.fromkeys(outputs, REGISTER_NS)
        found.store(cell, 0.0, "D")
        found.store(cell, _REGISTER_CONTROL_NS, *(pin for pin in stored if pin != "D"))
    elif _BLOCK_MEMORY.fullmatch(cell.kind):
        found.starts = dict.fromkeys(outputs, _BLOCK_NS)
        found.store(cell, _BLOCK_SETUP_NS, *stored)
    elif _LUT_MEMORY.fullmatch(cell.kind):
        found.starts = dict.fromkeys(outputs, _LUT_MEMORY_NS)
        found.store(cell, _LUT_MEMORY_SETUP_NS, *stored)
        for pin in filter(_READ_ADDRESS.fullmatch, cell.inputs()):
            found.join(cell.nets(pin), outputs, _LUT_NS, pin)
    else:
        raise InputError(f"{cell.name}: {cell.kind}: it is not known how paths go through such a cell")
    return found


def _carry(cell: Cell) -> Iterator[Arc]:
    for pin, output in product(("CI", "CYINIT", "S", "DI"), ("O", "CO")):
        for (place, net), (to, out) in product(cell.pins.get(pin, ()), cell.pins.get(output, ())):
            # DI[i] joins the chain behind O[i].
            if to >= (place + 1 if (pin, output) == ("DI", "O") else place):
                own = pin == "CI"
                yield Arc(net, out, _CARRY_NS[pin, place][output][to], "" if own else pin, own)


def _add_dsp(found: Ways, cell: Cell) -> None:
    """Add the ways of a DSP48E1: A, B -> multiplier (M) -> adder (P), with C and PCIN to the adder."""
    used = {name: cell.parameters.get(name, 1) > 0 for name in ("AREG", "BREG", "CREG", "MREG", "PREG")}
    adder, result, inside = (f"{cell.name}.{place}" for place in ("M", "P", "inside"))
    beyond: list[Point] = list(cell.nets("P", "PCOUT"))
    if used["PREG"]:
        found.starts |= dict.fromkeys(beyond, _P_REGISTER_NS)
        found.ends.append(End(result, 0.0))
        beyond = [result]
    if used["MREG"]:
        found.ends.append(End(adder, 0.0))
    if used["MREG"] or used["AREG"] or used["BREG"] or used["CREG"]:
        found.starts[inside] = 0.0
        # To M it is less than from there.
        found.join([inside], beyond, _M_TO_P_NS if used["MREG"] else _A_TO_P_NS)
    for pin in cell.inputs():
        if pin in ("A", "B") and not used[f"{pin}REG"]:
            if used["MREG"]:
                found.join(cell.nets(pin), [adder], _A_TO_M_NS[pin], pin)
            else:
                found.join(cell.nets(pin), beyond, _A_TO_P_NS, pin)
        elif pin == "C" and not used["CREG"]:
            found.join(cell.nets(pin), beyond, _C_TO_P_NS, pin)
        elif pin == "PCIN":
            found.join(cell.nets(pin), beyond, _C_TO_P_NS)
        elif pin != "CLK":
            found.store(cell, _DSP_SETUP_NS.get(pin, _DSP_CONTROL_NS), pin)
