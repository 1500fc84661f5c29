"""The catalogue of faults: its diffs fit, each does what it says, and only what the design does catches one.

That each fault of the replaced design and of the board is caught, and none where there is none, every
sign-off tries.
"""

import os
import re
import shutil
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.build import rtl_files
from triaxis.sim.configuration import parse_configuration
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Provenance
from triaxis.verif.commands import inject as command
from triaxis.verif.core.failing_pairs import Stream
from triaxis.verif.core.kept_cases import FOUND, REGRESSIONS
from triaxis.verif.counterexample.candidates import bit_lengths
from triaxis.verif.counterexample.finding import BareCore, Symptom
from triaxis.verif.faults import environment_faults, result, rtl_faults, runs
from triaxis.verif.faults.catching import catch, catch_all, control
from triaxis.verif.faults.faulty_rtl import apply_patch, faulty_rtl, read_hunks
from triaxis.verif.faults.known_faults import FAULTS, PATCHES, Kind, fault_names, fault_of, faults_of
from triaxis.verif.faults.result import Catch, FaultsResult, Outcome, write_json
from triaxis.verif.faults.runs import Sign, design_sign_of, sign_of
from triaxis.verif.testbench.failures import Blame
from triaxis.verif.testbench.settings import BURST, failure_file
from triaxis.verif.testbench.simulation import RunResult, errors_in, run_settings

ENGINE_CONFIG = fault_of("engine-lane-mask").config
CONFIG = fault_of("F2").config
PATCHED = [fault.name for fault in FAULTS if fault.patch]


@pytest.fixture(autouse=True)
def own_folders(tmp_path, monkeypatch):
    """Let no test disturb another that runs beside it, nor the results of the catalogue."""
    monkeypatch.setattr(runs, "RUNS", tmp_path / "runs")
    monkeypatch.setattr(rtl_faults, "PICTURES", tmp_path / "pictures")
    monkeypatch.setattr(result, "RESULT", tmp_path / "faults.json")


# --- The catalogue ---------------------------------------------------------------------------------


def test_every_fault_of_the_design_is_there():
    named = {name.partition("-")[0] for name in fault_names() if fault_of(name).replaced}
    assert named == {f"F{number}" for number in range(1, 11)}
    with pytest.raises(InputError, match="fault F11: unknown; one of: F1-box"):
        faults_of("F11")


def test_diffs_are_ordinary_ones_of_todays_rtl(tmp_path):
    """As `git apply` reads them, they do the same; each gives RTL of its own."""
    # Else git would look for the repository around, and for its paths.
    alone = {**os.environ, "GIT_CEILING_DIRECTORIES": str(tmp_path)}
    folders = {name: faulty_rtl(fault_of(name)) for name in PATCHED}
    assert len(set(folders.values())) == len(PATCHED)
    for name, ours in folders.items():
        shutil.copytree(DUT, tmp_path / name / "dut")
        patch = ["git", "apply", "--whitespace=nowarn", str(fault_of(name).patch)]
        subprocess.run(patch, cwd=tmp_path / name, check=True, env=alone)
        places = [source.relative_to(DUT) for source in rtl_files()]
        texts = [(tmp_path / name / "dut" / place).read_text() for place in places]
        assert texts == [(ours / place).read_text() for place in places]


def test_changed_rtl_is_noticed(tmp_path):
    """By every fault of that file, before anything is built."""
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    areas = dut / "core/triaxis_areas.sv"
    areas.write_text(areas.read_text().replace("a_sum_1 + a_1[2]", "a_1[2] + a_sum_1"))
    for name in ("F4", "narrow-cross"):
        with pytest.raises(InputError, match=r"triaxis_areas\.sv is there 0 times.*adapt the fault"):
            catch_all(lambda _: None, faults=[fault_of(name)], dut=dut)
    areas.unlink()
    with pytest.raises(InputError, match="adapt the fault"):
        apply_patch(PATCHES / "F4.patch", dut)
    # What it replaces may stand elsewhere, but not twice.
    areas.write_text("\n\n" + (DUT / "core/triaxis_areas.sv").read_text())
    apply_patch(PATCHES / "F4.patch", dut)
    areas.write_text(2 * (DUT / "core/triaxis_areas.sv").read_text())
    with pytest.raises(InputError, match="there 2 times"):
        apply_patch(PATCHES / "F4.patch", dut)
    patch = tmp_path / "x.patch"
    for text in ("", "assign a = b;\n", "--- a/dut/x.sv\n+++ b/dut/x.sv\n@@ -1 +1 @@\n same\n"):
        patch.write_text(text)
        with pytest.raises(InputError, match="not a unified diff"):
            read_hunks(patch)


# --- Faults of the core ------------------------------------------------------------------------------


@pytest.mark.simulator
def test_a_fault_is_caught_with_a_small_counterexample(seed):
    fault = fault_of("F1-box")
    outcome = catch(fault, seed)
    found, example = outcome.catch, outcome.example
    assert found and example, outcome.reason
    search = rtl_faults.SEARCHES[Kind.CORE]
    assert found.pairs and 1 <= found.pairs <= search.pairs
    assert found.test == search.tests[len(found.missed_by)]
    assert "exact answer" in found.message

    pairs = np.array([[each["A"], each["B"]] for each in example.sent])
    stream = Stream(pairs, np.array([each["margin"] for each in example.sent]))
    configuration = parse_configuration(fault.config)
    assert BareCore(configuration, faulty_rtl(fault)).symptom(stream) != Symptom.RIGHT
    assert BareCore(configuration).symptom(stream) == Symptom.RIGHT
    # Of 288 bits.
    assert len(stream) == 1 and bit_lengths(pairs).sum() <= 16
    assert (rtl_faults.PICTURES / f"{fault.name}.png").stat().st_size > 10_000


@pytest.mark.simulator
def test_a_core_that_is_always_caught_fails_the_control(seed):
    caught = Outcome(fault_of("F2"), seed, 1.0, Catch("CoplanarTest", "core says"))
    missed = Outcome(fault_of("F3"), seed, 1.0, None)
    found = control([caught, caught, missed], seed, faulty_rtl(fault_of("F1-box")))
    assert len(found) == 1 and found[0].startswith("CoplanarTest: result") and ": core says" in found[0]


@pytest.mark.parametrize(
    ("name", "counts", "problem"),
    [
        # As where a simulator cannot start.
        ("F2", None, "RandomTest ended without a verdict on the core: no error line"),
        ("engine-lane-mask", {"checked": 5}, f"{', '.join(rtl_faults.SEARCHES[Kind.ENGINE].tests)} pass"),
    ],
)
def test_what_passes_or_ends_without_a_verdict_catches_nothing(
    tmp_path, seed, monkeypatch, name, counts, problem
):
    def ended(test, configuration, *_):
        settings = run_settings(test, configuration, seed, 1)
        return RunResult(settings, bool(counts), 0.0, counts, ("no error line in the log",), tmp_path / "log")

    monkeypatch.setattr(rtl_faults, "run_test", ended)
    outcome = catch(fault_of(name), seed)
    assert not outcome.caught and problem in (outcome.reason or "")
    # Nor does the control pass without a verdict.
    caught = Outcome(fault_of(name), seed, 1.0, Catch(rtl_faults.SEARCHES[outcome.fault.kind].tests[0], ""))
    assert bool(control([caught], seed)) == (counts is None)


RULE = "[135000] %Error: x.sv:38: Assertion failed in tb.u_core.u_sva.PairHeld: it moved"
MESH_RULE = "[135000] %Error: x.sv:38: Assertion failed in triaxis_mesh.u_sva.NearStable: it moved"
WRONG = {"blame": "design", "message": "core says (1)", "of_pair": True}
LOST = {"blame": "design", "message": "3 pairs accepted and never answered", "of_pair": False}
JUDGES = {"blame": "judges", "message": "golden model: no certificate", "of_pair": True}
NOTHING = {"blame": "test", "message": "nothing was checked", "of_pair": False}
HUNG = "triaxis.verif.testbench.failures.HungError: 1 of 2: the core hangs"
DISK = "OSError: [Errno 28] No space left on device"
REFUSED = "InputError: build/faults: cannot write: No space left on device"


def failed_run(folder, failures=(), line="noise", test="RandomTest", config=CONFIG, kept=True):
    settings = run_settings(test, config, 1, 1, folder=folder)
    counts = {"checked_until_failure": 7, "failures": list(failures)}
    folder.mkdir(exist_ok=True)
    if kept:
        failure_file(folder).touch()
    log = folder / "simulation.log"
    log.write_text(f"ERROR noise\n{line}\n")
    errors, rule = errors_in(log)
    return RunResult(settings, False, 0.0, counts, errors, log, rule=rule)


@pytest.mark.parametrize(
    ("failures", "line", "any_sign", "of_core", "of_engine"),
    [
        ([WRONG], "", Sign("design", "core says (1)", 7), True, True),
        ([LOST, WRONG], "", Sign("design", LOST["message"]), "core says (1)", "core says (1)"),
        ([LOST], DISK, Sign("design", LOST["message"]), True, True),
        ([], RULE, Sign("PairHeld", "PairHeld: it moved", clocks=13), True, False),
        ([], RULE.replace("PairHeld", "Un"), Sign("Un", "Un: it moved", clocks=13), False, False),
        ([], MESH_RULE, Sign("NearStable", "NearStable: it moved", clocks=13), False, True),
        ([], HUNG, Sign("HungError", "1 of 2: the core hangs"), True, True),
        # Trouble of the environment says nothing of the design.
        ([JUDGES], "", Sign("judges", JUDGES["message"], 7), False, False),
        ([NOTHING], "", Sign("test", "nothing was checked"), False, False),
        ([], REFUSED, Sign("InputError", REFUSED.partition(": ")[2]), False, False),
        ([], "AssertionError: 5 pairs sent", Sign("AssertionError", "5 pairs sent"), False, False),
        ([], DISK, None, False, False),
    ],
)
def test_only_what_the_design_does_counts_against_it(tmp_path, failures, line, any_sign, of_core, of_engine):
    core = failed_run(tmp_path, failures, line)
    engine = failed_run(tmp_path, failures, line, "MeshRandomTest", ENGINE_CONFIG)
    assert sign_of(core) == sign_of(engine) == any_sign
    # Where the disk is full, there would be no counterexample.
    assert design_sign_of(failed_run(tmp_path / "full", [WRONG], kept=False)) is None
    for run, due in ((core, of_core), (engine, of_engine)):
        found = design_sign_of(run)
        assert (
            found and found.message == due if isinstance(due, str) else found == (any_sign if due else None)
        )


@pytest.mark.long
@pytest.mark.simulator
def test_a_fault_of_the_engine_is_caught(seed):
    """One that only the order of loading and running shows, and nothing where there is none."""
    outcome = catch(fault_of("engine-memory-read"), seed)
    assert outcome.catch and outcome.catch.message.startswith("NoReadAtRest")
    assert outcome.catch.replay and "--fault engine-memory-read" in outcome.catch.replay


@pytest.mark.long
@pytest.mark.simulator
def test_a_fault_of_the_board_is_caught(seed):
    """By the first of its tests, at the clock in which go should have ended."""
    outcome = catch(fault_of("board-go-kept-on-run"), seed)
    assert outcome.catch and outcome.catch.test == "BoardSmokeTest"
    assert "GoEnds: go is said after what ends it" in outcome.catch.message


# --- Faults of a testbench ---------------------------------------------------------------------------


@pytest.mark.long
@pytest.mark.simulator
def test_faults_of_a_testbench_are_caught_and_an_environment_that_lets_them_pass_is_not(seed, monkeypatch):
    caught = catch(fault_of("F10-late"), seed).catch
    assert caught and caught.clocks
    assert "PairHeld: a pair was withdrawn or changed while it waited" in caught.message
    ways = {**environment_faults.ENTRANCES, "back door": lambda *_: None}
    monkeypatch.setattr(environment_faults, "ENTRANCES", ways)
    assert catch(fault_of("F9"), seed).reason == "let in, or refused without the limit: back door"
    table = {
        "F10-unsent": ("RandomTest", BURST, Blame.TEST),
        "F10-unseen": ("NothingSentTest", BURST, "PairHeld"),
    }
    monkeypatch.setattr(environment_faults, "_SABOTAGE", table)
    assert catch(fault_of("F10-unsent"), seed).reason == "RandomTest passes"
    reason = catch(fault_of("F10-unseen"), seed).reason
    assert reason and reason.startswith("NothingSentTest fails, but not by PairHeld: nothing was checked")


# --- The result ----------------------------------------------------------------------------------------


VALID_FOR = Provenance("of the RTL", "of the tests", "5.048", None, None)


def whole_result(**changes):
    outcomes = [Outcome(fault, 1, 0.5, Catch("T", "m")) for fault in FAULTS if fault.signed_off]
    return replace(FaultsResult(outcomes, [], VALID_FOR, False, 1, 2.0), **changes)


def test_result_is_red_for_every_reason():
    good = whole_result()
    assert good.passed and good.complete
    first, *rest = good.outcomes
    missed = replace(first, catch=None, reason="all pass")
    bare = replace(first, catch=Catch("T", "m", pairs=3))
    for change, problem in (
        ({"outcomes": [missed, *rest]}, "F1-box (sign, box axes) is not caught: all pass"),
        ({"outcomes": [bare, *rest]}, "F1-box is caught without a counterexample"),
        ({"control": ["RandomTest: core says"]}, "without a fault: RandomTest: core says"),
        ({"changed": True}, "the RTL, or its environment, changed during the run"),
        ({"outcomes": []}, "no fault was tried"),
    ):
        assert whole_result(**change).problems == [problem]


def test_evidence_is_of_whole_runs_only(tmp_path):
    path = tmp_path / "faults.json"
    with pytest.raises(ValueError, match="no evidence"):
        write_json(whole_result(outcomes=whole_result().outcomes[1:]), path)
    assert not path.exists()
    evidence = read_evidence(write_json(whole_result(), path))
    assert evidence and evidence["passed"]
    assert evidence["summary"] == "24 of 24 faults caught"
    assert [fault["name"] for fault in evidence["faults"]] == [f.name for f in FAULTS if f.signed_off]


def test_command_line(capsys, monkeypatch):
    assert main(["prove", "faults", "--list"]) == 0
    listed = capsys.readouterr().out
    assert all(name in listed for name in fault_names())
    for wrong in (["--fault", "F11"], ["--all", "--fault", "F1"], ["--seed", "-1"]):
        assert main(["prove", "faults", *wrong]) == 2
    f2 = fault_of("F2")
    for outcome, status, said in (
        (Outcome(f2, 1, 0.0, None, reason="all pass"), 1, "PROBLEM F2 (coplanarity) is not caught: all pass"),
        (Outcome(f2, 1, 0.0, Catch("T", "m")), 0, "PASSED: 1 of 1 faults caught"),
    ):
        found = FaultsResult([outcome], [], VALID_FOR, False, 1, 0.0)
        monkeypatch.setattr(command, "catch_all", lambda *_, found=found: found)
        assert main(["prove", "faults", "--fault", "F2"]) == status
        out = capsys.readouterr().out
        # A part is no evidence.
        assert said in out and "written to" not in out


@pytest.mark.regress
@pytest.mark.simulator
def test_sim_runs_on_a_broken_core(seed, capsys):
    arguments = ["RandomTest", "--agent", "burst", "--pairs", "2000", "--seed", str(seed + 7000)]
    before = [sorted(folder.glob("*")) for folder in (REGRESSIONS, FOUND)]
    assert main(["sim", *arguments, "--fault", "F3"]) == 1
    told = capsys.readouterr().err.strip()
    assert "right is clear by axis 10 (A edge 1 x B edge 2)" in told
    assert told.endswith("--fault F3")
    assert re.search(r"waves: .* --fault F3 --waves  # at other clocks", told)
    # What a known fault brings out is no regression of the core.
    assert [sorted(folder.glob("*")) for folder in (REGRESSIONS, FOUND)] == before
    assert main(["sim", *arguments, "--fault", "F10-late"]) == 2
    assert "fault F10-late: is in the environment, and RandomTest drives the core" in capsys.readouterr().err
    assert main(["sim", *arguments, "--fault", "engine-lane-mask"]) == 2
    assert "is in the mesh engine, and RandomTest drives the core" in capsys.readouterr().err
