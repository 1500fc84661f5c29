"""Routed timing of the core without a vendor's tool: placed and routed on an ECP5 with open ones.

A proxy: the part is another vendor's, so the figure says how well the core is pipelined, not what the board
does.
"""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.programs import (
    NEXTPNR,
    compiled,
    executable,
    from_one_folder,
    read_slang,
    run_to_result,
    yosys,
)

TOP = "triaxis_timing_top"
HARNESS = Path(__file__).resolve().parent / "ecp5" / f"{TOP}.sv"
TARGET_MHZ = 100.0
# The slowest grade of the largest ECP5, in the package of most pins.
PART, _PART_OPTIONS = "LFE5U-85F-6BG756", ("--85k", "--speed", "6", "--package", "CABGA756")
# Both operands of its multipliers have 18 bits, so the core's split for 25 x 18 bits would take two for one.
_PORT_BITS = 18
STAGES = ("synthesis", "registers", "placement and routing")

_BLOCK, _REGISTER = "MULT18X18D", "TRELLIS_FF"
_OPERAND_BITS, _PRODUCT_BITS = 18, 36
_CELL_SUFFIX = re.compile(
    r"_(TRELLIS_(FF|DPR16X4)|CCU2C|LUT4|PFUMX|L6MUX21|MULT18X18D)_[A-Z]+\d*(_\d+)?(?=_|\$|$)"
)


# --- Registers ------------------------------------------------------------------------------------------
# Blocks of both vendors have registers before and behind the multiplier. Vendors' tools use them, and yosys
# does for the 7 series, but not for the ECP5: there it leaves all of them in the fabric, and the way to and
# from the block is then the slowest of the design. Only plain registers move: no enable, no reset.


@dataclass(frozen=True)
class Absorbed:
    """How many blocks there are, and how many of them took registers before and behind the multiplier."""

    blocks: int
    before: int
    behind: int


@dataclass
class _Netlist:
    """The cells of a module, what drives each net, and which pins each net drives."""

    cells: dict[str, Any]
    driver: dict[int, str] = field(default_factory=dict)
    users: defaultdict[int, set[tuple[str, str]]] = field(default_factory=lambda: defaultdict(set))

    def register_behind(self, net: int) -> str | None:
        """Return the plain register that alone takes a net."""
        if len(self.users[net]) != 1:
            return None
        ((name, pin),) = self.users[net]
        return name if pin == "DI" and self._is_plain(name) else None

    def register_before(self, net: int | str) -> str | None:
        """Return the plain register that drives a net."""
        name = self.driver.get(net) if isinstance(net, int) else None
        return name if name is not None and self._is_plain(name) else None

    def _is_plain(self, name: str) -> bool:
        cell = self.cells.get(name, {})
        if cell.get("type") != _REGISTER:
            return False
        parameters, pins = cell["parameters"], cell["connections"]
        return (
            parameters["CEMUX"] == "1 "
            and parameters["CLKMUX"] == "CLK"
            and parameters["LSRMUX"] == "LSR"
            and pins.get("LSR", ["0"]) == ["0"]
        )


def absorb_registers(module: dict[str, Any]) -> Absorbed:
    """Move registers into the blocks of a module, a flat netlist of yosys's ``write_json``, in place.

    A register that others need too stays, beside its copy in the block.
    """
    netlist = _read(module)
    blocks = [cell for cell in netlist.cells.values() if cell["type"] == _BLOCK]
    behind = sum(_absorb_behind(netlist, block) for block in blocks)
    before = sum(_absorb_before(netlist, block) for block in blocks)
    for name, cell in list(netlist.cells.items()):
        if cell["type"] == _REGISTER and not netlist.users[cell["connections"]["Q"][0]]:
            del netlist.cells[name]
    return Absorbed(len(blocks), before, behind)


def _read(module: dict[str, Any]) -> _Netlist:
    netlist = _Netlist(module["cells"])
    for name, cell in netlist.cells.items():
        for pin, nets in cell["connections"].items():
            for net in nets:
                if not isinstance(net, int):
                    continue
                if cell["port_directions"][pin] == "output":
                    netlist.driver[net] = name
                else:
                    netlist.users[net].add((name, pin))
    for name, port in module["ports"].items():
        for net in port["bits"]:
            netlist.users[net].add((name, "port"))
    return netlist


def _bits(block: dict[str, Any], port: str, width: int) -> Iterator[tuple[str, int | str]]:
    """Return the connected pins of a port of a block, and their nets or constants."""
    for place in range(width):
        for net in block["connections"].get(f"{port}{place}", []):
            yield f"{port}{place}", net


def _absorb_behind(netlist: _Netlist, block: dict[str, Any]) -> bool:
    product = [
        (pin, net)
        for pin, net in _bits(block, "P", _PRODUCT_BITS)
        if isinstance(net, int) and netlist.users[net]
    ]
    names = [netlist.register_behind(net) for _, net in product]
    registers = [netlist.cells[name] for name in names if name is not None]
    if not registers or len(registers) != len(product) or not _one_clock(block, registers):
        return False
    for (pin, _), name, register in zip(product, names, registers, strict=True):
        block["connections"][pin] = register["connections"]["Q"]
        del netlist.cells[str(name)]
    _clock(block, registers[0], ("OUTPUT",))
    return True


def _absorb_before(netlist: _Netlist, block: dict[str, Any]) -> bool:
    operands = [*_bits(block, "A", _OPERAND_BITS), *_bits(block, "B", _OPERAND_BITS)]
    # A register does not change a constant.
    pins = [(pin, net) for pin, net in operands if isinstance(net, int)]
    names = [netlist.register_before(net) for _, net in pins]
    registers = [netlist.cells[name] for name in names if name is not None]
    if not registers or len(registers) != len(pins) or not _one_clock(block, registers):
        return False
    own = next(name for name, cell in netlist.cells.items() if cell is block)
    for (pin, old), register in zip(pins, registers, strict=True):
        new = register["connections"]["DI"]
        block["connections"][pin] = new
        netlist.users[old].discard((own, pin))
        if isinstance(new[0], int):
            netlist.users[new[0]].add((own, pin))
    _clock(block, registers[0], ("INPUTA", "INPUTB"))
    return True


def _one_clock(block: dict[str, Any], registers: list[dict[str, Any]]) -> bool:
    clocks = [register["connections"]["CLK"] for register in registers]
    return all(clock == block["connections"].get("CLK0", clocks[0]) for clock in clocks)


def _clock(block: dict[str, Any], register: dict[str, Any], places: tuple[str, ...]) -> None:
    """Use the block's own registers: always enabled, never reset."""
    pins = {"CLK0": register["connections"]["CLK"], "CE0": ["1"], "RST0": ["0"]}
    block["connections"].update(pins)
    block["port_directions"].update(dict.fromkeys(pins, "input"))
    for place in places:
        block["parameters"].update({f"REG_{place}_{pin[:-1]}": pin for pin in pins})


# --- The flow ---------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Routed:
    """What a run left: nextpnr's report and log, and the registers moved into multiplier blocks."""

    report: Path
    log: Path
    absorbed: Absorbed


def nextpnr() -> Path:
    """Return the place and route tool, ready to start, or raise InputError where it is not installed."""
    compiled(NEXTPNR)
    return executable(NEXTPNR)


def nextpnr_version() -> str:
    """Return what the place and route tool calls itself."""
    said = compiled(NEXTPNR)
    found = re.search(r"\(Version (\S+)\)", said)
    return found[1] if found else said


def route(
    sources: Sequence[Path],
    parameters: Mapping[str, int],
    folder: Path,
    progress: Callable[[int], None],
    *,
    seed: int = 1,
) -> Routed:
    """Synthesise, place and route; everything the tools write stays in ``folder``.

    Raises InputError where a tool is missing, fails, or ends without an answer.
    """
    place_and_route = nextpnr()
    folder.mkdir(parents=True, exist_ok=True)
    netlist, packed, report = (folder / name for name in ("synthesised.json", "packed.json", "report.json"))
    place, (written, *read) = from_one_folder([netlist, *sources, HARNESS])
    options = f"-D TRIAXIS_DSP_PORT_A={_PORT_BITS} -I {read[0].parent}"
    script = f"{read_slang(read, TOP, parameters, options)}; synth_ecp5 -top {TOP} -json {written}"
    run_to_result([str(yosys()), "-p", script], netlist, netlist.with_suffix(".log"), place)
    progress(1)
    absorbed = _pack(netlist, packed)
    progress(1)
    command = [
        str(place_and_route), *_PART_OPTIONS, "--freq", f"{TARGET_MHZ:g}", "--timing-allow-fail",
        # Of the placers that with the shortest wires here; what congests then is for router2 to negotiate.
        "--placer", "static", "--router", "router2",
        "--seed", str(seed), "--json", packed.name, "--report", report.name,
    ]  # fmt: skip
    run_to_result(command, report, report.with_suffix(".log"), folder)
    progress(1)
    return Routed(report, report.with_suffix(".log"), absorbed)


def _pack(netlist: Path, packed: Path) -> Absorbed:
    """Move registers into the multipliers' blocks."""
    try:
        design = json.loads(netlist.read_text(encoding="utf-8"))
        absorbed = absorb_registers(design["modules"][TOP])
    except (ValueError, KeyError) as error:
        raise InputError(f"{netlist}: no netlist of {TOP}: {error!r}") from error
    write_whole(packed, json.dumps(design))
    return absorbed


# --- The report: a path is told by registers; nextpnr knows cells only, and names them after nets ------


@dataclass(frozen=True)
class Step:
    """One step of a path. ``kind``: clk-to-q, logic, routing or setup; ``net``: what routing follows."""

    kind: str
    cell: str
    net: str
    ns: float


@dataclass(frozen=True)
class Hop:
    """A wire of the fabric, and the cells behind it up to the next: those of a carry chain are one hop."""

    net: str
    routing_ns: float
    cells: int
    logic_ns: float


@dataclass(frozen=True)
class CriticalPath:
    """The slowest path from a register to a register."""

    steps: tuple[Step, ...]

    @property
    def hops(self) -> list[Hop]:
        """Return the path wire by wire; the first hop, without one, is the register in which it begins."""
        found = [Hop("", 0.0, 0, 0.0)]
        for step in self.steps:
            last = found[-1]
            if step.kind == "routing":
                if step.ns > 0:
                    found.append(Hop(step.net, step.ns, 0, 0.0))
            else:
                cells = last.cells + (step.kind == "logic")
                found[-1] = Hop(last.net, last.routing_ns, cells, last.logic_ns + step.ns)
        return found

    @property
    def start(self) -> str:
        """Return the register in which the path begins."""
        nets = [step.net for step in self.steps if step.net]
        return nets[0] if nets else register_name(self.steps[0].cell)

    @property
    def end(self) -> str:
        """Return the register in which the path ends."""
        return register_name(self.steps[-1].cell)

    @property
    def levels(self) -> int:
        """Return how many cells of logic the path passes."""
        return sum(step.kind == "logic" for step in self.steps)

    @property
    def routing_ns(self) -> float:
        """Return the time on wires, in ns."""
        return sum(step.ns for step in self.steps if step.kind == "routing")

    @property
    def logic_ns(self) -> float:
        """Return the time in cells, registers included, in ns."""
        return sum(step.ns for step in self.steps if step.kind != "routing")


@dataclass(frozen=True)
class Timing:
    """A routed build."""

    mhz: float
    path: CriticalPath
    used: Mapping[str, int]  # cells by kind
    available: Mapping[str, int]

    @property
    def reached(self) -> bool:
        """Return whether the frequency is what it must be."""
        return self.mhz >= TARGET_MHZ


def register_name(cell: str) -> str:
    """Return the net after which a cell is named."""
    return _CELL_SUFFIX.split(cell, maxsplit=1)[0]


def read_timing(report: Path) -> Timing:
    """Read nextpnr's report; raise InputError where it is none, or has no path between registers."""
    try:
        content = json.loads(report.read_text(encoding="utf-8"))
        ((clock, fmax),) = content["fmax"].items()
        (path,) = [
            path["path"]
            for path in content["critical_paths"]
            if path["from"] == path["to"] == f"posedge {clock}"
        ]
        cells = content["utilization"]
        return Timing(
            mhz=float(fmax["achieved"]),
            path=CriticalPath(tuple(_step(step) for step in path)),
            used={kind: int(count["used"]) for kind, count in cells.items() if count["used"]},
            available={kind: int(count["available"]) for kind, count in cells.items() if count["used"]},
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{report}: no timing report of one clock by nextpnr: {error!r}") from error


def _step(step: Mapping[str, Any]) -> Step:
    return Step(step["type"], step["to"]["cell"], step.get("net", ""), float(step["delay"]))


def write_timing(
    path: Path, timing: Timing, absorbed: Absorbed, parameters: Mapping[str, int], rtl_hash: str, tool: str
) -> None:
    """Write the figures as JSON."""
    content = {
        "part": PART,
        "tool": tool,
        "rtl_hash": rtl_hash,
        "parameters": dict(parameters),
        "mhz": timing.mhz,
        "target_mhz": TARGET_MHZ,
        "reached": timing.reached,
        "used": dict(timing.used),
        "available": dict(timing.available),
        "registers_in_multipliers": asdict(absorbed),
        "critical_path": {
            "start": timing.path.start,
            "end": timing.path.end,
            "levels": timing.path.levels,
            "logic_ns": timing.path.logic_ns,
            "routing_ns": timing.path.routing_ns,
            "steps": [asdict(step) for step in timing.path.steps],
        },
    }
    write_whole(path, json.dumps(content, indent=2) + "\n")
