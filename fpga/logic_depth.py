"""The longest chains of logic between registers of a netlist mapped to the 7 series.

An estimate of timing that needs no vendor tool: routing is not known before place and route, but what lies
between two registers is. Ports count as registers, which is what the core asks of its surroundings.

LUTs, wide multiplexers and inverters are combinational as a whole. Carry chains are taken bit by bit, as a
bit does not depend on higher ones. A DSP48E1 depends on which of its registers are in use; where some are,
a path ends or begins inside it. Source: 7 Series FPGAs CLB (UG474) and DSP48E1 Slice (UG479) user guides.
"""

import json
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError

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


@dataclass(frozen=True)
class LogicPath:
    """A chain of cells from a register (or port) to the next."""

    start: str
    end: str
    cells: tuple[str, ...]  # kinds, in order
    levels: int  # a chain of CARRY4, joined by its own carry wire, counts once

    def summary(self) -> str:
        """Return the cells by kind, such as "CARRY4 x 13, LUT6 x 2"."""
        return ", ".join(f"{kind} x {count}" for kind, count in sorted(Counter(self.cells).items()))


@dataclass(frozen=True)
class LogicDepth:
    """The path of most levels, where a carry chain counts once, and the path of most cells."""

    most_levels: LogicPath
    most_cells: LogicPath


@dataclass(frozen=True)
class _Step:
    source: Point
    kind: str
    carry: bool


@dataclass(frozen=True)
class _Graph:
    steps: Mapping[Point, list[_Step]]  # by target
    starts: frozenset[Point]
    ends: Mapping[Point, str]  # and the name of what stores
    names: Mapping[Point, str]


def logic_depth(netlist: Path) -> LogicDepth:
    """Return the longest paths of a flat netlist: yosys's ``write_json`` after ``synth_xilinx -flatten``.

    Raises InputError where the file is none, or where logic runs in a circle.
    """
    try:
        modules = json.loads(netlist.read_text(encoding="utf-8"))["modules"]
        (module,) = [m for m in modules.values() if m.get("attributes", {}).get("top")]
        graph = _graph(module)
    except (OSError, ValueError, KeyError, AttributeError) as error:
        raise InputError(f"{netlist}: no netlist of one top module by yosys: {error!r}") from error
    order = _in_order(graph, netlist)
    return LogicDepth(
        most_levels=_longest(graph, order, chains_once=True),
        most_cells=_longest(graph, order, chains_once=False),
    )


def _cells(module: Mapping[str, Any]) -> Iterable[Cell]:
    for name, cell in module["cells"].items():
        directions = cell["port_directions"]
        yield Cell(
            name=name,
            kind=cell["type"],
            # Constants are strings.
            pins={
                pin: [(place, net) for place, net in enumerate(nets) if isinstance(net, int)]
                for pin, nets in cell["connections"].items()
            },
            outputs=frozenset(pin for pin, direction in directions.items() if direction == "output"),
            parameters={
                key: int(value, 2)
                for key, value in cell["parameters"].items()
                if isinstance(value, str) and value and not value.strip("01")
            },
        )


def _graph(module: Mapping[str, Any]) -> _Graph:
    names = _net_names(module["netnames"])
    steps: defaultdict[Point, list[_Step]] = defaultdict(list)
    starts: set[Point] = set()
    ends: dict[Point, str] = {}
    for cell in _cells(module):
        found = ways(cell)
        outputs = [names.get(net, cell.name) for pin in cell.outputs for net in cell.nets(pin)]
        own = outputs[0] if outputs else cell.name
        if not is_register(cell):
            own = f"{own} ({cell.kind})"
        starts.update(found.starts)
        ends.update((point, own) for point in found.ends)
        names.update((point, own) for point in (*found.starts, *found.ends) if isinstance(point, str))
        for arc in found.arcs:
            steps[arc.target].append(_Step(arc.source, cell.kind, arc.carry))
    for name, port in module["ports"].items():
        nets = [net for net in port["bits"] if isinstance(net, int)]
        if port["direction"] == "input":
            starts.update(nets)
        else:
            ends.update((net, f"port {name}") for net in nets if net not in ends)
    return _Graph(steps, frozenset(starts), ends, names)


def _net_names(netnames: Mapping[str, Any]) -> dict[Point, str]:
    """Return the name of each net; that of a register where it has several."""
    ranked: dict[int, tuple[bool, bool, int, str]] = {}
    for name, net in netnames.items():
        for place, bit in enumerate(net["bits"]):
            if isinstance(bit, int):
                shown = f"{name}[{place}]" if len(net["bits"]) > 1 else name
                rank = (bool(net.get("hide_name")), not name.endswith("_q"), len(name), shown)
                ranked[bit] = min(rank, ranked.get(bit, rank))
    return {bit: rank[3] for bit, rank in ranked.items()}


def _in_order(graph: _Graph, netlist: Path) -> list[Point]:
    """Return all points so that each comes behind those that it depends on."""
    followers: defaultdict[Point, list[Point]] = defaultdict(list)
    missing: dict[Point, int] = {}
    for target, steps in graph.steps.items():
        missing[target] = len(steps)
        for step in steps:
            followers[step.source].append(target)
    ready = [point for point in followers if point not in missing]
    order: list[Point] = []
    while ready:
        point = ready.pop()
        order.append(point)
        for target in followers[point]:
            missing[target] -= 1
            if not missing[target]:
                ready.append(target)
    circle = [point for point, count in missing.items() if count]
    if circle:
        raise InputError(f"{netlist}: logic in a circle at {graph.names.get(circle[0], circle[0])}")
    return order


def _longest(graph: _Graph, order: Iterable[Point], *, chains_once: bool) -> LogicPath:
    depth: dict[Point, int] = {}
    behind: dict[Point, _Step] = {}
    for point in order:
        # What no register or port drives, an unconnected pin, starts nothing.
        if point in graph.starts:
            depth[point] = 0
        for step in graph.steps.get(point, ()):
            if step.source in depth:
                reached = depth[step.source] + (0 if chains_once and step.carry else 1)
                if reached > depth.get(point, -1):
                    depth[point], behind[point] = reached, step
    reached = [point for point in graph.ends if point in depth]
    if not reached:
        return LogicPath("", "", (), 0)
    last = max(reached, key=lambda point: depth[point])
    point, cells, hops = last, [], 0
    while point in behind:
        step = behind[point]
        cells.append(step.kind)
        hops += step.carry
        point = step.source
    start = graph.names.get(point, str(point))
    return LogicPath(start, graph.ends[last], tuple(reversed(cells)), len(cells) - hops)
