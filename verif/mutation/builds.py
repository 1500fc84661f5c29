"""Libraries of RTL that holds mutants: with all, one of which is selected by its number, or one by itself."""

import os
import re
import shutil
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import replace
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.models import asserted
from triaxis.sim.paths import BUILD, ROOT
from triaxis.sim.programs import EndedError, run_limited
from triaxis.sim.toolchain import verilator
from triaxis.sim.verilate import (
    FAST,
    MANY,
    PREFIX,
    QUICK,
    Build,
    compile_model,
    compiler,
    library,
    verilate_command,
)
from triaxis.verif.mutation.targets import EXACT_CORE, AnyTarget, BoardTarget, EngineTarget

FOLDER = BUILD / "mutation"
_WORK = "work-"


@contextmanager
def temporary() -> Iterator[Path]:
    """Provide a folder that is removed afterwards; its name has the number of this process in it."""
    FOLDER.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=FOLDER, prefix=f"{_WORK}{os.getpid()}-") as name:
        yield Path(name)


def sweep(folder: Path = FOLDER) -> None:
    """Remove what processes left that are no more."""
    for path in folder.glob(f"{_WORK}*"):
        try:
            os.kill(int(path.name.split("-")[1]), 0)
        except ProcessLookupError:
            shutil.rmtree(path, ignore_errors=True)
        except (PermissionError, ValueError):
            continue


class ElaborationError(Exception):
    """Verilator refuses the mutated RTL."""


def _exact_checker(build: Build) -> Path:
    """Return the checker of golden/ as the stand-in for the core's data path asks it, compiled once."""
    source, golden = EXACT_CORE / "exact_core.cpp", ROOT / "golden"
    files = [source, *sorted([*golden.glob("*.h"), *golden.glob("*.cpp")])]

    def make(partial: Path) -> None:
        output = partial / "exact_core.o"
        command = [*compiler(build, FAST), f"-I{golden}", "-c", str(source), "-o", str(output)]
        run_tool(command, partial, source.name)

    return built(FOLDER / "exact", files, (str(verilator()), target(cxx())), make) / "exact_core.o"


def _build(target_: AnyTarget, dut: Path, assertions: bool) -> Build:
    """Return the build of one mutated copy of dut/, or of one with all: the assertions compile last."""
    build = target_.build(dut)
    if isinstance(target_, EngineTarget) and target_.exact_core:
        build = replace(build, objects=(_exact_checker(build),))
    return asserted(build) if assertions and not target_.combinational else build


def schema_library(target_: AnyTarget, dut: Path, extra: Path, jobs: int, assertions: bool = True) -> Path:
    """Return the library of a copy of dut/ that holds mutants, with the environment's assertions.

    ``dut``: the copy; ``extra``: what it needs beside the files of dut/. Raises InputError where it does not
    build: the generator's fault, not a mutant's.
    """
    # A board's tests run for seconds.
    speed = FAST if isinstance(target_, BoardTarget) else MANY
    build = replace(_build(target_, dut, assertions), selectable=True, speed=speed, split=8000)
    return library(replace(build, sources=(extra, *build.sources)), jobs)


def _elaborate(build: Build, folder: Path) -> str:
    """Verilate into a folder; return a hash of what came of it, in which folders have no part."""
    log = folder / "verilator.log"
    try:
        status = run_limited(verilate_command(build, folder), log, environment=verilator().environment())
    except EndedError as error:
        raise EndedError(f"{build.name}: {error}") from error
    if status:
        raise _refusal(status, log.read_text(errors="replace"), build.dut, build.name)
    files = sorted([*folder.glob(f"{PREFIX}*.cpp"), *folder.glob(f"{PREFIX}*.h")])
    return content_hash((), *(file.read_text().replace(str(build.dut), "") for file in files))


def _refusal(status: int, errors: str, dut: Path, what: str) -> ElaborationError | InputError:
    """Return why Verilator failed: at a place in that RTL, or else for a reason that says nothing of it."""
    place = re.compile(rf"%Error(-[A-Z0-9]+)?: {re.escape(str(dut))}/[^:]+:\d+")
    lines = [line for line in errors.splitlines() if line.startswith("%Error")]
    refused = next((line for line in lines if place.match(line)), None)
    if status == 1 and refused and "No space left" not in errors:
        return ElaborationError(refused)
    said = (lines or errors.strip().splitlines() or ["no message"])[0]
    return InputError(f"{what}: Verilator ends with {status}, not for an error in the RTL: {said}")


def elaboration_hash(target_: AnyTarget, dut: Path, assertions: bool) -> str:
    """Return a hash of the model that Verilator makes of some RTL: the same for RTL that does the same."""
    with temporary() as folder:
        return _elaborate(replace(_build(target_, dut, assertions), split=0), folder)


def mutant_library(
    target_: AnyTarget, dut: Path, folder: Path, assertions: bool = False, unless: str = "",
    speed: str = QUICK,
) -> Path | None:  # fmt: skip
    """Build one mutated copy of dut/ in a folder; None where its model's `elaboration_hash` is ``unless``.

    ``assertions``: with those of the environment; ``speed``: of the code. Raises ElaborationError where
    Verilator refuses the RTL, InputError where it fails otherwise.
    """
    folder.mkdir()
    build = replace(_build(target_, dut, assertions), split=0, speed=speed)
    if _elaborate(build, folder) == unless:
        return None
    made = compile_model(build, folder, folder, 1)
    # Thousands of models: only the library is needed.
    for path in folder.glob(f"{PREFIX}*"):
        with suppress(OSError):
            path.unlink()
    return made
