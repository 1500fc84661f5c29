"""Simulators other than Verilator, for runs on the pins: cocotb's runner knows how each is called.

Icarus Verilog, which has four states, takes no SystemVerilog as the RTL is written in: yosys elaborates it
first, registers and memories left as they are, and writes Verilog. Assertions are left out there.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

from cocotb_tools.runner import get_runner

from triaxis.golden.errors import InputError
from triaxis.sim.build import build_error, built
from triaxis.sim.paths import BUILD, VERIF
from triaxis.sim.programs import read_slang, run_to_result, yosys, yosys_version
from triaxis.sim.verilate import Build

ICARUS = "icarus"
# They read the RTL as it is, with its assertions. Nobody has tried them here.
UNTRIED = ("questa", "riviera", "vcs", "xcelium")

_TIMESCALE = ("1ns", "1ps")
# One bit of a memory written where it is enabled, as yosys says it.
_MEMORY_WRITE = re.compile(r"^ {4}if \((?P<enable>.*)\)\n(?P<bit> {6}\S.*) <= (?P<data>.*);$", re.MULTILINE)


def icarus_installed() -> bool:
    """Return whether Icarus Verilog is there."""
    return all(shutil.which(name) is not None for name in ("iverilog", "vvp"))


def icarus_version() -> str:
    """Return what Icarus Verilog calls itself."""
    said = subprocess.run(["iverilog", "-V"], capture_output=True, text=True, check=False).stdout
    return said.splitlines()[0] if said else "unknown"


def compiled_for(simulator: str, build: Build) -> Path:
    """Return the folder of a design on its pins compiled for a simulator, compiled where needed.

    Raises InputError where Icarus Verilog is not installed, or a tool does not take the design.
    """
    if simulator == ICARUS and not icarus_installed():
        raise InputError("iverilog: not found: install Icarus Verilog (Debian: apt-get install iverilog)")
    tools = (icarus_version(), yosys_version()) if simulator == ICARUS else (str(build.dut),)
    settings = (simulator, build.hashed, *tools)

    def make(partial: Path) -> None:
        print(f"building {build.name} for {simulator} (once) ..", file=sys.stderr, flush=True)
        design, parameters = [path for path in build.sources if path.suffix == ".sv"], dict(build.parameters)
        if simulator == ICARUS:
            design, parameters = [plain_verilog(build, partial)], {}
        log = partial / "build.log"
        try:
            get_runner(simulator).build(
                sources=design, hdl_toplevel=build.top, parameters=parameters, includes=[build.dut / "core"],
                build_dir=partial, always=True, timescale=_TIMESCALE, log_file=log,
            )  # fmt: skip
        except (SystemExit, RuntimeError) as error:
            # Without a log it was not even started.
            problem = InputError(f"{simulator}: {error}: install it, or choose another simulator")
            raise build_error(f"{build.name} for {simulator}", log) if log.exists() else problem from error

    return built(BUILD / simulator / build.name, [Path(__file__), *build.files], settings, make)


def plain_verilog(build: Build, folder: Path) -> Path:
    """Return the RTL of a build as Verilog in ``folder``, elaborated with its parameters."""
    sources = [path for path in build.sources if path.suffix == ".sv" and not path.is_relative_to(VERIF)]
    for path in (*sources, build.dut / "core" / "triaxis_stage.svh"):
        shutil.copy(path, folder)
    result = folder / f"{build.top}.v"
    # Nothing is optimised, and memories stay arrays: what is not reset or not written is unknown.
    script = (
        f"{read_slang([path.name for path in sources], build.top, build.parameters)}; "
        f"hierarchy -check -top {build.top}; proc -noopt; memory_collect; write_verilog -noattr {result.name}"
    )
    run_to_result([str(yosys()), "-p", script], result, folder / "yosys.log", folder)
    # In Verilog an unknown enable writes nothing, without a word: here it makes unknown what it might write.
    text = result.read_text(encoding="utf-8")
    poisoned = r"    if ((\g<enable>) !== 1'b0)\n\g<bit> <= (\g<enable>) === 1'b1 ? \g<data> : 1'bx;"
    result.write_text(_MEMORY_WRITE.sub(poisoned, text), encoding="utf-8")
    return result
