"""What the outcome of a simulation follows from: the RTL and the code that drives and checks it."""

from pathlib import Path

from triaxis.sim.build import content_hash, rtl_hash
from triaxis.sim.paths import ROOT
from triaxis.sim.toolchain import verilator

# What a simulation loads, and no more: a change of a report or of the command line voids no results. Kept
# cases are left out, so that a failing run, which adds one, does not void what passed before it.
FOLDERS = (
    "golden",
    "sim",
    "coverage",
    "verif/testbench",
    "verif/core",
    "verif/core/burst",
    "verif/core/stimulus",
    "verif/core/sva",
    "verif/counterexample",
    "verif/mesh",
    "verif/mesh/sva",
)
_SOURCES = (".py", ".cpp", ".h", ".sv", ".vlt", ".csv")


def source_files() -> list[Path]:
    """Return the files of the environment that a simulation may load."""
    return sorted(path for folder in FOLDERS for path in (ROOT / folder).iterdir() if path.suffix in _SOURCES)


def identity() -> str:
    """Return the hash that results are valid for: RTL, environment, Verilator."""
    return content_hash(source_files(), rtl_hash(), str(verilator()))[:16]
