"""Folders of broken RTL: copies of dut/ with one fault each, kept in build/faults/.

A fault is a unified diff, applied by its text alone and never by guessing. Line numbers do not count, so the
RTL may move. What a hunk replaces must stand in the file exactly once.
"""

import re
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.build import built, rtl_files
from triaxis.sim.paths import BUILD, DUT
from triaxis.verif.faults.known_faults import Fault

_TARGET = re.compile(r"\+\+\+ b/dut/(\S+)")


@dataclass(frozen=True)
class Hunk:
    """One change: in that file, ``old`` becomes ``new``; both with the lines around them."""

    file: str
    old: str
    new: str


def read_hunks(path: Path) -> list[Hunk]:
    """Read a unified diff of files in dut/; raise InputError where it is none, or changes nothing."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror or error}") from error
    hunks: list[Hunk] = []
    file, old, new = "", "", ""
    for line in [*lines, "@@"]:
        target = _TARGET.match(line)
        # A header or the end closes the hunk before it.
        if line.startswith(("@@", "---", "+++")) and old + new:
            hunks.append(Hunk(file, old, new))
            old, new = "", ""
        if target:
            file = target[1]
        elif line[0] in " \n":
            old, new = old + line[1:] if line[0] == " " else old + line, new + line.removeprefix(" ")
        elif line[0] == "-" and not line.startswith("---"):
            old += line[1:]
        elif line[0] == "+" and not line.startswith("+++"):
            new += line[1:]
    if not hunks or any(not hunk.file or hunk.old == hunk.new for hunk in hunks):
        raise InputError(f"{path}: not a unified diff that changes files of dut/")
    return hunks


def apply_patch(path: Path, dut: Path) -> None:
    """Change the RTL in a folder as a diff says.

    Raises InputError where what a hunk replaces is not there exactly once: the RTL has changed.
    """
    for hunk in read_hunks(path):
        target = dut / hunk.file
        text = target.read_text(encoding="utf-8") if target.is_file() else ""
        if (found := text.count(hunk.old)) != 1:
            raise InputError(
                f"{path.name}: what it replaces in {hunk.file} is there {found} times, must be once: the "
                "RTL has changed, adapt the fault"
            )
        target.write_text(text.replace(hunk.old, hunk.new), encoding="utf-8")


FOLDER = BUILD / "faults"


def faulty_rtl(fault: Fault, dut: Path = DUT) -> Path:
    """Return a folder with the files of ``dut`` and the fault in them, made where needed.

    Raises InputError where the fault is not one of the RTL, or the RTL is no longer what its diff changes.
    """
    if fault.patch is None:
        raise InputError(f"fault {fault.name}: is tried on the environment; there is no RTL of it")
    if not fault.patch.is_file():
        raise InputError(f"{fault.patch}: cannot read: no such file")
    return patched_rtl(FOLDER / fault.name, [fault.patch], dut)


def patched_rtl(place: Path, patches: Sequence[Path], dut: Path = DUT) -> Path:
    """Return a folder with the files of ``dut``, changed by diffs one after the other, made where needed.

    Its name is that of ``place`` and a hash of what it is made from.
    """

    def make(partial: Path) -> None:
        for source in rtl_files(dut):
            target = partial / source.relative_to(dut)
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
        for patch in patches:
            apply_patch(patch, partial)

    return built(place, [*patches, *rtl_files(dut)], (), make)
