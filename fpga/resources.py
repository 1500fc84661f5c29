"""What builds of the core and of the whole board take of the part, as yosys maps them to the 7 series.

An estimate, not a routed result.
"""

import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.fpga.board_build import BOARD_LIMITS, TOP, TWICE, WHOLE_PART, XC7A100T, Limits, Resources
from triaxis.fpga.logic_depth import LogicDepth
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.configuration import CERTIFIED_TOP, CORE_TOP
from triaxis.sim.programs import from_one_folder, read_slang, run_to_result, yosys

# What decides, besides RTL and tool, what comes of a synthesis.
SYNTHESIS = Path(__file__)

# LUTs that a cell occupies. Shift registers and RAMs are made of LUTs: RAM32M of four. An inverter is one at
# most: the LUT that it drives, or an input that can be inverted, may take it in.
_LUTS = {f"LUT{n}": 1 for n in range(1, 7)} | {
    "INV": 1,
    "SRL16E": 1, "SRLC32E": 1, "RAM32X1D": 2, "RAM64X1D": 2, "RAM128X1D": 4, "RAM32M": 4, "RAM64M": 4,
    "RAM32X1S": 1, "RAM64X1S": 1, "RAM128X1S": 2, "RAM256X1S": 4,
}  # fmt: skip
_FFS = tuple(f"FD{kind}E{edge}" for kind in "RSCP" for edge in ("", "_1"))
# Of blocks of RAM one of 18 kbit counts as half.
_BRAMS = {"RAMB36E1": 1.0, "RAMB18E1": 0.5}
# Kinds that take something of which there is a limit.
_TAKES = re.compile(r"(?:LUT|INV|SRL|RAM|FIFO|FD|LD|DSP).*")
_MEMORY = re.compile(r"^mapping memory (\S+) via \$__XILINX_(BLOCK|LUT)RAM", re.MULTILINE)
_KINDS = {"BLOCK": "block", "LUT": "look-up tables"}


@dataclass(frozen=True)
class Synthesis:
    """What a build takes, what each memory in it was made of, block or look-up tables, and its netlist.

    The netlist is there as Verilog too, beside it, for simulation: netlist.v. ``apart``: the paths of the
    instances that are modules of their own in it.
    """

    used: Resources
    memories: Mapping[str, str]
    netlist: Path
    apart: frozenset[str] = frozenset()


def synthesise(
    sources: Sequence[Path],
    include: Path,
    top: str,
    parameters: Mapping[str, int],
    folder: Path,
    kept: Sequence[str] = (),
) -> Synthesis:
    """Synthesise out of context and count; the log and yosys's statistics stay in ``folder``.

    ``kept``: signals of the top that must keep their names, where the netlist is watched.

    Raises InputError where the tool fails or ends without an answer.
    """
    folder.mkdir(parents=True, exist_ok=True)
    statistics, netlist, log = folder / "statistics.json", folder / "netlist.json", folder / "yosys.log"
    verilog = netlist.with_suffix(".v")
    paths = [include, netlist, verilog, statistics, *sources]
    place, (read, written, simulated, counted, *near) = from_one_folder(paths)
    script = "; ".join(
        [
            # Else it flattens at once, and what is there twice becomes one: see TWICE in board_build.py.
            read_slang(near, top, parameters, f"-I {read} --best-effort-hierarchy"),
            *([f"setattr -set keep 1 {' '.join(f'{top}/w:{name}' for name in kept)}"] if kept else []),
            f"synth_xilinx -family xc7 -flatten -noiopad -top {top}",
            f"write_json {written}",
            f"write_verilog -noattr {simulated}",
            f"tee -q -o {counted} stat -json -tech xilinx",
        ]
    )
    run_to_result([str(yosys()), "-p", script], statistics, log, place)
    found = json.loads(statistics.read_text())
    # A module that is kept is named MODULE$PATH.
    apart = frozenset(path for name in found["modules"] if (path := name.partition("$")[2]))
    used = count(found["design"]["num_cells_by_type"])
    return Synthesis(used, memories(log.read_text(errors="replace")), netlist, apart)


def memories(log: str) -> dict[str, str]:
    """Return what yosys made each memory of, by its path in the design, from its log."""
    return {name: _KINDS[kind] for name, kind in _MEMORY.findall(log)}


def count(cells: Mapping[str, int]) -> Resources:
    """Return the resources that mapped cells occupy; raise InputError for one that would count as nothing."""
    known = {"DSP48E1", *_LUTS, *_FFS, *_BRAMS}
    if unknown := sorted(cell for cell in cells if _TAKES.fullmatch(cell) and cell not in known):
        raise InputError(f"yosys: {unknown[0]}: it is not known what such a cell takes of the part")
    return Resources(
        dsps=cells.get("DSP48E1", 0),
        luts=sum(cells.get(cell, 0) * luts for cell, luts in _LUTS.items()),
        ffs=sum(cells.get(cell, 0) for cell in _FFS),
        brams=sum(cells.get(cell, 0) * brams for cell, brams in _BRAMS.items()),
    )


# The memories of the mesh engine that are as deep as the meshes: vertices, and boxes of triangles.
_DEEP = re.compile(r"\.u_store_[ab]\.(?:.*\.)?(?:u_triangles|u_boxes)\.")


@dataclass(frozen=True)
class Build:
    """A build to be reported, with the most that it may take."""

    name: str
    meaning: str
    parameters: Mapping[str, int]
    limits: Limits
    top: str = CORE_TOP


BUILDS = (
    Build("all_axes", "core, W = 16, all 32 axes, M = 0", {"W": 16, "M": 0}, Limits(dsps=85)),
    Build(
        "no_edge_box",
        "core, W = 16, without edge x box, M = 0",
        {"W": 16, "M": 0, "EdgeBox": 0},
        Limits(dsps=67),
    ),
    Build("margins", "core, W = 16, all 32 axes, M = 16", {"W": 16, "M": 16}, Limits(dsps=125)),
    Build("fine", "core, W = 24, all 32 axes, M = 1", {"W": 24, "M": 1}, Limits(dsps=170)),
    # At most 40 % more than without certificates.
    Build(
        "certified",
        "certified core, W = 16, all 32 axes, M = 16",
        {"W": 16, "M": 16},
        Limits(dsps=175),
        CERTIFIED_TOP,
    ),
    Build(
        "board",
        "board, W = 16, M = 16, 4,096 triangles, 8 lanes",
        {"W": 16, "M": 16, "Depth": 4096, "Group": 8, "Lanes": 8},
        BOARD_LIMITS,
        TOP,
    ),
    # One margin bit covers the rounding to the grid, and takes no DSP block.
    Build(
        "board_fine",
        "board, W = 24, M = 1, 4,096 triangles, 1 lane",
        {"W": 24, "M": 1, "Depth": 4096, "Group": 8, "Lanes": 1},
        WHOLE_PART,
        TOP,
    ),
)


@dataclass(frozen=True)
class Row:
    """A build, and what came of it; see `Synthesis`."""

    build: Build
    made: Synthesis
    depth: LogicDepth | None = None

    @property
    def problems(self) -> list[str]:
        """Return what is beyond its limit, not in block RAM though it should be, or not there twice."""
        found = self.build.limits.exceeded(self.made.used)
        if self.build.top != TOP:
            return found
        deep = {name: kind for name, kind in self.made.memories.items() if _DEEP.search(name)}
        misplaced = sorted(name for name, kind in deep.items() if kind != "block")
        if not deep:
            misplaced = ["the memories of the meshes: none found"]
        found += [f"{name}: not in block RAM" for name in misplaced]
        missing = sorted({f"{TOP}.{place}" for place in TWICE} - self.made.apart)
        return found + [f"{path}: not kept as it is: it may be one with its twin" for path in missing]

    @property
    def within_limit(self) -> bool:
        """Return whether the build has no problem."""
        return not self.problems


def write_report(path: Path, rows: Sequence[Row], rtl_hash: str, tool: str) -> None:
    """Write the rows as JSON, whole or not at all."""
    content = {
        "part": "XC7A100T",
        "available": asdict(XC7A100T),
        "rtl_hash": rtl_hash,
        "tool": tool,
        "builds": {
            row.build.name: {
                "meaning": row.build.meaning,
                "top": row.build.top,
                "parameters": dict(row.build.parameters),
                **asdict(row.made.used),
                "limits": asdict(row.build.limits),
                "memories": dict(row.made.memories),
                "logic_depth": asdict(row.depth) if row.depth else None,
                "problems": row.problems,
                "within_limit": row.within_limit,
            }
            for row in rows
        },
    }
    write_whole(path, json.dumps(content, indent=2) + "\n")
