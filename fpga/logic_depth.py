"""The longest chains of logic between registers of a netlist mapped to the 7 series.

An estimate of timing that needs no vendor tool: routing is not known before place and route, but what lies
between two registers is. Ports count as registers, which is what the core asks of its surroundings.
"""

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from triaxis.fpga.xc7_arcs import Cell, Point, is_register, ways
from triaxis.golden.errors import InputError


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
