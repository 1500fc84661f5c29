"""The synthesised design against the RTL: what differs is seen, in a run and in a proof."""

import re
from dataclasses import replace
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Validity
from triaxis.verif.formal.proof import Finding, Outcome, Result
from triaxis.verif.netlist import result as netlist_result
from triaxis.verif.netlist.gates import (
    NOT_SIMULATED,
    SCOPES,
    Scope,
    cells,
    models_of,
    run_on_gates,
    synthesised,
)
from triaxis.verif.netlist.module_proofs import NOT_PROVED, PROOFS, ModuleProof
from triaxis.verif.netlist.result import GateRun, NetlistResult, gate_run, left_out, write_result
from triaxis.verif.signoff.plan import plan
from triaxis.verif.testbench.simulation import RunResult, model_of

_SMALL = Scope("MixedTest", "w8_m0", 2000)


def _proof(module: str) -> ModuleProof:
    return next(proof for proof in PROOFS if proof.name == f"triaxis_{module}")


def _inverted(text: str) -> str:
    """Return a netlist in which the first look-up table says the opposite."""
    found = re.search(r"LUT\d #\(\s*\.INIT\(\d+'h([0-9a-f]+)\)", text)
    assert found
    right = found[1]
    wrong = f"{int(right, 16) ^ (1 << 4 * len(right)) - 1:0{len(right)}x}"
    return text[: found.start(1)] + wrong + text[found.end(1) :]


def test_every_module_is_proved_or_named_with_a_reason():
    modules = {
        found
        for path in DUT.glob("*/*.sv")
        for found in re.findall(r"^module (\w+)", path.read_text(), re.MULTILINE)
    }
    proved = [proof.name for proof in PROOFS]
    assert sorted([*proved, *NOT_PROVED]) == sorted(modules)


def test_what_is_neither_checked_nor_named_fails():
    proved, simulated = [proof.name for proof in PROOFS], [scope.config for scope in SCOPES]
    assert left_out(proved, simulated) == []
    why = "nor named with the reason why not"
    silent = left_out(proved[1:], simulated[1:])
    assert silent == [
        f"{proved[0]}: neither proved, {why}", f"{simulated[0]}: neither simulated as a netlist, {why}"
    ]  # fmt: skip
    result = replace(_DONE, silent=silent)
    assert result.problems == silent and not result.passed


def test_every_signed_configuration_is_simulated_as_a_netlist_or_named_with_a_reason():
    signed = {run.config for run in plan(1)}
    simulated = [scope.config for scope in SCOPES]
    assert sorted([*simulated, *NOT_SIMULATED]) == sorted(signed)
    assert all(reason.startswith(("size: ", "time: ")) for reason in NOT_SIMULATED.values())


@pytest.mark.prover
@pytest.mark.synthesiser
@pytest.mark.parametrize("module", ["narrow_mul", "fifo", "slip_rx"])
def test_a_module_is_equal_to_its_netlist_and_not_to_another(tmp_path, module):
    proof = _proof(module)
    proof.synthesise(DUT, tmp_path)
    assert proof.compare(tmp_path).result is Result.PROVED
    gate = tmp_path / "gate.v"
    gate.write_text(_inverted(gate.read_text()))
    finding = proof.compare(tmp_path)
    assert finding.result is Result.FAILED and proof.name in finding.problems[0]


@pytest.mark.regress
def test_a_changed_cell_is_seen_in_a_run_on_a_netlist_that_is_given(tmp_path):
    build = model_of(_SMALL.settings(1))
    assert build
    netlist = synthesised(build)
    right = gate_run(_SMALL, run_on_gates(_SMALL, 1, netlist, cells()))
    assert (right.told, right.differences) == ((), 0) and (right.pairs or 0) >= _SMALL.pairs
    broken = tmp_path / "broken.v"
    broken.write_text(_inverted(netlist.read_text()))
    wrong = gate_run(_SMALL, run_on_gates(_SMALL, 1, broken, cells()))
    assert wrong.told and wrong.differences


def test_a_folder_of_models_gives_those_that_the_netlist_names(tmp_path):
    netlist, folder = tmp_path / "netlist.v", tmp_path / "unisims"
    netlist.write_text("module m; LUT6 #(.INIT(64'h0)) \\a (.O(o)); FDRE b (.Q(q)); endmodule")
    folder.mkdir()
    for name in ("LUT6", "FDRE", "RAMB36E1"):
        (folder / f"{name}.v").touch()
    assert [path.stem for path in models_of(netlist, folder)] == ["FDRE", "LUT6"]
    assert models_of(netlist, folder / "LUT6.v") == [folder / "LUT6.v"]
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no model of a cell"):
        models_of(netlist, tmp_path / "empty")


_CLEAN = GateRun("MixedTest", "w16_m0", 100, 0, ())
_DONE = NetlistResult(
    (_CLEAN,), (Outcome(PROOFS[0], Finding(), 1.0),), 1, 2.0, Validity("of the RTL", "of the tests", "5.048")
)


def _ran(passed: bool, counts: dict[str, int] | None) -> RunResult:
    return RunResult(_SMALL.settings(1), passed, 1.0, counts, () if passed else ("wrong",), Path("log"))


@pytest.mark.parametrize(
    ("passed", "counts", "good"),
    [
        (True, {"checked": 2000, "failed": 0}, True),
        (True, {"checked": 1999, "failed": 0}, False),
        (False, {"checked": 2000, "failed": 3}, False),
        (False, None, False),
    ],
)
def test_a_run_counts_where_it_checked_all_that_it_should(passed, counts, good):
    run = gate_run(_SMALL, _ran(passed, counts))
    assert (not run.told) == good
    assert replace(_DONE, runs=(run,)).passed == good
    assert run.differences == (counts or {}).get("failed")


def test_all_runs_and_proofs_count_and_each_is_told_of_its_own(tmp_path, monkeypatch):
    def run_on_gates(scope, _):
        return replace(_ran(scope is not SCOPES[2], {"checked": scope.pairs}), settings=scope.settings(1))

    failed = Outcome(PROOFS[3], Finding(("it differs",)), 1.0)
    for name, one in {
        "require_tools": list, "FOLDER": tmp_path, "run_on_gates": run_on_gates,
        "outcome_of": lambda proof, *_: failed if proof is PROOFS[3] else Outcome(proof, Finding(), 1.0),
    }.items():  # fmt: skip
        monkeypatch.setattr(netlist_result, name, one)
    steps: list[int] = []
    found = netlist_result.check_all(1, steps.append)
    assert [run.config for run in found.runs if run.told] == [SCOPES[2].config] and failed in found.outcomes
    assert len(found.runs) + len(found.outcomes) == len(steps) == len(SCOPES) + len(PROOFS)


def test_what_differs_is_undecided_or_absent_fails(tmp_path):
    assert _DONE.passed and (_DONE.pairs, _DONE.differences) == (100, 0)
    failed = Outcome(PROOFS[0], Finding(("it differs",)), 1.0)
    undecided = Outcome(PROOFS[0], Finding(undecided=("no end",)), 1.0)
    for outcomes in ((failed,), (undecided,), ()):
        assert not replace(_DONE, outcomes=outcomes).passed
    assert not replace(_DONE, changed=True).passed
    assert replace(_DONE, runs=(replace(_CLEAN, differences=None),)).differences is None


@pytest.mark.synthesiser
def test_the_file_says_what_it_is_of(tmp_path):
    evidence = read_evidence(write_result(_DONE, "netlist", tmp_path / "netlist.json"))
    assert evidence and evidence["passed"] and evidence["differences"] == 0
    assert sum(module["proved"] for module in evidence["modules"]) == evidence["modules_proved"] == 1
    assert evidence["not_simulated"] == NOT_SIMULATED
    failed = replace(_DONE, outcomes=(Outcome(PROOFS[0], Finding(("it differs",)), 1.0),))
    assert (failed.modules_proved, _DONE.modules_proved) == (0, 1)
    assert (evidence["rtl_hash"], evidence["environment_hash"]) == ("of the RTL", "of the tests")
