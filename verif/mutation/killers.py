"""What decides a mutant's fate beside the RTL: a result is of today's where none of it has changed."""

from pathlib import Path

from triaxis.verif.build import content_hash
from triaxis.verif.mutation.latencies import latency_section
from triaxis.verif.paths import ROOT, VERIF
from triaxis.verif.toolchain import verilator

_PATTERNS = (
    (VERIF / "mutation", ("*.py", "*.cpp", "*.h", "*.toml")),
    (VERIF / "mutation" / "exact_core", ("*.sv", "*.cpp")),
    (VERIF / "sequences", ("*.py",)),
    (VERIF / "sva", ("*.sv", "*.vlt")),
    (VERIF / "sva" / "mesh", ("*.sv", "*.vlt")),
    (VERIF / "mesh", ("configuration.py", "engine.py", "expectation.py")),
    (VERIF / "regressions", ("*.json",)),
    (VERIF / "formal", ("engine_proofs.py", "sby_proof.py")),
    (VERIF / "formal" / "rtl", ("*.sv",)),
    (VERIF, ("*.py",)),
    (ROOT / "golden", ("*.py", "*.cpp", "*.h")),
)


def killers() -> list[Path]:
    """Return the files that generate, play, judge and excuse mutants, in a fixed order."""
    return [
        path
        for folder, patterns in _PATTERNS
        for pattern in patterns
        for path in sorted(folder.glob(pattern))
    ]


def killers_hash() -> str:
    """Return the hash of these files, of the README's latencies, and of Verilator's version."""
    return content_hash(killers(), latency_section(), str(verilator()))
