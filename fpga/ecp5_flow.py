"""Places and routes the core on an ECP5 with open tools: routed timing without a vendor's tool.

A proxy: the part is another vendor's, so the figure says how well the core
is pipelined, not what the board does.
"""

import json
import re
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.fpga.ecp5_registers import Absorbed, absorb_registers
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.programs import NEXTPNR, compiled, executable, from_one_folder, yosys

TOP = "triaxis_timing_top"
HARNESS = Path(__file__).resolve().parent / "ecp5" / f"{TOP}.sv"
TARGET_MHZ = 100.0
# The slowest grade of the largest ECP5, in the package of most pins.
PART, _PART_OPTIONS = "LFE5U-85F-6BG756", ("--85k", "--speed", "6", "--package", "CABGA756")
# Both operands of its multipliers have 18 bits, so the core's split for 25 x 18 bits would take two for one.
_PORT_BITS = 18
STAGES = ("synthesis", "registers", "placement and routing")


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
    _run("yosys", [str(yosys()), "-p", _script(read, parameters, written)], netlist, place)
    progress(1)
    absorbed = _pack(netlist, packed)
    progress(1)
    command = [
        str(place_and_route), *_PART_OPTIONS, "--freq", f"{TARGET_MHZ:g}", "--timing-allow-fail",
        # Of the placers that with the shortest wires here; what congests then is for router2 to negotiate.
        "--placer", "static", "--router", "router2",
        "--seed", str(seed), "--json", packed.name, "--report", report.name,
    ]  # fmt: skip
    _run("nextpnr", command, report, folder)
    progress(1)
    return Routed(report, report.with_suffix(".log"), absorbed)


def _script(sources: Sequence[Path], parameters: Mapping[str, int], netlist: Path) -> str:
    options = f"-D TRIAXIS_DSP_PORT_A={_PORT_BITS} " + " ".join(
        f"-G {name}={value}" for name, value in parameters.items()
    )
    include, files = sources[0].parent, " ".join(map(str, sources))
    return "; ".join(
        [
            # One thread: WebAssembly has no more.
            f"read_slang --threads 1 -I {include} {options} --top {TOP} {files}",
            f"synth_ecp5 -top {TOP} -json {netlist}",
        ]
    )


def _run(tool: str, command: Sequence[str], result: Path, folder: Path) -> None:
    """Run a tool, its output to a log beside its result; both tools can end silently without one."""
    result.unlink(missing_ok=True)
    log = result.with_suffix(".log")
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.run(
            command, cwd=folder, stdout=output, stderr=subprocess.STDOUT, stdin=subprocess.DEVNULL,
            check=False,
        )  # fmt: skip
    if process.returncode or not result.exists():
        errors = re.findall(r"^.*ERROR.*$", log.read_text(encoding="utf-8", errors="replace"), re.MULTILINE)
        reason = errors[0] if errors else f"no result, exit status {process.returncode}"
        raise InputError(f"{tool}: {reason} (log: {log})")


def _pack(netlist: Path, packed: Path) -> Absorbed:
    """Move registers into the multipliers' blocks."""
    try:
        design = json.loads(netlist.read_text(encoding="utf-8"))
        absorbed = absorb_registers(design["modules"][TOP])
    except (ValueError, KeyError) as error:
        raise InputError(f"{netlist}: no netlist of {TOP}: {error!r}") from error
    write_whole(packed, json.dumps(design))
    return absorbed
