"""Builds of the core, kept in build/ under a name that changes with everything that goes in."""

import hashlib
import os
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.golden.outputs import make_folder
from triaxis.sim.board_parameters import BoardParameters
from triaxis.sim.clocking import PERIOD_NS
from triaxis.sim.configuration import Configuration
from triaxis.sim.mesh_configuration import MeshConfiguration
from triaxis.sim.paths import BUILD, DUT, VERIF, board_sources, mesh_sources, rtl_sources
from triaxis.sim.toolchain import verilator

# No signal is public: Verilator's default for cocotb costs most of the speed. Functions of moderate length:
# g++ makes code of the whole core in one function that runs a third slower.
_SPEED = ["-O3", "--x-assign", "fast", "--x-initial", "fast", "--output-split-cfuncs", "1000"]

_LISTING = ".f"
_RTL_SUFFIXES = (".sv", ".svh", ".v", ".vh", _LISTING)
_FAST_CODE = "-march=native -std=c++20"
# Thousands of clocks, not millions: compiled quickly.
_TRACED = ("--trace-saif", "-MAKEFLAGS", "OPT_FAST=-O1 OPT_GLOBAL=-O2")
_BURST_TOP = "triaxis_burst_tb"
_RUNTIME = ("verilated", "verilated_dpi", "verilated_vpi", "verilated_threads")
# Simulation time is kept by the model itself, not by a function of the main program.
_FAST_RUNTIME = ("-O2", "-DVL_TIME_CONTEXT")


def content_hash(files: Sequence[Path], *more: str) -> str:
    """Return a hash of the files' names and contents and of further text."""
    digest = hashlib.sha256()
    for file in files:
        digest.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    for text in more:
        digest.update(text.encode() + b"\0")
    return digest.hexdigest()


def rtl_files(dut: Path = DUT) -> list[Path]:
    """Return everything in a folder of RTL that can elaborate, sub-folders too, and the lists of files.

    Raises InputError where a list names what is not among them: nothing would tell of its changes.
    """
    found = sorted(path for path in dut.rglob("*") if path.suffix in _RTL_SUFFIXES and path.is_file())
    for listing in (path for path in found if path.suffix == _LISTING):
        for entry in listing.read_text(encoding="utf-8").split():
            place = Path(os.path.normpath(listing.parent / entry))
            if place.suffix not in _RTL_SUFFIXES or not place.is_relative_to(os.path.normpath(dut)):
                raise InputError(f"{listing}: {entry}: must be a file of RTL in {dut}")
    return found


def core_files(dut: Path = DUT) -> list[Path]:
    """Return what builds of the core depend on."""
    return rtl_files(dut / "core")


def mesh_files(dut: Path = DUT) -> list[Path]:
    """Return what builds of the mesh engine depend on: the core's files and its own."""
    return [*core_files(dut), *rtl_files(dut / "mesh")]


def rtl_hash(dut: Path = DUT) -> str:
    """Return the hash of everything in dut/ that elaborates: what a sign-off is valid for."""
    return content_hash(rtl_files(dut))


def built(folder: Path, make: Callable[[Path], None]) -> Path:
    """Return ``folder``, after ``make`` has filled it once, whoever else wants it meanwhile.

    ``make`` works in a folder beside it that is renamed when whole, so an interrupted build leaves
    nothing that looks finished.
    """
    make_folder(folder.parent)
    with FileLock(folder.with_name(folder.name + ".lock")):
        if not folder.is_dir():
            partial = folder.with_name(folder.name + ".partial")
            shutil.rmtree(partial, ignore_errors=True)
            make_folder(partial)
            make(partial)
            partial.rename(folder)
    return folder


def run_tool(command: Sequence[str], folder: Path, what: str, with_runtime: bool = True) -> None:
    """Run a build command; raise InputError with the first error line where it fails.

    ``with_runtime``: see `Verilator.environment`.
    """
    log = folder / "build.log"
    with log.open("a") as output:
        status = subprocess.run(
            command,
            stdout=output,
            stderr=subprocess.STDOUT,
            env=verilator().environment(with_runtime),
            check=False,
        ).returncode
    if status:
        raise _build_error(what, log)


def _build_error(what: str, log: Path) -> InputError:
    """Return an error with the first error line of a build's log."""
    lines = log.read_text(errors="replace").splitlines() if log.exists() else []
    wanted = (line for line in lines if "rror" in line or "not found" in line)
    first = next(wanted, lines[-1] if lines else "no log")
    return InputError(f"{what}: build failed: {first.strip()} (log: {log})")


def _runtime(*flags: str) -> Path:
    """Return Verilator's own library, compiled once with these flags: it is most of a small build."""
    environment = verilator().environment()
    answer = subprocess.run(
        [str(verilator().executable), "--getenv", "VERILATOR_ROOT"],
        capture_output=True, text=True, check=True, env=environment,
    )  # fmt: skip
    include = Path(answer.stdout.strip()) / "include"
    sources = [include / f"{name}.cpp" for name in _RUNTIME]
    key = content_hash(sources, str(verilator()), target(cxx()), *flags)
    folder = BUILD / "runtime" / key[:12]
    command = [
        cxx(), "-std=c++20", "-fPIC", "-pthread", *flags, f"-I{include}", f"-I{include / 'vltstd'}",
        "-DVERILATOR=1", "-DVM_COVERAGE=0", "-DVM_SC=0", "-DVM_TRACE=0", "-faligned-new", "-c",
    ]  # fmt: skip

    def make(partial: Path) -> None:
        objects = [partial / f"{source.stem}.o" for source in sources]
        for source, compiled in zip(sources, objects, strict=True):
            run_tool([*command, str(source), "-o", str(compiled)], partial, "Verilator's library")
        run_tool(["ar", "rc", str(partial / "libruntime.a"), *map(str, objects)], partial, "libruntime.a")

    return built(folder, make) / "libruntime.a"


def _library(
    name: str,
    top: str,
    prefix: str,
    parameters: Mapping[str, int],
    harness: Path,
    defines: Sequence[str],
    dut: Path = DUT,
    above: Sequence[Path] = (),
    traced: bool = False,
) -> Path:
    """Return a shared library of a Verilated module and its C++ harness, built where needed.

    ``above``: files that compile after those of the core, control files of Verilator among them. ``traced``:
    it follows its own switching activity; see traced.cpp.
    """
    command = [
        "--cc", "--exe", "--build", "-j", "2", "--no-public-flat-rw", *_SPEED,
        "--top-module", top, "--prefix", prefix,
        *(f"-G{parameter}={value}" for parameter, value in parameters.items()),
        f"-I{dut / 'core'}",
        "-CFLAGS", " ".join([_FAST_CODE, "-fPIC", *defines]), *(_TRACED if traced else ()),
    ]  # fmt: skip
    compiled = harness.with_name("traced.cpp") if traced else harness
    sources = [*rtl_sources(dut), *above, compiled]
    # The folder of the RTL stands for its contents, wherever it is.
    arguments = [argument for argument in command if argument != f"-I{dut / 'core'}"]
    hashed = [*sources, *([harness] if traced else []), *core_files(dut)]
    key = content_hash(hashed, str(verilator()), target(cxx()), *arguments)
    name = f"{name}_traced" if traced else name
    folder = BUILD / "library" / f"{name}-{key[:12]}"
    file = f"lib{prefix}.so"

    def make(partial: Path) -> None:
        print(f"building {name} (once) ..", file=sys.stderr, flush=True)
        output = ["--Mdir", str(partial / "obj"), "-o", str(partial / file)]
        # Verilator's own library, as it is compiled once for all, has no traces.
        linked = ["-LDFLAGS", "-shared" if traced else f"-shared {_runtime(*_FAST_RUNTIME)}"]
        command_line = [str(verilator().executable), *command, *linked, *output, *map(str, sources)]
        run_tool(command_line, partial, name, with_runtime=traced)

    return built(folder, make) / file


def library(configuration: Configuration, dut: Path = DUT, traced: bool = False) -> Path:
    """Return the shared library of the core in that configuration; see core_engine.py.

    ``dut`` may be another folder of RTL with the same files: mutants and faults. ``traced``: it follows its
    own switching activity.
    """
    defines = [
        f"-DWIDTH={configuration.width}",
        f"-DMARGIN_BITS={configuration.margin_bits}",
        f"-DTAG_BITS={configuration.tag_bits}",
    ]
    harness = Path(__file__).with_name("core_harness.cpp")
    name, parameters = configuration.name, configuration.parameters
    return _library(name, "triaxis_core", "Vcore", parameters, harness, defines, dut, traced=traced)


def mesh_library(configuration: MeshConfiguration, dut: Path = DUT, traced: bool = False) -> Path:
    """Return the shared library of the mesh engine; see mesh_engine.py. ``dut``, ``traced``: as `library`."""
    defines = [
        f"-DWIDTH={configuration.width}",
        f"-DMARGIN_BITS={configuration.margin_bits}",
        f"-DINDEX_BITS={configuration.index_bits}",
        *(["-DTRACED_MESH"] if traced else []),
    ]
    harness = Path(__file__).with_name("mesh_harness.cpp")
    above = [*mesh_sources(dut), harness.with_name("mesh_public.vlt")]
    name, parameters = f"mesh_{configuration.name}", configuration.parameters
    return _library(name, "triaxis_mesh", "Vmesh", parameters, harness, defines, dut, above, traced)


def board_library(parameters: BoardParameters, rtl: Path = DUT / "board") -> Path:
    """Return the shared library of the whole board; see simulated_board.py.

    ``rtl``: another folder with the board's files.
    """
    harness = Path(__file__).with_name("board_harness.cpp")
    above = [*mesh_sources(), *board_sources(rtl)]
    defines = [f"-DCLOCKS_PER_BIT={parameters.clocks_per_bit}"]
    return _library(parameters.name, "nexys4ddr_top", "Vboard", parameters.rtl, harness, defines, above=above)


def safety_library(rtl: Path = DUT / "board") -> Path:
    """Return the shared library of the board's safety module; see verif/board/safety.py."""
    harness = VERIF / "board" / "safety.cpp"
    above = [*mesh_sources(), rtl / "triaxis_safety.sv"]
    return _library("safety", "triaxis_safety", "Vsafety", {}, harness, [], above=above)


def detector_library(width: int, dut: Path = DUT) -> Path:
    """Return the shared library of the wrapper CollisionDetector; see detector.py. ``dut``: as `library`."""
    harness = Path(__file__).with_name("detector.cpp")
    return _library(f"detector_w{width}", "CollisionDetector", "Vdetector", {"W": width}, harness, [], dut)


def simulation(configuration: Configuration, dut: Path = DUT) -> Path:
    """Return the folder of the simulator executable for cocotb, built where needed.

    ``dut`` may be another folder of RTL with the same files: mutants and faults.
    """
    sva = VERIF / "core" / "sva"
    sources = [
        sva / "public.vlt",
        *rtl_sources(dut),
        *sorted(sva.glob("*.sv")),
    ]
    return cocotb_build(configuration.name, "triaxis_core", sources, configuration.parameters, dut)


def cocotb_build(
    name: str, top: str, sources: Sequence[Path], parameters: Mapping[str, int], dut: Path = DUT
) -> Path:
    """Return the folder of the simulator executable of a top level for cocotb, built where needed."""
    from cocotb_tools.runner import get_runner

    # The simulator is not the bottleneck under Python: compile quickly.
    arguments = [
        "--no-public-flat-rw", "--assert", "--x-assign", "fast", "--x-initial", "fast",
        "-CFLAGS", "-O0 -std=c++20", "-Wno-fatal",
    ]  # fmt: skip
    runtime = _runtime("-O1")
    key = content_hash([*sources, *core_files(dut)], str(verilator()), target(cxx()), *arguments)
    folder = BUILD / "simulation" / f"{name}-{key[:12]}"

    def make(partial: Path) -> None:
        runner = get_runner("verilator")
        # cocotb takes the tools from its own environment. Always the same values, so threads that build
        # at the same time do not disturb each other.
        os.environ.update(verilator().environment(with_runtime=False))
        try:
            runner.build(
                sources=list(sources),
                includes=[dut / "core"],
                hdl_toplevel=top,
                parameters=dict(parameters),
                build_dir=partial,
                build_args=[*arguments, "-LDFLAGS", str(runtime)],
                timescale=("1ns", "1ps"),
                always=True,
                log_file=partial / "build.log",
            )
        except (SystemExit, RuntimeError, subprocess.CalledProcessError) as error:
            raise _build_error(name, partial / "build.log") from error

    return built(folder, make)


def burst_simulation(configuration: Configuration, dut: Path = DUT, assertions: bool = True) -> Path:
    """Return the folder of the simulator executable for bursts, built where needed.

    ``dut`` may be another folder of RTL with the same files: mutants and faults. ``assertions``: with
    the checks of verif/core/sva/.
    """
    from cocotb_tools.config import libs_dir

    burst, sva = VERIF / "core" / "burst", VERIF / "core" / "sva"
    sources = [
        burst / "burst_tb.vlt",
        *rtl_sources(dut),
        *sorted(burst.glob("*.sv")),
        *(sorted(sva.glob("*.sv")) if assertions else ()),
        *sorted(burst.glob("*.cpp")),
    ]
    defines = [
        f"-DWIDTH={configuration.width}",
        f"-DMARGIN_BITS={configuration.margin_bits}",
        f"-DTAG_BITS={configuration.tag_bits}",
        f"-DPERIOD_PS={1000 * PERIOD_NS}",
    ]
    libraries = f"-rdynamic -Wl,-rpath,{libs_dir} -L{libs_dir} -lcocotbvpi_verilator"
    command = [
        "--cc", "--exe", "--build", "-j", "2", "--vpi", "--no-public-flat-rw", *_SPEED,
        "--assert" if assertions else "--no-assert", "-Wno-fatal", "--timescale", "1ns/1ps",
        "--top-module", _BURST_TOP, "--prefix", "Vtop",
        *(f"-G{name}={value}" for name, value in configuration.parameters.items()),
        "-CFLAGS", " ".join([_FAST_CODE, *_FAST_RUNTIME[1:], f"-I{burst}", *defines]),
    ]  # fmt: skip
    hashed = [*sources, *sorted(burst.glob("*.h")), *core_files(dut)]
    key = content_hash(hashed, str(verilator()), target(cxx()), *command)
    kind = "" if assertions else "_no_assertions"
    folder = BUILD / "burst" / f"{configuration.name}{kind}-{key[:12]}"

    def make(partial: Path) -> None:
        # cocotb's runner looks for an executable of the top module's name.
        output = ["--Mdir", str(partial / "obj"), "-o", str(partial / _BURST_TOP)]
        places = [f"-I{dut / 'core'}", "-LDFLAGS", f"{_runtime(*_FAST_RUNTIME)} {libraries}"]
        command_line = [str(verilator().executable), *command, *places, *output, *map(str, sources)]
        run_tool(command_line, partial, f"{configuration.name} for bursts", with_runtime=False)

    return built(folder, make)
