"""What is kept in build/ under a name that changes with everything that goes in, and what of dut/ that is."""

import hashlib
import os
import re
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.golden.native import written
from triaxis.golden.outputs import make_folder
from triaxis.sim.paths import DUT
from triaxis.sim.toolchain import verilator

_LISTING = ".f"
# What RTL reads in, on lines that are more than a comment.
_LINE = re.compile(r"^(?!\s*//).*", re.MULTILINE)
_READ = re.compile(r'(?:`include\s+|\$readmem[bh]\s*\(\s*)"([^"]*)"')
_RTL_SUFFIXES = (".sv", ".svh", ".v", ".vh", _LISTING)


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

    Raises InputError where a list, or one of the files, names what is not among them, and where a folder is
    a link: nothing would tell of their changes.
    """
    every = sorted(dut.rglob("*"))
    if links := [path for path in every if path.is_symlink() and path.is_dir()]:
        raise InputError(f"{links[0]}: must be a folder, and not a link to one")
    found = [path for path in every if path.suffix in _RTL_SUFFIXES and path.is_file()]
    places = {Path(os.path.normpath(path)) for path in found}
    for listing in (path for path in found if path.suffix == _LISTING):
        for entry in listing.read_text(encoding="utf-8").split():
            if Path(os.path.normpath(listing.parent / entry)) not in places:
                raise InputError(f"{listing}: {entry}: must be a file of RTL in {dut}")
    names = {path.name for path in found}
    for path in found:
        lines = _LINE.findall(path.read_text(encoding="utf-8"))
        for name in (name for line in lines for name in _READ.findall(line)):
            if name not in names:
                raise InputError(f"{path}: {name}: must be a file of RTL in {dut}")
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


def built(place: Path, files: Sequence[Path], settings: Sequence[str], make: Callable[[Path], None]) -> Path:
    """Return the folder of a name and a hash of all that goes in, after ``make`` has filled it once.

    Whoever else wants it waits. ``make`` works in a folder beside it that is renamed when whole, so an
    interrupted build leaves nothing that looks finished. It reads the files after they were hashed: raises
    InputError where one was written to meanwhile, and keeps nothing.
    """
    before = written(files)
    folder = place.with_name(f"{place.name}-{content_hash(files, *settings)[:12]}")
    make_folder(folder.parent)
    with FileLock(folder.with_name(folder.name + ".lock")):
        if not folder.is_dir():
            partial = folder.with_name(folder.name + ".partial")
            shutil.rmtree(partial, ignore_errors=True)
            make_folder(partial)
            make(partial)
            if written(files) != before:
                shutil.rmtree(partial)
                raise InputError(f"{place.name}: its sources changed while it was built: run again")
            partial.rename(folder)
    return folder


def run_tool(command: Sequence[str], folder: Path, what: str) -> None:
    """Run a build command in a folder; raise InputError with the first error line where it fails.

    In the folder of what is built nothing lies about that a tool would take without being told to.
    """
    log = folder / "build.log"
    with log.open("a") as output:
        status = subprocess.run(
            command,
            cwd=folder,
            stdout=output,
            stderr=subprocess.STDOUT,
            env=verilator().environment(),
            check=False,
        ).returncode
    if status:
        raise build_error(what, log)


def build_error(what: str, log: Path) -> InputError:
    """Return an error with the first error line of a build's log."""
    lines = log.read_text(errors="replace").splitlines() if log.exists() else []
    wanted = (line for line in lines if "rror" in line or "not found" in line)
    first = next(wanted, lines[-1] if lines else "no log")
    return InputError(f"{what}: build failed: {first.strip()} (log: {log})")
