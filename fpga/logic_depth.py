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
from dataclasses import dataclass, field
from graphlib import CycleError, TopologicalSorter
from itertools import product
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
class _Cell:
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


@dataclass(frozen=True)
class _Arc:
    """``target`` depends on ``source`` through a cell. ``carry``: by the carry chain's own wire."""

    source: Point
    target: Point
    carry: bool = False


@dataclass
class _Ways:
    """How paths go through one cell, begin and end there."""

    arcs: list[_Arc] = field(default_factory=list)
    starts: list[Point] = field(default_factory=list)
    ends: list[Point] = field(default_factory=list)

    def join(self, sources: Iterable[Point], targets: Iterable[Point]) -> None:
        """Let all targets depend on all sources."""
        self.arcs += [_Arc(source, target) for source, target in product(sources, targets)]


def _ways(cell: _Cell) -> _Ways:
    """Return how paths go through a cell."""
    found, outputs = _Ways(), cell.nets(*cell.outputs)
    if _COMBINATIONAL.fullmatch(cell.kind):
        found.join(cell.nets(*cell.inputs()), outputs)
    elif cell.kind == "CARRY4":
        found.arcs += _carry(cell)
    elif cell.kind == "DSP48E1":
        _add_dsp(found, cell)
    else:
        # What stores what comes in: flip-flops, shift registers, memories.
        stored = [pin for pin in cell.inputs() if not pin.startswith(("C", "WCLK")) or pin == "CE"]
        found.starts += outputs
        found.ends += cell.nets(*stored)
        if _LUT_MEMORY.fullmatch(cell.kind):
            found.join(cell.nets(*filter(_READ_ADDRESS.fullmatch, cell.inputs())), outputs)
    return found


def _carry(cell: _Cell) -> Iterator[_Arc]:
    for pin, output in product(("CI", "CYINIT", "S", "DI"), ("O", "CO")):
        for (place, net), (to, out) in product(cell.pins.get(pin, ()), cell.pins.get(output, ())):
            # DI[i] joins the chain behind O[i].
            if to >= (place + 1 if (pin, output) == ("DI", "O") else place):
                yield _Arc(net, out, carry=pin == "CI")


def _add_dsp(found: _Ways, cell: _Cell) -> None:
    """Add the ways of a DSP48E1: A, B -> multiplier (M) -> adder (P), with C and PCIN to the adder."""
    used = {name: cell.parameters.get(name, 1) > 0 for name in ("AREG", "BREG", "CREG", "MREG", "PREG")}
    adder, result, inside = (f"{cell.name}.{place}" for place in ("M", "P", "inside"))
    beyond: list[Point] = list(cell.nets("P", "PCOUT"))
    if used["PREG"]:
        found.starts += beyond
        found.ends.append(result)
        beyond = [result]
    if used["MREG"]:
        found.ends.append(adder)
    if used["MREG"] or used["AREG"] or used["BREG"] or used["CREG"]:
        found.starts.append(inside)
        found.join([inside], beyond)
        if used["AREG"] and used["MREG"]:
            found.join([inside], [adder])
    for pin in cell.inputs():
        if pin in ("A", "B") and not used[f"{pin}REG"]:
            found.join(cell.nets(pin), [adder] if used["MREG"] else beyond)
        elif (pin == "C" and not used["CREG"]) or pin == "PCIN":
            found.join(cell.nets(pin), beyond)
        elif pin != "CLK":
            found.ends += cell.nets(pin)


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
    depends = {target: [step.source for step in steps] for target, steps in graph.steps.items()}
    try:
        order = list(TopologicalSorter(depends).static_order())
    except CycleError as error:
        point = error.args[1][0]
        raise InputError(f"{netlist}: logic in a circle at {graph.names.get(point, point)}") from error
    return LogicDepth(
        most_levels=_longest(graph, order, chains_once=True),
        most_cells=_longest(graph, order, chains_once=False),
    )


def _cells(module: Mapping[str, Any]) -> Iterator[_Cell]:
    for name, cell in module["cells"].items():
        directions = cell["port_directions"]
        yield _Cell(
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
        found, outputs = _ways(cell), cell.nets(*cell.outputs)
        own = names.get(outputs[0], cell.name) if outputs else cell.name
        if not _FLIP_FLOP.fullmatch(cell.kind):
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
