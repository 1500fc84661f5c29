"""One way from RTL to something that runs: Verilator, then the C++ compiler, for every build of the design.

A `Build` says what varies. Verilator's make files are not used: they compile its library and its headers anew
for each model, which is most of a small build.
"""

import re
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import cache
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.golden.processes import threads
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.lanes import write_lanes
from triaxis.sim.paths import BUILD, DUT, SIM
from triaxis.sim.toolchain import verilator

# Verilator's prefix of all models: players know no other name.
PREFIX = "Vtop"
# Of the model's code: what runs for milliseconds costs more to compile than to run.
QUICK, MANY, FAST = "-O0", "-O1", "-O2"

# What a traced build writes.
SAIF, VCD = "saif", "vcd"

COUNTERS = (
    "--coverage-line", "--coverage-toggle", "--coverage-expr", "--coverage-user",
    # Signals of any width: Verilator leaves out those above 256 bits otherwise, and does not say so.
    "--coverage-max-width", "65536",
    # Without it, an instance of a module that is not inlined shares the counters of the first one.
    "--flatten",
)  # fmt: skip
# Older ones count toggles without their direction.
_OLDEST_WITH_COUNTERS = (5, 48)

_RUNTIME, _FOR_COCOTB = ("verilated", "verilated_threads"), ("verilated_dpi", "verilated_vpi")
_CONTROL = ".vlt"
# A library may be loaded into a program that has a model of the same name in it.
_SHARED = ("-shared", "-Wl,-Bsymbolic")


class Form(Enum):
    """What is made of a model: a library, or a program for cocotb."""

    LIBRARY = "library"
    PINS = "simulation"


@dataclass(frozen=True)
class Build:
    """A top module with its parameters and its C++, and how it is built.

    ``sources``: RTL and control files of Verilator, in order; ``above``, those that it depends on besides.
    ``cpp``: of the player or the program; ``headers``, what that includes. ``dut``: the folder of the RTL,
    which may be another one with the same files. ``counters``: of line, toggle and expression coverage.
    ``assertions``: those in the sources are checked. ``trace``: it writes what it switches, SAIF,
    or all its waves, VCD.
    ``selectable``: it holds mutants, one of which is selected by its number. ``plain``: with Verilator's own
    arithmetic, not that of arithmetic.h, to compare with. ``speed``: of the model's code. ``split``:
    statements in a C++ file, 0 all in one. ``objects``: compiled already. ``lanes``: of cores in lockstep, 0
    for one core alone; see lanes.py.
    """

    name: str
    top: str
    parameters: Mapping[str, int]
    sources: tuple[Path, ...]
    cpp: tuple[Path, ...]
    above: tuple[Path, ...] = ()
    headers: tuple[Path, ...] = ()
    defines: Mapping[str, int] = field(default_factory=dict)
    dut: Path = DUT
    form: Form = Form.LIBRARY
    counters: bool = False
    assertions: bool = False
    trace: str = ""
    selectable: bool = False
    plain: bool = False
    speed: str = FAST
    split: int | None = None
    objects: tuple[Path, ...] = ()
    lanes: int = 0

    @property
    def kind(self) -> str:
        """Return in a word for each what is special about it, for the names of folders."""
        marks = {
            "covered": self.counters, f"traced_{self.trace}": self.trace, "mutated": self.selectable,
            "plain": self.plain,
            "asserted": self.form is Form.LIBRARY and self.assertions, f"lanes{self.lanes}": self.lanes,
        }  # fmt: skip
        return "_".join([self.name, *(mark for mark, holds in marks.items() if holds)])

    @property
    def initial(self) -> str:
        """Return what Verilator is to do of registers without a reset: let each run choose, or begin with 0.

        What is counted, or differs by a mutant alone, begins with 0; so do cores that are copied, and pins,
        where clocks would begin with anything too, which is an edge.
        """
        alike = self.counters or self.selectable or self.lanes or self.form is Form.PINS
        return "fast" if alike else "unique"

    @property
    def flags(self) -> list[str]:
        """Return the arguments of Verilator, but for those that name files and folders."""
        arguments = [
            # Warnings are for lint: only errors end a build.
            "--cc", "-Wno-lint", "-Wno-UNOPTFLAT", "-Wno-fatal",
            # No signal is public: Verilator's default for cocotb costs most of the speed.
            "--no-public-flat-rw", "--x-assign", "fast", "--x-initial", self.initial, "--prefix", PREFIX,
            "--assert" if self.assertions else "--no-assert",
        ]  # fmt: skip
        if self.speed == FAST:
            arguments.append("-O3")
        if self.lanes:
            arguments.append("--flatten")
        if self.counters:
            arguments += COUNTERS
        elif self.speed == FAST:
            # Functions of moderate length: g++ makes code of the whole core in one function that runs a third
            # slower.
            arguments += ["--output-split-cfuncs", "1000"]
        if self.trace:
            arguments += [f"--trace-{self.trace}", *(["--trace-structs"] if self.trace == VCD else [])]
        if self.split is not None:
            arguments += ["--output-split", str(self.split)]
        if self.form is not Form.LIBRARY:
            arguments += ["--vpi", "--timescale", "1ns/1ps"]
        return arguments

    @property
    def preprocessed(self) -> list[str]:
        """Return the definitions with which C++ is compiled."""
        values = {
            "VERILATOR": 1, "VM_COVERAGE": int(self.counters), "VM_SC": 0,
            "VM_TRACE": int(bool(self.trace)), "VM_TRACE_FST": 0, "VM_TRACE_VCD": int(self.trace == VCD),
            "VM_TRACE_SAIF": int(self.trace == SAIF),
        }  # fmt: skip
        # A library keeps the time itself, and throws what would end the process: see player.h.
        if self.form is Form.LIBRARY:
            values |= {"VL_TIME_CONTEXT": 1, "VL_USER_FATAL": 1}
        return [f"-D{name}={value}" for name, value in values.items()]

    @property
    def files(self) -> list[Path]:
        """Return the files of ours that go in."""
        more = [SIM / "lanes.py"] if self.lanes else []
        return [*self.sources, *self.above, *self.cpp, *self.headers, *_PLAYERS, *self.objects, *more]

    @property
    def hashed(self) -> str:
        """Return a hash of everything that goes in. The folder of the RTL stands for its contents.

        Where cocotb's libraries are is in every program: in a checkout that was moved they are elsewhere.
        """
        return content_hash(
            self.files, str(verilator()), target(cxx()), self.top, *self.flags, *self.preprocessed,
            *_linked(self), self.speed, str(self.plain), str(self.lanes),
            repr(sorted(self.parameters.items())), repr(sorted(self.defines.items())), str(self.selectable),
            # Counters are told by the files that they are of.
            str(self.dut) if self.counters else "",
        )  # fmt: skip


_ARITHMETIC = SIM / "arithmetic.h"
_DEFINES = "defines.h"
# What Verilator read, in its list of files: each with its size and times.
_SOURCE = re.compile(r'^S .*"([^"]*)"$', re.MULTILINE)
_PLAYERS = (SIM / "player.h", _ARITHMETIC, SIM / "counters" / "verilated_cov.h")


def elaboration(top: str, parameters: Mapping[str, int], dut: Path = DUT) -> list[str]:
    """Return the beginning of every command of Verilator: itself, and what it elaborates."""
    return [
        str(verilator().executable), "--top-module", top, f"-I{dut / 'core'}",
        *(f"-G{name}={value}" for name, value in parameters.items()),
    ]  # fmt: skip


def verilate_command(build: Build, folder: Path) -> list[str]:
    """Return the command with which Verilator writes a model's C++ into a folder."""
    first = [source for source in build.sources if source.suffix == _CONTROL]
    rest = [source for source in build.sources if source.suffix != _CONTROL]
    head = elaboration(build.top, build.parameters, build.dut)
    return [*head, *build.flags, "--Mdir", str(folder), *map(str, [*first, *rest])]


def verilate(build: Build, jobs: int = 2) -> Path:
    """Return the folder with the library or the program, built where needed; see `product`."""
    if build.counters and verilator().version < _OLDEST_WITH_COUNTERS:
        raise InputError(
            f"code coverage: Verilator {verilator()}: 5.048 or newer is needed; unset VERILATOR to use the "
            "package index's"
        )

    def make(partial: Path) -> None:
        print(f"building {build.kind} (once) ..", file=sys.stderr, flush=True)
        (partial / "obj").mkdir()
        run_tool(verilate_command(build, partial / "obj"), partial, build.kind)
        _check_read(build, partial / "obj")
        compile_model(build, partial / "obj", partial, jobs)

    return built(BUILD / build.form.value / build.kind, build.files, (build.hashed,), make)


def _check_read(build: Build, model: Path) -> None:
    """Raise InputError where Verilator read a file that the name of a build does not change with."""
    listed = (model / f"{PREFIX}__verFiles.dat").read_text(encoding="utf-8")
    root, known = _include().parent.resolve(), {file.resolve() for file in build.files}
    for name in _SOURCE.findall(listed):
        path = Path(name).resolve()
        if path not in known and not path.is_relative_to(root):
            raise InputError(
                f"{build.kind}: build failed: {path} is read, and must be a file of RTL in {build.dut}"
            )


def product(build: Build) -> str:
    """Return the name of the file that a build is for. cocotb's runner looks for that of the top module."""
    return "libtop.so" if build.form is Form.LIBRARY else build.top


def library(build: Build, jobs: int = 2) -> Path:
    """Return the shared library of a build, built where needed."""
    return verilate(build, jobs) / product(build)


def described(build: Build) -> Path:
    """Return the file in which Verilator describes the elaborated design (JSON)."""
    build = replace(build, counters=False, cpp=(), headers=())

    def make(partial: Path) -> None:
        command = verilate_command(build, partial)
        command[command.index("--cc")] = "--json-only"
        run_tool(command, partial, f"{build.kind}, elaboration")

    settings = (build.hashed, str(build.dut))
    return built(BUILD / "elaborated" / build.name, build.files, settings, make) / f"{PREFIX}.tree.json"


@cache
def _include() -> Path:
    answer = subprocess.run(
        [str(verilator().executable), "--getenv", "VERILATOR_ROOT"],
        capture_output=True, text=True, check=True, env=verilator().environment(),
    )  # fmt: skip
    return Path(answer.stdout.strip()) / "include"


def compiler(build: Build, speed: str) -> list[str]:
    """Return the C++ compiler with all flags for a build's sources, but for those of the model itself."""
    include = _include()
    counting = [f"-I{SIM / 'counters'}"] if build.counters else []
    position = ["-fPIC", "-fno-gnu-unique"] if build.form is Form.LIBRARY else []
    return [
        cxx(), "-std=c++20", "-pthread", "-march=native", "-w", "-faligned-new", speed, *position,
        *build.preprocessed, *counting, f"-I{include}", f"-I{include / 'vltstd'}", f"-I{SIM}",
    ]  # fmt: skip


def runtime(build: Build) -> Path:
    """Return Verilator's own library, compiled once for all models of a kind: it is most of a small build."""
    names = [*_RUNTIME]
    if build.form is not Form.LIBRARY:
        names += _FOR_COCOTB
    if build.counters:
        names.append("verilated_cov")
    if build.trace:
        names.append(f"verilated_{build.trace}_c")
    sources = [_include() / f"{name}.cpp" for name in names]
    command = compiler(build, FAST)
    settings = (str(verilator()), target(cxx()), *_without_folders(command))

    def make(partial: Path) -> None:
        objects = [partial / f"{source.stem}.o" for source in sources]
        for source, compiled in zip(sources, objects, strict=True):
            run_tool([*command, "-c", str(source), "-o", str(compiled)], partial, "Verilator's library")
        run_tool(["ar", "rc", str(partial / "libruntime.a"), *map(str, objects)], partial, "libruntime.a")

    return built(BUILD / "runtime" / "verilator", sources, settings, make) / "libruntime.a"


def _headers(build: Build, speed: str) -> Path:
    """Return what every model includes, compiled once for all of one kind and speed."""
    command = compiler(build, speed)
    # Inlined arithmetic is more to compile, and without optimisation no faster.
    included = "verilated.h" if build.plain or speed == QUICK else _ARITHMETIC.name
    settings = (included, str(verilator()), target(cxx()), *_without_folders(command))

    def make(partial: Path) -> None:
        header = partial / "model.h"
        header.write_text(f"#include <{included}>\n")
        run_tool([*command, "-x", "c++-header", str(header), "-o", f"{header}.gch"], partial, "headers")

    return built(BUILD / "runtime" / "headers", [_ARITHMETIC], settings, make) / "model.h"


def _player(build: Build, model: Path) -> Path:
    """Return the player of a quick build, compiled once for all models that look the same to it.

    Of a model it sees the top's header, or all of them where its sources name one of the others.
    """
    sources = (*build.cpp, *build.headers)
    named = any(f"{PREFIX}_" in file.read_text(encoding="utf-8") for file in sources)
    seen = sorted(model.glob(f"{PREFIX}*.h" if named else f"{PREFIX}.h"))
    files = [*seen, model / _DEFINES, *sources, *_PLAYERS]
    settings = (str(verilator()), target(cxx()), *_without_folders(compiler(build, QUICK)))

    def make(partial: Path) -> None:
        whole = partial / "player.cc"
        whole.write_text("".join(f'#include "{unit}"\n' for unit in build.cpp))
        command = unit_command(build, model, QUICK)
        run_tool([*command, "-c", str(whole), "-o", str(partial / "player.o")], partial, build.kind)

    return built(BUILD / "runtime" / "player", files, settings, make) / "player.o"


def unit_command(build: Build, model: Path, speed: str) -> list[str]:
    """Return the compiler with all flags for a unit of a model.

    What is compiled already comes first, and is of the same speed: a compiler takes it in no other place, nor
    after a macro of a name that is in it, and reads Verilator's headers anew without a word, for a second.
    """
    folders = [model, *sorted({path.parent for path in build.headers})]
    return [
        *compiler(build, speed), "-include", str(_headers(build, speed)), "-include", str(model / _DEFINES),
        *(f"-I{place}" for place in folders),
    ]  # fmt: skip


def _without_folders(command: Sequence[str]) -> list[str]:
    return [argument for argument in command if not argument.startswith("-I")]


def compile_model(build: Build, model: Path, folder: Path, jobs: int) -> Path:
    """Compile what Verilator wrote to ``model``, with the player, into a library or program in ``folder``."""
    verilated = runtime(build)
    if build.lanes:
        write_lanes(model, build.lanes)
    defines = {**build.defines, **({"SELECTABLE": 1} if build.selectable else {})}
    (model / _DEFINES).write_text("".join(f"#define {name} {value}\n" for name, value in defines.items()))
    units = sorted(model.glob(f"{PREFIX}*.cpp"), key=lambda unit: (-unit.stat().st_size, unit))
    compiled_before = list(build.objects)
    if build.speed == QUICK and not build.selectable and build.cpp:
        compiled_before.append(_player(build, model))
    else:
        units += build.cpp
    # What runs once, at the start, is half of the code; beside lanes, all that is Verilator's.
    quick = [
        unit for unit in units
        if build.speed == QUICK or unit.stem.endswith("__Slow") or (build.lanes and unit.parent == model)
    ]  # fmt: skip
    pieces = [(unit, build.speed) for unit in units if unit not in quick]
    # Few units are quicker than many that include the same.
    for number, share in enumerate(share for start in range(jobs) if (share := quick[start::jobs])):
        whole = model / f"whole{number}.cc"
        whole.write_text("".join(f'#include "{unit}"\n' for unit in share))
        pieces.append((whole, QUICK))

    def compiled(unit: Path, speed: str) -> str:
        output = model / f"{unit.stem}.o"
        command = unit_command(build, model, speed)
        run_tool([*command, "-c", str(unit), "-o", str(output)], folder, build.kind)
        return str(output)

    with threads(jobs) as pool:
        objects = list(pool.map(compiled, *zip(*pieces, strict=True)))
    made = folder / product(build)
    command = [cxx(), "-pthread", "-o", str(made), *objects, *map(str, compiled_before), str(verilated)]
    run_tool([*command, *_linked(build)], folder, build.kind)
    for file in objects:
        Path(file).unlink()
    return made


def _linked(build: Build) -> list[str]:
    if build.form is Form.LIBRARY:
        return list(_SHARED)
    from cocotb_tools.config import libs_dir

    return [f"-Wl,-rpath,{libs_dir}", f"-L{libs_dir}", "-lcocotbvpi_verilator"]
