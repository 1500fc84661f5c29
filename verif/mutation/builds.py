"""Builds of mutants: all in one library that holds them, or one by itself; what plays them finds out.

And the folder in build/ where they are made, and what a run that was killed leaves there.
"""

import fcntl
import re
import shutil
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx, target
from triaxis.sim.build import built, content_hash, run_tool
from triaxis.sim.core_engine import CorePlayer
from triaxis.sim.detector import DetectorPlayer
from triaxis.sim.mesh_engine import MeshPlayer
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
from triaxis.verif.mesh.scripts import EnginePlay
from triaxis.verif.mutation.stimulus import Play
from triaxis.verif.mutation.targets import EXACT_CORE, AnyTarget, EngineTarget

FOLDER = BUILD / "mutation"

_PREFIXES = ("dut-", "proof-", "exhaustive-", "mutant-")
# Seconds: a file that is written whole and renamed is younger, and holds no lock.
_YOUNG = 60

# The runs that a model can be found out by.
AnyPlay = Play | EnginePlay


@contextmanager
def temporary(prefix: str) -> Iterator[Path]:
    """Provide a folder that is removed afterwards, and that no `sweep` takes meanwhile."""
    if prefix not in _PREFIXES:
        raise ValueError(f"{prefix}: not one of {', '.join(_PREFIXES)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    with (FOLDER / ".lock").open("w") as file:
        fcntl.flock(file, fcntl.LOCK_SH)
        with tempfile.TemporaryDirectory(dir=FOLDER, prefix=prefix) as name:
            yield Path(name)


def sweep(folder: Path = FOLDER) -> None:
    """Remove what runs left that were killed, unless another run is at work in the folder now."""
    folder.mkdir(parents=True, exist_ok=True)
    before = time.time() - _YOUNG
    with (folder / ".lock").open("w") as file:
        try:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return
        for path in folder.iterdir():
            if _left(path) and path.stat().st_mtime < before:
                _remove(path)


def _left(path: Path) -> bool:
    return path.name.endswith(".partial") or (path.is_dir() and path.name.startswith(_PREFIXES))


def _remove(path: Path) -> None:
    if path.is_dir():
        shutil.rmtree(path, ignore_errors=True)
    else:
        path.unlink(missing_ok=True)


class ElaborationError(Exception):
    """Verilator refuses the mutated RTL."""


def _exact_checker(build: Build) -> Path:
    """Return the checker of golden/ as the stand-in for the core's data path asks it, compiled once."""
    source, golden = EXACT_CORE / "exact_core.cpp", ROOT / "golden"
    files = [source, *sorted([*golden.glob("*.h"), *golden.glob("*.cpp")])]
    key = content_hash(files, str(verilator()), target(cxx()))

    def make(partial: Path) -> None:
        output = partial / "exact_core.o"
        command = [*compiler(build, FAST), f"-I{golden}", "-c", str(source), "-o", str(output)]
        run_tool(command, partial, source.name)

    return built(FOLDER / f"exact-{key[:12]}", make) / "exact_core.o"


def _build(target_: AnyTarget, dut: Path, assertions: bool) -> Build:
    """Return the build of one mutated copy of dut/, or of one with all: the assertions compile last."""
    build = target_.build(dut)
    if isinstance(target_, EngineTarget) and target_.exact_core:
        build = replace(build, objects=(_exact_checker(build),))
    if not (assertions and target_.assertions):
        return build
    return replace(build, assertions=True, sources=(*build.sources, *target_.assertions))


def schema_library(target_: AnyTarget, dut: Path, extra: Path, jobs: int) -> Path:
    """Return the library of a copy of dut/ that holds mutants, with the environment's assertions.

    ``dut``: the copy; ``extra``: what it needs beside the files of dut/. Raises InputError where it does not
    build: the generator's fault, not a mutant's.
    """
    build = replace(_build(target_, dut, True), selectable=True, assertions=True, speed=MANY, split=8000)
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
    with temporary("mutant-") as folder:
        return _elaborate(replace(_build(target_, dut, assertions), split=0), folder)


def with_mutant_library(
    target_: AnyTarget,
    dut: Path,
    use: Callable[["Library"], None],
    assertions: bool = False,
    optimise: str = QUICK,
    unless: str = "",
) -> None:
    """Build one mutated copy of dut/, and call ``use`` with its library, which is then removed.

    ``assertions``: with those of the environment. ``unless``: the `elaboration_hash` of a model that need not
    be built. Raises ElaborationError where Verilator refuses the RTL, InputError where it fails otherwise.
    """
    build = replace(_build(target_, dut, assertions), split=0)
    with temporary("mutant-") as folder:
        if _elaborate(build, folder) != unless:
            loaded = Library(compile_model(replace(build, speed=optimise), folder, folder, 1), target_)
            try:
                use(loaded)
            finally:
                loaded.close()


@dataclass(frozen=True)
class Killed:
    """How a mutant was found out: the test and family, the model, what was wrong, after how many pairs.

    Of the mesh engine, after how many runs.
    """

    test: str
    family: str
    target: str
    symptom: str
    pairs: int


class Library:
    """A shared library of mutants of one target."""

    def __init__(self, path: Path, target_: AnyTarget) -> None:
        """Load it."""
        self.target = target_
        players = {True: MeshPlayer, False: DetectorPlayer if target_.combinational else CorePlayer}
        self._player = players[isinstance(target_, EngineTarget)](path)

    def close(self) -> None:
        """Unload it."""
        self._player.unload()

    def play(self, selected: int, plays: Sequence[AnyPlay]) -> Killed | None:
        """Return how the mutant with that number is found out by the plays in turn; None where it is not."""
        self._player.renew(selected)
        before = 0
        for play in plays:
            symptom, checked = self._one(play)
            before += checked
            if symptom:
                return Killed(play.test, play.family, self.target.name, symptom, before)
        return None

    def _one(self, play: AnyPlay) -> tuple[str, int]:
        if isinstance(play, EnginePlay):
            assert isinstance(self._player, MeshPlayer)
            return self._player.play(play.script)
        if isinstance(self._player, DetectorPlayer):
            return self._player.play(play.inputs, play.collides)[1:]
        assert isinstance(self._player, CorePlayer)
        played = self._player.play(play.sent, play.expected, play.target.configuration.latency)
        return played.symptom, played.checked
