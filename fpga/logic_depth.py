"""The longest ways between registers of a netlist mapped to the 7 series.

An estimate of timing that needs no vendor tool. Routing is not known before place and route, but what lies
between two registers is: how many levels of logic, and how much of a clock the cells leave to the wires
between them. Ports count as registers, which is what the core asks of its surroundings.
"""

import json
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from graphlib import CycleError, TopologicalSorter
from pathlib import Path
from typing import Any

from triaxis.fpga.xc7_cells import FLIP_FLOP, REGISTER_NS, Cell, Point, ways
from triaxis.golden.errors import InputError

# The clock of the board, and the one that is wanted.
CLOCKS_MHZ = (100.0, 200.0)


@dataclass(frozen=True)
class LogicPath:
    """A chain of cells from a register (or port) to the next."""

    start: str
    end: str
    cells: tuple[str, ...]  # kinds, in order
    levels: int  # a chain of CARRY4, joined by its own carry wire, counts once
    cells_ns: float = 0.0  # with both registers
    wires: int = 0  # of the fabric: those inside a slice and those of chains are not

    def summary(self) -> str:
        """Return the cells by kind, such as "CARRY4 x 13, LUT6 x 2"."""
        return ", ".join(f"{kind} x {count}" for kind, count in sorted(Counter(self.cells).items()))


@dataclass(frozen=True)
class Tightest:
    """The path that leaves its wires the least time at a clock.

    ``wire_ns``: that time, for each of them; where no wire takes more, every path of the netlist is fast
    enough. Negative where the cells alone are too slow.
    """

    mhz: float
    wire_ns: float
    path: LogicPath


@dataclass(frozen=True)
class LogicDepth:
    """The path of most levels, and the tightest at each of CLOCKS_MHZ."""

    most_levels: LogicPath
    tightest: tuple[Tightest, ...]


@dataclass(frozen=True)
class _Step:
    source: Point
    kind: str
    carry: bool
    ns: float
    wires: int

    def cost(self, wire_ns: float | None) -> float:
        """Return its time, or where no time of wires is given its levels."""
        if wire_ns is None:
            return 0 if self.carry else 1
        return self.ns + self.wires * wire_ns


@dataclass(frozen=True)
class _Stored:
    """Where a path ends. ``name``: of what stores."""

    name: str
    ns: float
    wires: int


@dataclass(frozen=True)
class _Graph:
    steps: Mapping[Point, list[_Step]]  # by target
    starts: Mapping[Point, float]  # ns after the clock
    ends: Mapping[Point, list[_Stored]]
    names: Mapping[Point, str]


def logic_depth(netlist: Path) -> LogicDepth:
    """Return the longest paths of a flat netlist: yosys's ``write_json`` after ``synth_xilinx -flatten``.

    Raises InputError where the file is none, has a cell that is not known, or where logic runs in a circle.
    """
    try:
        modules = json.loads(netlist.read_text(encoding="utf-8"))["modules"]
        (module,) = [m for m in modules.values() if m.get("attributes", {}).get("top")]
        graph = _graph(module)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{netlist}: no netlist of one top module by yosys: {error!r}") from error
    depends = {target: [step.source for step in steps] for target, steps in graph.steps.items()}
    try:
        order = list(TopologicalSorter(depends).static_order())
    except CycleError as error:
        point = error.args[1][0]
        raise InputError(f"{netlist}: logic in a circle at {graph.names.get(point, point)}") from error
    # From a register right to the next: no cell between them makes a step.
    order += [point for point in graph.ends if point not in depends]
    tightest = tuple(_tightest(graph, order, mhz) for mhz in CLOCKS_MHZ)
    return LogicDepth(_longest(graph, order), tightest)


def _cells(module: Mapping[str, Any]) -> Iterator[Cell]:
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
    cells = list(_cells(module))
    in_slice = {net for cell in cells if cell.in_slice for net in cell.nets(*cell.outputs)}
    users = Counter(net for cell in cells for net in cell.nets(*cell.inputs()))
    ports = module["ports"]
    users.update(net for port in ports.values() for net in port["bits"] if port["direction"] == "output")

    def wires(cell: Cell, net: Point, pin: str) -> int:
        """Return 1 where a net comes to a pin by a wire: not from a cell of which alone it is the next."""
        return int(bool(pin) and not (cell.near(pin) and net in in_slice and users[net] == 1))

    steps: defaultdict[Point, list[_Step]] = defaultdict(list)
    starts: dict[Point, float] = {}
    ends: defaultdict[Point, list[_Stored]] = defaultdict(list)
    for cell in cells:
        found, outputs = ways(cell), cell.nets(*cell.outputs)
        own = names.get(outputs[0], cell.name) if outputs else cell.name
        if not FLIP_FLOP.fullmatch(cell.kind):
            own = f"{own} ({cell.kind})"
        starts |= found.starts
        for end in found.ends:
            ends[end.point].append(_Stored(own, end.ns, wires(cell, end.point, end.pin)))
        inner = (*found.starts, *(end.point for end in found.ends))
        names.update((point, own) for point in inner if isinstance(point, str))
        for arc in found.arcs:
            step = _Step(arc.source, cell.kind, arc.carry, arc.ns, wires(cell, arc.source, arc.pin))
            steps[arc.target].append(step)
    for name, port in ports.items():
        nets = [net for net in port["bits"] if isinstance(net, int)]
        if port["direction"] == "input":
            starts |= dict.fromkeys(nets, REGISTER_NS)
        else:
            for net in nets:
                ends[net].append(_Stored(f"port {name}", 0.0, 1))
    return _Graph(steps, starts, ends, names)


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


def _tightest(graph: _Graph, order: Iterable[Point], mhz: float) -> Tightest:
    """Return the path that leaves its wires the least time.

    The longest path, wires of w ns included, as a function of w is the upper edge of straight lines, whose
    slopes are the paths' wires: Newton's steps lead to where it takes a whole period, and end there.
    """
    wire_ns = period_ns = 1000 / mhz
    while True:
        path = _longest(graph, order, wire_ns)
        # What has no wire, a chain of DSP blocks, may be too slow all the same.
        if (less := (period_ns - path.cells_ns) / max(path.wires, 1)) >= wire_ns:
            return Tightest(mhz, round(wire_ns, 3), path)
        wire_ns = less


def _longest(graph: _Graph, order: Iterable[Point], wire_ns: float | None = None) -> LogicPath:
    """Return the path that takes longest with wires of so many ns each, or the one of most levels."""
    reached: dict[Point, float] = {}
    behind: dict[Point, _Step] = {}
    for point in order:
        # What no register or port drives, an unconnected pin, starts nothing.
        if point in graph.starts:
            reached[point] = 0 if wire_ns is None else graph.starts[point]
        for step in graph.steps.get(point, ()):
            if step.source in reached:
                total = reached[step.source] + step.cost(wire_ns)
                if total > reached.get(point, -1):
                    reached[point], behind[point] = total, step

    def whole(found: tuple[Point, _Stored]) -> float:
        point, end = found
        return reached[point] + (0 if wire_ns is None else end.ns + end.wires * wire_ns)

    ends = [(point, end) for point in graph.ends if point in reached for end in graph.ends[point]]
    if not ends:
        return LogicPath("", "", (), 0)
    point, end = max(ends, key=whole)
    steps: list[_Step] = []
    while point in behind:
        steps.append(behind[point])
        point = behind[point].source
    return LogicPath(
        start=graph.names.get(point, str(point)),
        end=end.name,
        cells=tuple(step.kind for step in reversed(steps)),
        levels=sum(not step.carry for step in steps),
        cells_ns=round(graph.starts[point] + sum(step.ns for step in steps) + end.ns, 3),
        wires=sum(step.wires for step in steps) + end.wires,
    )
