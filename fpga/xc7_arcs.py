"""Which pins of a 7-series cell depend on which without a clock between: what a longest path runs along.

LUTs, wide multiplexers and inverters are combinational as a whole. Carry chains are taken bit by bit, as a
bit does not depend on higher ones. A DSP48E1 depends on which of its registers are in use; where some are,
a path ends or begins inside it. Source: 7 Series FPGAs CLB (UG474) and DSP48E1 Slice (UG479) user guides.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

# A net, or a register inside a cell.
Point = int | str

_COMBINATIONAL = re.compile(r"LUT[1-6](_2)?|MUXF[78]|INV|BUF|IBUF|OBUF|BUFG")
_FLIP_FLOP = re.compile(r"FD[RSCP]E(_1)?")
# Memories of LUTs: read without a clock, written with it.
_LUT_MEMORY = re.compile(r"RAM\d+(X1[DS]|M)(_1)?")
_READ_ADDRESS = re.compile(r"A\d*|DPRA\d*|ADDR[A-D]")


@dataclass(frozen=True)
class Cell:
    """A cell of a flat netlist: nets by pin, lowest bit first. Constants are left out of ``pins``."""

    name: str
    kind: str
    pins: Mapping[str, Sequence[tuple[int, int]]]  # pin: (place, net)
    outputs: frozenset[str]
    parameters: Mapping[str, int]

    def nets(self, pin: str) -> list[int]:
        """Return the nets at a pin."""
        return [net for _, net in self.pins.get(pin, ())]

    def inputs(self) -> list[str]:
        """Return the pins that are no outputs."""
        return [pin for pin in self.pins if pin not in self.outputs]


@dataclass(frozen=True)
class Arc:
    """``target`` depends on ``source`` through a cell. ``carry``: by the carry chain's own wire."""

    source: Point
    target: Point
    carry: bool = False


@dataclass
class Ways:
    """How paths go through one cell, begin and end there."""

    arcs: list[Arc]
    starts: list[Point]
    ends: list[Point]


def ways(cell: Cell) -> Ways:
    """Return how paths go through a cell."""
    if _COMBINATIONAL.fullmatch(cell.kind):
        return Ways(list(_all_to_all(cell)), [], [])
    if cell.kind == "CARRY4":
        return Ways(list(_carry(cell)), [], [])
    if cell.kind == "DSP48E1":
        return _dsp(cell)
    found = _clocked(cell)
    if _LUT_MEMORY.fullmatch(cell.kind):
        outputs = [net for pin in cell.outputs for net in cell.nets(pin)]
        addresses = [pin for pin in cell.inputs() if _READ_ADDRESS.fullmatch(pin)]
        found.arcs = [Arc(net, out) for pin in addresses for net in cell.nets(pin) for out in outputs]
    return found


def is_register(cell: Cell) -> bool:
    """Return whether a cell is a flip-flop."""
    return _FLIP_FLOP.fullmatch(cell.kind) is not None


def _clocked(cell: Cell) -> Ways:
    """Return the ways of a cell that stores what comes in: flip-flops, shift registers, memories."""
    outputs = [net for pin in cell.outputs for net in cell.nets(pin)]
    inputs = [
        net
        for pin in cell.inputs()
        if not pin.startswith(("C", "WCLK")) or pin == "CE"
        for net in cell.nets(pin)
    ]
    return Ways([], list(outputs), list(inputs))


def _all_to_all(cell: Cell) -> Iterator[Arc]:
    outputs = [net for pin in cell.outputs for net in cell.nets(pin)]
    for pin in cell.inputs():
        for net in cell.nets(pin):
            yield from (Arc(net, out) for out in outputs)


def _carry(cell: Cell) -> Iterator[Arc]:
    for pin in ("CI", "CYINIT", "S", "DI"):
        for place, net in cell.pins.get(pin, ()):
            for output in ("O", "CO"):
                # DI[i] joins the chain behind O[i].
                first = place + 1 if (pin, output) == ("DI", "O") else place
                for to, out in cell.pins.get(output, ()):
                    if to >= first:
                        yield Arc(net, out, carry=pin == "CI")


def _dsp(cell: Cell) -> Ways:
    """Return the ways of a DSP48E1: A, B -> multiplier (M) -> adder (P), with C and PCIN to the adder."""
    used = {name: cell.parameters.get(name, 1) > 0 for name in ("AREG", "BREG", "CREG", "MREG", "PREG")}
    adder, result = f"{cell.name}.M", f"{cell.name}.P"
    outputs: list[Point] = [net for pin in ("P", "PCOUT") for net in cell.nets(pin)]
    found = Ways([], [], [])
    beyond: list[Point] = outputs
    if used["PREG"]:
        found.starts += outputs
        found.ends.append(result)
        beyond = [result]
    if used["MREG"]:
        found.ends.append(adder)
    if used["MREG"] or used["AREG"] or used["BREG"] or used["CREG"]:
        inside = f"{cell.name}.inside"
        found.starts.append(inside)
        found.arcs += [Arc(inside, target) for target in beyond]
        if used["AREG"] and used["MREG"]:
            found.arcs.append(Arc(inside, adder))
    for pin in cell.inputs():
        nets = cell.nets(pin)
        if pin in ("A", "B") and not used[f"{pin}REG"]:
            targets = [adder] if used["MREG"] else beyond
        elif (pin == "C" and not used["CREG"]) or pin == "PCIN":
            targets = beyond
        else:
            found.ends += [] if pin == "CLK" else nets
            continue
        found.arcs += [Arc(net, target) for net in nets for target in targets]
    return found
