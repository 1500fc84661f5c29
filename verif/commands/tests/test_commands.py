"""Commands of the environment as their users meet them: results, exit codes, one-line errors."""

import os
import re
from pathlib import Path
from typing import Any

import pytest
from filelock import FileLock

from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.configuration import Configuration
from triaxis.sim.validity import Provenance
from triaxis.verif.commands import fpga, prove, regress, signoff
from triaxis.verif.core.failing_pairs import read_failing
from triaxis.verif.core.kept_cases import read_case
from triaxis.verif.formal.proof import Finding, Outcome
from triaxis.verif.formal.proving import FormalResult
from triaxis.verif.netlist.gates import models_of
from triaxis.verif.netlist.module_proofs import PROOFS
from triaxis.verif.netlist.result import GateRun, NetlistResult
from triaxis.verif.regress import four_state
from triaxis.verif.regress.definition import read_definition
from triaxis.verif.regress.four_state import FourStateResult
from triaxis.verif.results.database import add_evidence
from triaxis.verif.signoff.gate import refusals
from triaxis.verif.testbench import simulation

READERS = {
    "failing pairs": lambda path: read_failing(path, Configuration(16, 0)),
    "definition of regressions": read_definition,
    "regression case": read_case,
    "sign-off": lambda path: refusals(path, "", ""),
    "results of other machines": lambda path: add_evidence(path, path.parent / "results.sqlite"),
    "netlist": lambda path: models_of(path, path.parent),
    "models of cells": lambda path: models_of(Path(__file__), path),
}


@pytest.mark.parametrize("reader", READERS)
def test_only_ordinary_files_are_read(tmp_path, reader):
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(InputError, match=rf"^{tmp_path}/pipe: is a pipe[^\n]*: name an ordinary file$"):
        READERS[reader](tmp_path / "pipe")


def test_no_older_signoff_outlives_one_that_is_refused(tmp_path, monkeypatch, capsys):
    for name in ("RESULT", "PAGE"):
        monkeypatch.setattr(signoff, name, tmp_path / name)
        (tmp_path / name).write_text("passed")
    assert main(["signoff", "--pairs", "5"]) == 2
    assert "must be at least 1000" in capsys.readouterr().err
    assert not any((tmp_path / name).exists() for name in ("RESULT", "PAGE"))


def test_one_sign_off_at_a_time_of_a_checkout(tmp_path, monkeypatch, capsys):
    for name in ("RESULT", "PAGE"):
        monkeypatch.setattr(signoff, name, tmp_path / name)
    monkeypatch.setattr(signoff, "step_count", lambda *_: pytest.fail("a second one begins"))
    (tmp_path / "RESULT").write_text("of the one that runs")
    with FileLock(tmp_path / "RESULT.lock"):
        assert main(["signoff"]) == 2
    assert "RESULT.lock: a sign-off of this checkout runs already" in capsys.readouterr().err
    assert (tmp_path / "RESULT").exists()


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (("NoTest",), "unknown; one of: RegressionsTest"),
        (("RandomTest", "--config", "w99"), "must read w<width>_m<margin bits>"),
        (("RandomTest", "--config", "w99_m0"), "8..32"),
        (("RandomTest", "--pairs", "0"), "at least 1"),
        (("RandomTest", "--agent", "burst", "--waves"), "on the pins: say --agent pin"),
        (("ReplayTest",), "goes with ReplayTest"),
        (("ReplayTest", "--replay", "no.npz"), "no.npz: cannot read"),
    ],
)
def test_sim_refuses_bad_arguments(capsys, words, why):
    assert main(["sim", *words]) == 2
    out, error = capsys.readouterr()
    assert (out, error.count("\n")) == ("", 1)
    assert why in error


@pytest.mark.simulator
def test_sim_runs_a_test_by_name(seed, capsys):
    assert main(["sim", "SeedVectorsTest", "--config", "w16_m0", "--seed", str(seed)]) == 0
    out = capsys.readouterr().out
    assert "passed: SeedVectorsTest" in out
    assert "15 pairs checked" in out


@pytest.mark.simulator
def test_what_runs_cover_is_shown(tmp_path, monkeypatch, capsys):
    """Of a test in its own first configuration, and of another's: each in a model of its own."""
    monkeypatch.setattr(simulation, "BUILD", tmp_path)
    assert main(["sim", "CertificatesTest", "--agent", "burst", "--pairs", "60"]) == 0
    assert main(["sim", "RandomTest", "--agent", "burst", "--pairs", "60"]) == 0
    certified, random = sorted((tmp_path / "runs").iterdir())
    assert [run.name for run in (certified, random)] == [
        "CertificatesTest-w8_m8_certified-burst-1", "RandomTest-w16_m0-burst-1",
    ]  # fmt: skip
    assert f"log and coverage: {random}" in capsys.readouterr().out
    page = tmp_path / "page.html"
    assert main(["coverage", "page", str(certified), str(random / "coverage.json"), "--out", str(page)]) == 0
    said, text = capsys.readouterr().out, page.read_text()
    assert "core_w8_m8" in said and "core_w16_m0" in said and said.endswith(f"written to {page}\n")
    assert "core_w8_m8" in text and "core_w16_m0" in text
    for wrong, why in (
        (tmp_path, "no such file: a run that passed leaves it"),
        (random / "scoreboard.json", "not a coverage file"),
        (f"{random}/../{random.name}", f"{random / 'coverage.json'}: named twice"),
    ):
        assert main(["coverage", "page", str(random), str(wrong), "--out", str(page)]) == 2
        assert why in capsys.readouterr().err
    assert not page.exists(), "an old page stands for what was not read"


@pytest.mark.simulator
def test_what_a_test_refuses_is_no_failure(capsys):
    """A core without certificates has none to try: no answer, in one line."""
    assert main(["sim", "CertificatesTest", "--config", "w16_m0", "--agent", "burst", "--pairs", "60"]) == 2
    said = capsys.readouterr().err.splitlines()[-1]
    assert (
        said
        == "triaxis: error: test CertificatesTest: stimulus: w16_m0: only a certified core can try anything"
    )


def test_a_folder_of_runs_that_cannot_be_written_is_told(tmp_path, monkeypatch, capsys):
    (tmp_path / "runs").write_text("")
    monkeypatch.setattr(simulation, "build_for", lambda *_: tmp_path)
    monkeypatch.setattr("triaxis.verif.testbench.simulation.BUILD", tmp_path)
    assert main(["sim", "RandomTest"]) == 2
    assert "cannot make this folder: Not a directory" in capsys.readouterr().err


@pytest.mark.parametrize("words", [("--cells", "unisims"), ("--config", "w16_m0")])
def test_what_is_of_a_netlist_is_refused_without_one(capsys, words):
    assert main(["prove", "netlist", *words]) == 2
    assert f"{words[0]}: give --netlist too" in capsys.readouterr().err


@pytest.mark.parametrize(("told", "code"), [((), 0), (("one differs",), 1)])
def test_the_exit_code_tells_whether_a_given_netlist_differs(monkeypatch, told, code):
    monkeypatch.setattr(prove, "run_on_gates", lambda *_: None)
    run = GateRun("MixedTest", "w16_m0", 100_000, len(told), told)
    monkeypatch.setattr(prove.netlists, "gate_run", lambda *_: run)
    assert main(["prove", "netlist", "--netlist", "core.v"]) == code


HERE = Provenance("a" * 64, "b" * 64, "5.048", None, None)
RUN = simulation.run_settings("FarTest", "w16_m0", 1, 9)
COUNTS = {"accepted": 9, "checked": 9, "failed": 0}


def outcomes(wrong):
    return (Outcome(PROOFS[0], Finding(), 1.0), Outcome(PROOFS[0], Finding(wrong), 1.0))


# What finds the result of a command, and a result: of which nothing, or something, is wrong.
RESULTS: dict[str, Any] = {
    "prove formal --proof x": (
        prove.proving, "prove_all", lambda wrong: FormalResult(outcomes(wrong), False, 1.0, HERE)
    ),
    "prove theorem": (prove.coq, "check", lambda wrong: [prove.coq.Theorem("near", "it is", wrong)]),
    "prove netlist": (
        prove.netlists, "check_all",
        lambda wrong: NetlistResult((GateRun("T", "w8", 9, 0, wrong),), outcomes(wrong), 1, 1.0, HERE),
    ),
    "regress four-state": (
        regress, "run_four_state",
        lambda wrong: FourStateResult(
            (simulation.RunResult(RUN, not wrong, 1.0, COUNTS, wrong, Path("log")),), HERE, False, 1.0
        ),
    ),
    "fpga gate": (fpga, "refusals", list),
}  # fmt: skip


@pytest.mark.parametrize("wrong", [(), ("one differs",)])
@pytest.mark.parametrize("words", RESULTS)
def test_the_exit_code_is_that_of_the_result_and_what_is_wrong_is_told(monkeypatch, capsys, words, wrong):
    module, finds, result = RESULTS[words]
    for where, name, answer in (
        (module, finds, result(wrong)), (prove.netlists, "write_result", None),
        (prove.coq, "coq_version", None),
        (regress, "write_result", None), (four_state, "_unknown", {"looked": 9, "unknown": 0}),
        (fpga, "remarks", ["signed off as a whole"]),
    ):  # fmt: skip
        monkeypatch.setattr(where, name, lambda *_, answer=answer, **__: answer)
    assert main(words.split()) == (1 if wrong else 0)
    said = "".join(capsys.readouterr())
    assert ("differs" in said) is bool(wrong) and not (wrong and re.search("PASSED|open", said))
