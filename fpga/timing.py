"""The routed frequency and the critical path, from nextpnr's report.

A path is told by registers, not by cells: nextpnr knows cells only, and names them after nets beside them.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from triaxis.fpga.ecp5_flow import PART, TARGET_MHZ
from triaxis.fpga.ecp5_registers import Absorbed
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole

_CELL_SUFFIX = re.compile(
    r"_(TRELLIS_(FF|DPR16X4)|CCU2C|LUT4|PFUMX|L6MUX21|MULT18X18D)_[A-Z]+\d*(_\d+)?(?=_|\$|$)"
)


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
