"""Routed timing of the core without a vendor's tool: placed and routed on a Gowin GW5AST with open ones.

A proxy: the part is another vendor's, so the figure says how well the core is pipelined, not what the board
does. The public timing data of that part knows look-up tables, carry chains, flip-flops and memories, but no
multipliers: wires to them, the time in them and wires from them are no part of the figure. All else is, as
before and behind each multiplier stands a flip-flop of the fabric.
"""

import json
import re
from collections.abc import Callable, Mapping, Sequence
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
_FOLDER = Path(__file__).resolve().parent / "gowin"
HARNESS = _FOLDER / f"{TOP}.sv"
# What yosys calls a product, made of the part's multiplier; the pins of the harness.
_MULTIPLIER, _PINS = _FOLDER / "multiplier.v", _FOLDER / "pins.cst"
TARGET_MHZ = 100.0
# Of the parts that are known to the tool the one with most multipliers; its family, as the tool calls it.
PART, _FAMILY = "GW5AST-LV138PG484AC1/I0", "GW5AST-138C"
STAGES = ("synthesis", "placement and routing")
UNTIMED = "multipliers, and wires to and from them"

# The bits of the multiplier's operands, signed; the core's second operand has no more than 18.
_PORT_A, _PORT_B = 36, 27
# A smaller product takes fewer look-up tables than it is worth a multiplier.
_LEAST_BITS = 6
_CELL_SUFFIX = re.compile(
    r"_(DFF[A-Z]*|ALU|LUT\d|MUX2_LUT\d|MULT27X36|SDP\w*|RAM16\w*)_[A-Z]+\d*(_\d+)?(?=_|\$|$)"
)


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
) -> Path:
    """Synthesise, place and route; return nextpnr's report. All that the tools write stays in ``folder``.

    Raises InputError where a tool is missing, fails, or ends without an answer.
    """
    place_and_route = nextpnr()
    folder.mkdir(parents=True, exist_ok=True)
    netlist, pins, report = (folder / name for name in ("synthesised.json", _PINS.name, "report.json"))
    place, (written, multiplier, *read) = from_one_folder([netlist, _MULTIPLIER, *sources, HARNESS])
    script = _synthesis(multiplier, read, written, parameters)
    run_to_result([str(yosys()), "-p", script], netlist, netlist.with_suffix(".log"), place)
    progress(1)
    pins.write_bytes(_PINS.read_bytes())
    command = [
        str(place_and_route), "--device", PART, "--vopt", f"family={_FAMILY}", "--vopt", f"cst={pins.name}",
        "--freq", f"{TARGET_MHZ:g}", "--timing-allow-fail", "--seed", str(seed),
        "--json", netlist.name, "--report", report.name,
    ]  # fmt: skip
    run_to_result(command, report, report.with_suffix(".log"), folder)
    progress(1)
    return report


def _synthesis(multiplier: Path, read: Sequence[Path], written: Path, parameters: Mapping[str, int]) -> str:
    """Return yosys's script. Its own way to this part takes no product as wide as the multiplier."""
    options = f"-D TRIAXIS_DSP_PORT_A={_PORT_A} -I {read[0].parent}"
    widths = " ".join(
        f"-D DSP_{port}_MAXWIDTH={most} -D DSP_{port}_MINWIDTH={_LEAST_BITS}"
        for port, most in (("A", _PORT_A), ("B", _PORT_B))
    )
    return "; ".join(
        [
            read_slang(read, TOP, parameters, options),
            "read_verilog -lib +/gowin/cells_xtra_gw5a.v",
            "read_verilog -specify -lib +/gowin/cells_sim.v",
            f"hierarchy -top {TOP}",
            "proc; flatten; opt -full; wreduce; opt_clean",
            f"techmap -map +/mul2dsp.v -map {multiplier} {widths} -D DSP_NAME=$__MULTIPLIER"
            " -D DSP_SIGNEDONLY=1",
            # Products that are too small for it become look-up tables.
            "chtype -set $mul t:$__soft_mul; opt_clean",
            f"synth_gowin -family gw5a -nolutram -nodsp -top {TOP} -run coarse: -json {written}",
        ]
    )


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
        cells = {kind: count for kind, count in content["utilization"].items() if count["available"]}
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


def write_timing(path: Path, timing: Timing, parameters: Mapping[str, int], rtl_hash: str, tool: str) -> None:
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
        "not_timed": UNTIMED,
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
