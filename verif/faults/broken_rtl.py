"""Folders of broken RTL: copies of dut/ with one fault each, kept in build/faults/."""

import shutil
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.build import built, content_hash, rtl_files, rtl_hash
from triaxis.sim.paths import BUILD, DUT
from triaxis.verif.faults.catalogue import Fault
from triaxis.verif.faults.patching import apply_patch

FOLDER = BUILD / "faults"


def faulty_rtl(fault: Fault, dut: Path = DUT) -> Path:
    """Return a folder with the files of ``dut`` and the fault in them, made where needed.

    Raises InputError where the fault is not one of the RTL, or the RTL is no longer what its diff changes.
    """
    if fault.patch is None:
        raise InputError(f"fault {fault.name}: is tried on the environment; there is no RTL of it")
    if not fault.patch.is_file():
        raise InputError(f"{fault.patch}: cannot read: no such file")
    patch = fault.patch
    key = content_hash([patch], rtl_hash(dut))

    def make(partial: Path) -> None:
        for source in rtl_files(dut):
            place = partial / source.relative_to(dut)
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, place)
        apply_patch(patch, partial)

    return built(FOLDER / f"{fault.name}-{key[:12]}", make)
