"""The theorem holds for the golden package's axes alone, and nothing in it is taken on trust unseen."""

import re
import shutil

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.sim.validity import provenance
from triaxis.verif.formal import coq
from triaxis.verif.formal.proof import Outcome, Result
from triaxis.verif.formal.proving import SOURCES, FormalResult

needs_coq = pytest.mark.skipif(not coq.installed(), reason="Coq is not installed: apt-get install coq")


def swapped(source: str, first: int, second: int) -> str:
    vectors = re.findall(r"Vector [^;\]]*[^;\] ]", source)
    one, other = vectors[first], vectors[second]
    return source.replace(one, "?").replace(other, one).replace("?", other)


@needs_coq
@pytest.mark.prover
@pytest.mark.parametrize(
    "axes",
    [
        # Edge x edge without its last term, and two axes each at the other's number.
        coq.axes_source().replace("(1) * y (A First) * z (B First) + ", "", 1),
        swapped(coq.axes_source(), 5, 6),
    ],
)
def test_another_list_of_axes_is_refused(tmp_path, axes):
    assert axes != coq.axes_source()
    with pytest.raises(coq.ProofError, match=r"Exactness\.v"):
        coq.check(tmp_path / "proof", axes_text=axes)


@needs_coq
@pytest.mark.prover
def test_a_lemma_without_a_proof_is_an_assumption(tmp_path):
    theory = shutil.copytree(coq.THEORY, tmp_path / "theory")
    path = theory / "Rounding.v"
    text = path.read_text()
    start = text.index("Proof.", text.index("Lemma chebyshev_triangle"))
    path.write_text(text[:start] + "Admitted.\n" + text[text.index("Qed.", start) + 4 :])
    theorems = coq.check(tmp_path / "proof", theory)
    assert [one.name for one in theorems] == list(coq.THEOREMS)
    assert theorems[0].statement == (
        "forall (A B : triangle) (m : R), 0 <= m -> near A B m <-> ~ some_axis_separates A B m"
    )
    # What does not use it stands.
    said = coq.problems(theorems)
    assert "nothing_is_missed: rests on chebyshev_triangle" in said
    assert not any("near_exactly" in line for line in said)


@needs_coq
@pytest.mark.prover
def test_an_axiom_under_a_name_of_the_library_is_refused(tmp_path):
    theory = shutil.copytree(coq.THEORY, tmp_path / "theory")
    path = theory / "Rounding.v"
    module = "Module ClassicalDedekindReals. Axiom sig_forall_dec : 1 = 0. End ClassicalDedekindReals.\n"
    path.write_text(path.read_text() + module)
    with pytest.raises(coq.ProofError, match=r"Rounding\.v: declares a module"):
        coq.check(tmp_path / "proof", theory)


@pytest.mark.parametrize(
    ("answer", "message"), [("exit 1", "does not start"), ("echo version 8.9.1", "too old")]
)
def test_a_coq_that_does_not_work_decides_nothing(tmp_path, monkeypatch, answer, message):
    broken = tmp_path / "coqc"
    broken.write_text(f"#!/bin/sh\n{answer}\n")
    broken.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=":")
    finding = coq.theorem().prove(DUT, tmp_path / "proof")
    assert finding.result is Result.UNDECIDED
    assert message in finding.undecided[0]


def test_without_coq_it_is_an_exception_and_no_proof(tmp_path, monkeypatch):
    here = provenance(SOURCES)
    monkeypatch.setattr(coq.shutil, "which", lambda _: None)
    finding = coq.theorem().prove(DUT, tmp_path)
    assert finding.result is Result.ABSENT
    outcomes = (Outcome(coq.theorem(), finding, 0.0),)
    result = FormalResult(outcomes, complete=True, seconds=0.0, valid_for=here)
    assert not result.passed and not result.problems
    assert result.exceptions == [f"theorem: not measured: coqc is not installed: {coq._INSTALL}"]
    with pytest.raises(InputError, match="install Coq"):
        coq.check(tmp_path / "proof")
