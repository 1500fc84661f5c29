"""Builds of mutated cores as shared libraries.

Compiled here and not by Verilator's make files: without optimising, with one precompiled header for all and
the model as one file, a build of a mutant takes three seconds, most of it g++'s.
"""

import re
import subprocess
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.paths import ROOT
from triaxis.sim.programs import EndedError, run_limited
from triaxis.sim.toolchain import verilator
from triaxis.verif.mutation.folder import FOLDER, temporary
from triaxis.verif.mutation.targets import EXACT_CORE, AnyTarget, EngineTarget

_SOURCES = Path(__file__).parent
_RUNTIME = ("verilated", "verilated_dpi", "verilated_vpi", "verilated_threads")
_DEFINES = (
    "-DVERILATOR=1", "-DVM_COVERAGE=0", "-DVM_SC=0", "-DVM_TRACE=0", "-DVM_TRACE_FST=0", "-DVM_TRACE_VCD=0",
    "-DVM_TRACE_SAIF=0", "-DVL_TIME_CONTEXT", "-DVL_USER_FATAL",
)  # fmt: skip
# Mutants are played for milliseconds each: compiling costs more than running, unless it is millions of pairs.
QUICK, MANY, FAST = "-O0", "-O1", "-O2"


def _include() -> Path:
    answer = subprocess.run(
        [str(verilator().executable), "--getenv", "VERILATOR_ROOT"],
        capture_output=True, text=True, check=True, env=verilator().environment(),
    )  # fmt: skip
    return Path(answer.stdout.strip()) / "include"


def _flags(optimise: str) -> list[str]:
    include = _include()
    return [
        cxx(), "-std=c++20", "-fPIC", "-pthread", "-w", optimise, "-faligned-new", *_DEFINES,
        f"-I{include}", f"-I{include / 'vltstd'}", f"-I{_SOURCES}",
    ]  # fmt: skip


def support(optimise: str) -> Path:
    """Return the folder of Verilator's library and its precompiled header, made once."""
    sources = [*(_include() / f"{name}.cpp" for name in _RUNTIME), _SOURCES / "fatal.cpp"]
    flags = _flags(optimise)
    key = content_hash(sources, str(verilator()), target(cxx()), optimise, *_DEFINES)
    what = "Verilator's library for mutants"

    def make(partial: Path) -> None:
        header = partial / "model.h"
        header.write_text("#include <verilated.h>\n")
        run_tool([*flags, "-x", "c++-header", str(header), "-o", f"{header}.gch"], partial, what)
        for source in sources:
            run_tool([*flags, "-c", str(source), "-o", str(partial / f"{source.stem}.o")], partial, what)
        objects = [str(partial / f"{source.stem}.o") for source in sources]
        run_tool(["ar", "rc", str(partial / "libsupport.a"), *objects], partial, what)

    return built(FOLDER / f"support-{key[:12]}", make)


def _exact_checker() -> Path:
    """Return the checker of golden/ as the stand-in for the core's data path asks it, compiled once."""
    source = EXACT_CORE / "exact_core.cpp"
    golden = sorted([*(ROOT / "golden").glob("*.h"), *(ROOT / "golden").glob("*.cpp")])
    flags = [*_flags(FAST), "-march=native", f"-I{ROOT / 'golden'}"]
    key = content_hash([source, *golden], str(verilator()), target(cxx()), FAST)

    def make(partial: Path) -> None:
        run_tool([*flags, "-c", str(source), "-o", str(partial / "exact_core.o")], partial, source.name)

    return built(FOLDER / f"exact-{key[:12]}", make) / "exact_core.o"


class ElaborationError(Exception):
    """Verilator refuses the mutated RTL."""


def _verilate(
    target_: AnyTarget,
    dut: Path,
    folder: Path,
    extra: Sequence[Path],
    more: Sequence[str],
    assertions: bool = False,
) -> None:
    checked = map(str, target_.assertions if assertions else ())
    command = [
        str(verilator().executable), "--cc", "--no-public-flat-rw", "--x-assign", "fast",
        "--x-initial", "fast",
        # A mutant may look odd: only errors count. What does not settle is found out when it runs.
        "-Wno-lint", "-Wno-UNOPTFLAT", "-Wno-fatal", "--top-module", target_.top, "--prefix", "Vmutant",
        *(f"-G{name}={value}" for name, value in target_.parameters.items()), f"-I{dut / 'core'}", *more,
        "--Mdir", str(folder), *map(str, extra), *map(str, target_.sources(dut)), *checked,
    ]  # fmt: skip
    log = folder / "verilator.log"
    try:
        status = run_limited(command, log, environment=verilator().environment(False))
    except EndedError as error:
        raise EndedError(f"{target_.name}: {error}") from error
    if status:
        raise _refusal(status, log.read_text(errors="replace"), dut, target_.name)


def _refusal(status: int, errors: str, dut: Path, what: str) -> ElaborationError | InputError:
    """Return why Verilator failed: at a place in that RTL, or else for a reason that says nothing of it."""
    place = re.compile(rf"%Error(-[A-Z0-9]+)?: {re.escape(str(dut))}/[^:]+:\d+")
    lines = [line for line in errors.splitlines() if line.startswith("%Error")]
    refused = next((line for line in lines if place.match(line)), None)
    if status == 1 and refused and "No space left" not in errors:
        return ElaborationError(refused)
    said = (lines or errors.strip().splitlines() or ["no message"])[0]
    return InputError(f"{what}: Verilator ends with {status}, not for an error in the RTL: {said}")


def _defines(target_: AnyTarget, selectable: bool) -> list[str]:
    chosen = ["-DSELECTABLE", '-DTRIAXIS_MODEL_SELECTION="Vmutant_triaxis_mutant.h"'] if selectable else []
    return [*target_.defines, *chosen]


def _compile(target_: AnyTarget, folder: Path, optimise: str, selectable: bool, jobs: int) -> Path:
    """Compile what Verilator wrote, with the harness, into a shared library."""
    made = support(optimise)
    flags = [
        *_flags(optimise),
        "-include",
        str(made / "model.h"),
        f"-I{folder}",
        *_defines(target_, selectable),
    ]
    units = sorted(folder.glob("Vmutant*.cpp"))
    if jobs == 1:
        whole = folder / "whole.cc"
        parts = [*units, _SOURCES / target_.harness]
        whole.write_text("".join(f'#include "{unit}"\n' for unit in parts))
        units = [whole]
    else:
        units = [*sorted(units, key=lambda unit: -unit.stat().st_size), _SOURCES / target_.harness]

    def compiled(unit: Path) -> str:
        output = folder / f"{unit.stem}.o"
        run_tool([*flags, "-c", str(unit), "-o", str(output)], folder, target_.name)
        return str(output)

    with ThreadPoolExecutor(jobs) as pool:
        objects = list(pool.map(compiled, units))
    library = folder / "libmutant.so"
    checker = [str(_exact_checker())] if isinstance(target_, EngineTarget) and target_.exact_core else []
    linked = [*objects, *checker, str(made / "libsupport.a")]
    run_tool([cxx(), "-shared", "-o", str(library), *linked], folder, target_.name)
    for object_ in objects:
        Path(object_).unlink()
    return library


def schema_library(target_: AnyTarget, dut: Path, extra: Path, jobs: int) -> Path:
    """Return the library of a copy of dut/ that holds mutants, with the assertions of verif/core/sva/.

    ``dut``: the copy; ``extra``: what it needs beside the files of dut/. Raises InputError where it does not
    build: the generator's fault, not a mutant's.
    """
    sources = [*target_.depends_on(dut), *target_.assertions, *_harness_files()]
    key = content_hash(sources, str(verilator()), target(cxx()), target_.name, MANY)

    def make(partial: Path) -> None:
        more = ["--assert", "--output-split", "8000"]
        try:
            _verilate(target_, dut, partial, [extra], more, True)
        except ElaborationError as error:
            raise InputError(f"{target_.name}, with mutants: {error} (log: {partial})") from error
        _compile(target_, partial, MANY, True, jobs)

    return built(FOLDER / f"schema-{target_.name}-{key[:12]}", make) / "libmutant.so"


def _harness_files() -> list[Path]:
    return [Path(__file__), *sorted(_SOURCES.glob("*.cpp")), *sorted(_SOURCES.glob("*.h"))]


def _elaborate(target_: AnyTarget, dut: Path, folder: Path, assertions: bool) -> str:
    """Verilate into a folder; return a hash of what came of it, in which folders have no part."""
    checked = "--assert" if assertions and target_.assertions else "--no-assert"
    _verilate(target_, dut, folder, [], [checked, "--output-split", "0"], assertions)
    files = sorted([*folder.glob("Vmutant*.cpp"), *folder.glob("Vmutant*.h")])
    return content_hash((), *(file.read_text().replace(str(dut), "") for file in files))


def elaboration_hash(target_: AnyTarget, dut: Path, assertions: bool) -> str:
    """Return a hash of the model that Verilator makes of some RTL: the same for RTL that does the same."""
    with temporary("mutant-") as folder:
        return _elaborate(target_, dut, folder, assertions)


def with_mutant_library(
    target_: AnyTarget,
    dut: Path,
    use: Callable[[Path], None],
    assertions: bool = False,
    optimise: str = QUICK,
    unless: str = "",
) -> None:
    """Build one mutated copy of dut/, and call ``use`` with its library, which is then removed.

    ``assertions``: with those of the environment. ``unless``: the `elaboration_hash` of a model that need not
    be built. Raises ElaborationError where Verilator refuses the RTL, InputError where it fails otherwise.
    """
    with temporary("mutant-") as folder:
        if _elaborate(target_, dut, folder, assertions) != unless:
            use(_compile(target_, folder, optimise, False, 1))
