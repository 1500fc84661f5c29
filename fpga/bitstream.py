"""A bitstream by Vivado, and its manifest: what it was built from, on whose sign-off, what was measured."""

import hashlib
import json
import os
import re
import shutil
import signal
import subprocess
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from triaxis.fpga.board_build import BUILD_SCRIPT, CONSTRAINTS, PART, TOP, VIVADO, Inputs
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.sim.build import content_hash
from triaxis.sim.paths import BUILD

# The switching activity that `triaxis fpga activity` measures, and what power reports read of it.
ACTIVITY = BUILD / "fpga" / "activity.json"
SAIF = BUILD / "fpga" / "activity.saif"

# What build.tcl announces, without the stages that are not always there.
STAGES = ("synthesis", "optimisation", "placement", "routing", "reports", "bitstream", "done")

_REFUSED = 3
_SAYS = re.compile(r"triaxis: (stage|refused|figure): (.*)")


class RefusedError(RuntimeError):
    """Vivado worked, and the result must not be used: timing, routing, critical warnings."""


@dataclass(frozen=True)
class VivadoResult:
    """A bitstream, and the figures of build.tcl by name."""

    bitstream: Path
    figures: Mapping[str, float]


def find_vivado() -> Path:
    """Return Vivado's executable; raise InputError where there is none."""
    found = shutil.which("vivado")
    if found is None:
        raise InputError(
            "vivado: not on PATH: install Vivado (2020.1 or newer; the free edition builds for XC7A100T) "
            "and source its settings64.sh"
        )
    return Path(found)


def _options(inputs: Inputs, out: Path) -> str:
    """Return the options of build.tcl, a line each: a list of arguments would not survive all launchers."""
    options = [
        ("part", PART),
        ("top", TOP),
        *(("source", path) for path in inputs.sources),
        *(("include", path) for path in inputs.include),
        ("xdc", CONSTRAINTS),
        *(("generic", f"{name}={value}") for name, value in inputs.generics.items()),
        ("out", out),
    ]
    if inputs.activity:
        options += [("saif", inputs.activity), ("saif_strip", TOP)]
    return "".join(f"{name}={value}\n" for name, value in options)


def run_vivado(
    vivado: Path, inputs: Inputs, out: Path, progress: Callable[[int], None] | None = None
) -> VivadoResult:
    """Build a bitstream into ``out``; ``progress`` is told of each of `STAGES` that begins.

    Raises RefusedError where the result is refused, InputError where Vivado fails or leaves no bitstream.
    """
    out.mkdir(parents=True, exist_ok=True)
    log, bitstream = out / "vivado.log", out / f"{TOP}.bit"
    bitstream.unlink(missing_ok=True)
    options = write_whole(out / "options.txt", _options(inputs, out))
    command = [
        str(vivado), "-mode", "batch", "-notrace", "-nojournal", "-log", str(out / "vivado_session.log"),
        "-source", str(BUILD_SCRIPT), "-tclargs", str(options),
    ]  # fmt: skip
    refused, figures, status = _watch(command, out, log, progress)
    if status == _REFUSED:
        raise RefusedError(refused or f"refused without a reason (log: {log})")
    if status or not bitstream.is_file() or not bitstream.stat().st_size:
        raise InputError(f"vivado: {_reason(log, status)} (log: {log})")
    return VivadoResult(bitstream, figures)


def _watch(
    command: list[str], out: Path, log: Path, progress: Callable[[int], None] | None
) -> tuple[str | None, dict[str, float], int]:
    """Run Vivado with its output in ``log``; return why build.tcl refused, its figures, the exit status."""
    refused: str | None = None
    figures: dict[str, float] = {}
    environment = {**os.environ, "LC_ALL": "C"}
    with (
        log.open("w", encoding="utf-8") as output,
        subprocess.Popen(
            command, cwd=out, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL, text=True, errors="replace", start_new_session=True,
        ) as process,
    ):  # fmt: skip
        assert process.stdout
        try:
            for line in process.stdout:
                output.write(line)
                said = _SAYS.match(line)
                if said is None:
                    continue
                if said[1] == "refused":
                    refused = said[2]
                elif said[1] == "figure":
                    name, _, value = said[2].partition(" ")
                    figures[name] = float(value)
                elif said[2] in STAGES and progress:
                    progress(1)
        except BaseException:
            # Vivado is a script that starts others: all of them, or they go on for hours.
            os.killpg(process.pid, signal.SIGKILL)
            raise
    return refused, figures, process.returncode


def _reason(log: Path, status: int) -> str:
    """Return the first error in the log."""
    text = log.read_text(encoding="utf-8", errors="replace")
    error = re.search(r"^(?:ERROR|CRITICAL WARNING: \[Common).*$", text, re.MULTILINE)
    if error:
        return error[0].strip()
    return f"no bitstream, exit status {status}"


_SUFFIXES, _OF_CORES = (".xdc", ".tcl"), "package_ip.tcl"


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
    """Return the hash of what surrounds the RTL of dut/: constraints and scripts."""
    files = (path for path in VIVADO.rglob("*") if path.suffix in _SUFFIXES and path.name != _OF_CORES)
    return content_hash(sorted(files))


def build_id(rtl_hash: str, board_hash: str) -> int:
    """Return the 32 bits by which a board tells what it was built from: all but its parameters."""
    return int(hashlib.sha256(f"{rtl_hash}{board_hash}".encode()).hexdigest()[:8], 16)


def remove_bitstream(*bitstreams: Path) -> None:
    """Remove bitstreams and their manifests: none is left that was not allowed in the end."""
    for bitstream in bitstreams:
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
