"""A bitstream and its manifest: what it was built from, on whose sign-off, and what Vivado measured."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from triaxis.fpga.board_build import PART, TOP, TOP_RTL, VIVADO, Inputs
from triaxis.fpga.vivado_run import VivadoResult
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.paths import BUILD

# The switching activity that `triaxis fpga activity` measures, and what power reports read of it.
ACTIVITY = BUILD / "fpga" / "activity.json"
SAIF = BUILD / "fpga" / "activity.saif"

_SUFFIXES = (".xdc", ".tcl")


@dataclass(frozen=True)
class Provenance:
    """What a bitstream stands on: hashes of the RTL signed off and of the board around it, the sign-off."""

    rtl_hash: str
    board_hash: str
    signoff: Path
    signoff_hash: str


def file_hash(path: Path) -> str:
    """Return the SHA-256 of a file; raise InputError where it cannot be read."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError as error:
        raise InputError(f"{path}: cannot read: {error.strerror}") from error


def board_hash() -> str:
    """Return the hash of what surrounds the RTL of dut/: the part's top, constraints, scripts."""
    digest = hashlib.sha256()
    for path in sorted([TOP_RTL, *(path for path in VIVADO.rglob("*") if path.suffix in _SUFFIXES)]):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def build_id(rtl_hash: str, board_hash: str) -> int:
    """Return the 32 bits by which a board tells what it was built from: all that a bitstream holds."""
    return int(hashlib.sha256(f"{rtl_hash}{board_hash}".encode()).hexdigest()[:8], 16)


def remove_bitstream(bitstream: Path) -> None:
    """Remove an older bitstream and its manifest: a build that fails must not leave one behind."""
    for path in (bitstream, manifest_path(bitstream)):
        path.unlink(missing_ok=True)


def manifest_path(bitstream: Path) -> Path:
    """Return where the manifest of a bitstream is."""
    return bitstream.with_suffix(".json")


def write_bitstream(bitstream: Path, built: VivadoResult, inputs: Inputs, provenance: Provenance) -> None:
    """Write a bitstream and its manifest, the manifest first: no bitstream is ever without one."""
    content = built.bitstream.read_bytes()
    manifest: Mapping[str, object] = {
        "bitstream": bitstream.name,
        "sha256": hashlib.sha256(content).hexdigest(),
        "part": PART,
        "top": TOP,
        "parameters": dict(inputs.generics),
        "rtl_hash": provenance.rtl_hash,
        "board_hash": provenance.board_hash,
        "signoff": {"file": str(provenance.signoff), "sha256": provenance.signoff_hash},
        "activity": None if inputs.activity is None else file_hash(inputs.activity),
        "figures": dict(built.figures),
        "reports": str(built.bitstream.parent),
    }
    write_whole(manifest_path(bitstream), json.dumps(manifest, indent=2) + "\n")
    write_whole(bitstream, content)
