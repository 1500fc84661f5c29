"""The theorem behind the core, checked by Coq: from the distance to the 32 axes, and what rounding costs.

The list of axes is no part of the theory in theorem/: it is written out from the polynomials that the proofs
of the RTL compare the core with, which are the golden package's list.
"""

import re
import shutil
import subprocess
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.outputs import make_folder
from triaxis.sim.programs import run_limited
from triaxis.verif.formal.definition import Polynomial, axes
from triaxis.verif.formal.proof import Finding, Proof

THEORY = Path(__file__).with_name("theorem")
_COMPILER = "coqc"
_OLDEST = (8, 16)
_INSTALL = "install Coq 8.16 or newer (Debian: apt-get install coq)"

_LIBRARY = "Triaxis"
_AXES, _REPORT = "Axes", "Report"
# Each imports some of those before it.
_FILES = ("Geometry", "Separation", "Descent", _AXES, "Exactness", "Rounding")

THEOREMS = (
    "near_exactly", "further_apart_exactly", "distance_exists", "there_are_32", "separated_is_not_near",
    "nothing_is_missed", "false_alarms_are_in_a_band", "width_of_the_band", "near_after_translation",
    "euclidean_is_not_less",
)  # fmt: skip

# What Coq's library of real numbers takes for granted: they are no more constructed than in a textbook.
AXIOMS = frozenset(
    {
        "ClassicalDedekindReals.sig_forall_dec",
        "FunctionalExtensionality.functional_extensionality_dep",
    }
)

_VERTICES = ("First", "Second", "Third")


@dataclass(frozen=True)
class Theorem:
    """A theorem as Coq states it, and the axioms that its proof rests on."""

    name: str
    statement: str
    axioms: tuple[str, ...]

    @property
    def assumed(self) -> list[str]:
        """Return what it rests on beside the library's axioms: lemmas without a proof count as such."""
        return [axiom for axiom in self.axioms if axiom not in AXIOMS]


def installed() -> bool:
    """Return whether Coq is there, whether or not it works."""
    return shutil.which(_COMPILER) is not None


def coq_version() -> str:
    """Return what Coq calls itself; raise InputError where it is absent, does not start, or is too old."""
    if not installed():
        raise InputError(f"{_COMPILER}: not found: {_INSTALL}")
    answer = subprocess.run([_COMPILER, "--version"], capture_output=True, text=True, check=False)
    found = re.search(r"version (\d+)\.(\d+)", answer.stdout)
    if answer.returncode or found is None:
        raise InputError(f"{_COMPILER}: does not start (exit status {answer.returncode}): {_INSTALL}")
    if (int(found[1]), int(found[2])) < _OLDEST:
        raise InputError(f"{_COMPILER}: version {found[1]}.{found[2]} is too old: {_INSTALL}")
    return answer.stdout.splitlines()[0]


def axes_source() -> str:
    """Return the list of axes as Coq reads it."""
    vectors = ["Vector " + " ".join(f"({_term(part)})" for part in axis.vector) for axis in axes()]
    listed = ";\n    ".join(vectors)
    return (
        "From Triaxis Require Import Geometry.\n\n"
        f"Definition axes (A B : triangle) : list vector :=\n  [ {listed} ].\n"
    )


def _term(polynomial: Polynomial) -> str:
    terms = [
        f"({factor}) * {' * '.join(map(_coordinate, monomial)) or '1'}"
        for monomial, factor in sorted(polynomial.terms)
    ]
    return " + ".join(terms) or "0"


def _coordinate(number: int) -> str:
    triangle, place = divmod(number, 9)
    return f"{'xyz'[place % 3]} ({'AB'[triangle]} {_VERTICES[place // 3]})"


def check(folder: Path, theory: Path = THEORY, axes_text: str | None = None) -> list[Theorem]:
    """Have Coq check the theory in ``folder``, which takes its files; return the theorems.

    ``axes_text``: another list of axes. Raises ProofError where a proof fails, InputError where Coq is not
    installed or a limit against hanging ended it.
    """
    coq_version()
    if folder.exists():
        shutil.rmtree(folder)
    make_folder(folder)
    for path in theory.glob("*.v"):
        shutil.copy(path, folder)
    (folder / f"{_AXES}.v").write_text(axes_text or axes_source(), encoding="utf-8")
    (folder / f"{_REPORT}.v").write_text(_report(), encoding="utf-8")
    for name in _FILES:
        # Assumptions are known by their names, which a module of ours could borrow.
        if re.search(r"\bModule\b", (folder / f"{name}.v").read_text(encoding="utf-8")):
            raise ProofError(f"{name}.v: declares a module: what it assumes could pass for the library's")
    for name in (*_FILES, _REPORT):
        log = folder / f"{name}.log"
        if run_limited([_COMPILER, "-q", "-Q", ".", _LIBRARY, f"{name}.v"], log, folder):
            raise ProofError(f"{_first_error(log)} (log: {log})")
    return [Theorem(name, _statement(folder, name), tuple(_axioms(folder, name))) for name in THEOREMS]


class ProofError(Exception):
    """Coq does not accept a proof."""


def _report() -> str:
    imports = f"From {_LIBRARY} Require Import {' '.join(_FILES)}.\nSet Printing Width 100.\n"
    asked = ((f"{name}.statement", f"Check {name}") for name in THEOREMS)
    rests = ((f"{name}.assumptions", f"Print Assumptions {name}") for name in THEOREMS)
    return imports + "".join(f'Redirect "{file}" {command}.\n' for file, command in (*asked, *rests))


def _first_error(log: Path) -> str:
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    where = next((line for line in lines if line.startswith("File ")), f"{log.stem}.v")
    rest = lines[lines.index(where) + 1 :] if where in lines else lines
    return f"{where} {' '.join(line.strip() for line in rest)[:300]}"


def _statement(folder: Path, name: str) -> str:
    text = (folder / f"{name}.statement.out").read_text(encoding="utf-8")
    return " ".join(text.split()).removeprefix(f"{name} : ")


def _axioms(folder: Path, name: str) -> Iterator[str]:
    lines = (folder / f"{name}.assumptions.out").read_text(encoding="utf-8").splitlines()
    if not lines:
        raise ProofError(f"{name}: Coq says nothing of its assumptions")
    if lines[0].startswith("Closed under"):
        return
    for line in lines[1:]:
        # The type of an axiom is indented where it does not fit its line.
        if found := re.match(r"(\S+)", line):
            yield found[1]


@dataclass(frozen=True)
class TheoremProof(Proof):
    """The theory as one of the proofs; it is not measured where Coq is not installed."""

    def attempt(self, dut: Path, folder: Path) -> Finding:
        """Check all theorems; see `Proof`."""
        if not installed():
            return Finding(absent=f"{_COMPILER} is not installed: {_INSTALL}")
        try:
            theorems = check(folder)
        except ProofError as error:
            return Finding((f"{self.name}: {error}",), folder)
        return Finding(tuple(problems(theorems)), folder, _facts(theorems))


def problems(theorems: Sequence[Theorem]) -> list[str]:
    """Return which theorems rest on more than the library's axioms, a line each."""
    return [f"{one.name}: rests on {', '.join(one.assumed)}" for one in theorems if one.assumed]


def _facts(theorems: Sequence[Theorem]) -> dict[str, object]:
    return {
        "axes": len(axes()), "theorems": len(theorems), "stated": [asdict(theorem) for theorem in theorems]
    }  # fmt: skip


def theorem() -> TheoremProof:
    """Return the proof."""
    return TheoremProof(
        "theorem",
        "Two triangles are near, by points within the margin in each coordinate, exactly where none of the "
        "32 axes separates them, for all real coordinates, margins from 0 and degenerate triangles; "
        "rounded to a grid with the margin of docs/theory.md, section 6, nothing is missed, and false alarms "
        "are in its band.",
        "Coq, from the definition of the distance",
        {},
        ("the axioms of Coq's real numbers",),
    )
