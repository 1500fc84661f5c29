"""Routed timing of the core without a vendor's tool: placed and routed on an ECP5 with open ones.

A proxy: the part is another vendor's, so the figure says how well the core is pipelined, not what the board
does.
"""

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass
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
STAGES = ("synthesis", "registers", "placement and routing")

_BLOCK, _REGISTER = "MULT18X18D", "TRELLIS_FF"
# Operands have 18 bits, so the core's split for 25 x 18 bits would take two blocks for one.
_PORT_BITS = {"A": 18, "B": 18, "P": 36}
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


def absorb_registers(module: dict[str, Any]) -> Absorbed:
    """Move registers into the blocks of a module, a flat netlist of yosys's ``write_json``, in place.

    A register that others need too stays, beside its copy in the block.
    """
    cells = module["cells"]
    driver: dict[int, str] = {}
    users: defaultdict[int, list[tuple[str, str]]] = defaultdict(list)
    for name, cell in cells.items():
        for pin, net in _connected(cell):
            if cell["port_directions"][pin] == "output":
                driver[net] = name
            else:
                users[net].append((name, pin))
    outside = {net for port in module["ports"].values() for net in port["bits"]}

    def behind(net: int) -> str:
        """Return the register that alone takes a net."""
        taken = users[net]
        alone = len(taken) == 1 and net not in outside
        return taken[0][0] if alone and taken[0][1] == "DI" else ""

    blocks = [cell for cell in cells.values() if cell["type"] == _BLOCK]
    taken_behind = 0
    for block in blocks:
        # What nobody uses of a product needs no register.
        product = {pin: net for pin, net in _connected(block, "P") if users[net] or net in outside}
        names = [behind(net) for net in product.values()]
        if _absorbed(cells, block, list(product), names, "Q", ("OUTPUT",)):
            taken_behind += 1
            for name in names:
                del cells[name]
    taken_before = 0
    for block in blocks:
        # A register does not change a constant.
        operands = dict(_connected(block, "AB"))
        names = [driver.get(net, "") for net in operands.values()]
        taken_before += _absorbed(cells, block, list(operands), names, "DI", ("INPUTA", "INPUTB"))
    needed = outside.union(
        net
        for cell in cells.values()
        for pin, net in _connected(cell)
        if cell["port_directions"][pin] != "output"
    )
    for name, cell in list(cells.items()):
        if cell["type"] == _REGISTER and cell["connections"]["Q"][0] not in needed:
            del cells[name]
    return Absorbed(len(blocks), taken_before, taken_behind)


def _connected(cell: dict[str, Any], ports: str = "") -> Iterator[tuple[str, int]]:
    """Yield the pins that are on nets, not constants, with the nets: all, or those of a block's ports."""
    wanted = {f"{port}{place}" for port in ports for place in range(_PORT_BITS[port])}
    for pin, nets in cell["connections"].items():
        if not ports or pin in wanted:
            yield from ((pin, net) for net in nets if isinstance(net, int))


def _absorbed(
    cells: dict[str, Any], block: dict[str, Any], pins: list[str], names: list[str], far: str,
    places: tuple[str, ...],
) -> bool:  # fmt: skip
    """Put the far side of each register on the block's pin, if all are plain and on the block's clock.

    The block's own registers at ``places`` then do their work: always enabled, never reset.
    """
    registers = [cells.get(name, {}) for name in names]
    if not registers or not all(map(_is_plain, registers)):
        return False
    clock = block["connections"].get("CLK0", registers[0]["connections"]["CLK"])
    if any(register["connections"]["CLK"] != clock for register in registers):
        return False
    own = {"CLK0": clock, "CE0": ["1"], "RST0": ["0"]}
    taken = zip(pins, registers, strict=True)
    block["connections"].update({pin: register["connections"][far] for pin, register in taken}, **own)
    block["port_directions"].update(dict.fromkeys(own, "input"))
    block["parameters"].update({f"REG_{place}_{pin[:-1]}": pin for place in places for pin in own})
    return True


def _is_plain(cell: dict[str, Any]) -> bool:
    """Return whether a cell is a register without enable and reset."""
    if cell.get("type") != _REGISTER:
        return False
    parameters = cell["parameters"]
    plain = (parameters["CEMUX"], parameters["CLKMUX"], parameters["LSRMUX"]) == ("1 ", "CLK", "LSR")
    return plain and cell["connections"].get("LSR", ["0"]) == ["0"]


# --- The flow ---------------------------------------------------------------------------------------------


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
) -> tuple[Path, Absorbed]:
    """Synthesise, place and route; return nextpnr's report, and what moved into multiplier blocks.

    Everything the tools write stays in ``folder``.

    Raises InputError where a tool is missing, fails, or ends without an answer.
    """
    place_and_route = nextpnr()
    folder.mkdir(parents=True, exist_ok=True)
    netlist, packed, report = (folder / name for name in ("synthesised.json", "packed.json", "report.json"))
    place, (written, *read) = from_one_folder([netlist, *sources, HARNESS])
    options = f"-D TRIAXIS_DSP_PORT_A={_PORT_BITS['A']} -I {read[0].parent}"
    script = f"{read_slang(read, TOP, parameters, options)}; synth_ecp5 -top {TOP} -json {written}"
    run_to_result([str(yosys()), "-p", script], netlist, netlist.with_suffix(".log"), place)
    progress(1)
    try:
        design = json.loads(netlist.read_text(encoding="utf-8"))
        absorbed = absorb_registers(design["modules"][TOP])
    except (ValueError, KeyError) as error:
        raise InputError(f"{netlist}: no netlist of {TOP}: {error!r}") from error
    write_whole(packed, json.dumps(design))
    progress(1)
    command = [
        str(place_and_route), *_PART_OPTIONS, "--freq", f"{TARGET_MHZ:g}", "--timing-allow-fail",
        # Of the placers that with the shortest wires here; what congests then is for router2 to negotiate.
        "--placer", "static", "--router", "router2",
        "--seed", str(seed), "--json", packed.name, "--report", report.name,
    ]  # fmt: skip
    run_to_result(command, report, report.with_suffix(".log"), folder)
    progress(1)
    return report, absorbed


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
