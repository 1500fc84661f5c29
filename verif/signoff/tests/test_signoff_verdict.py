"""Any part broken, stale or absent turns the sign-off red, says so on its page, and shuts the gate; the gate
opens for a sign-off of this very RTL that passed, and for nothing else.
"""

import json
import re
import shutil
import time
from dataclasses import replace
from threading import Event

import pytest

from triaxis.coverage.stages import read_figures
from triaxis.golden.errors import InputError
from triaxis.sim.build import content_hash, rtl_hash
from triaxis.sim.paths import DUT
from triaxis.sim.validity import Sources, validity
from triaxis.verif import lint
from triaxis.verif.lint import lint_rtl, not_kept, rtl_linters
from triaxis.verif.mutation.equivalence import evidence_hash
from triaxis.verif.mutation.killers import killers_hash
from triaxis.verif.mutation.record import FILE as RECORD
from triaxis.verif.mutation.record import SEED
from triaxis.verif.mutation.result import KILLED, Fate, MutationResult, known_result, write_result
from triaxis.verif.signoff import parts as signoff_parts
from triaxis.verif.signoff import run as signoff_run
from triaxis.verif.signoff.gate import SOURCES, refusals, remarks
from triaxis.verif.signoff.page import signoff_page
from triaxis.verif.signoff.parts import Part, attempt
from triaxis.verif.signoff.tests.signoff_evidence import (
    HERE,
    WAIVERS,
    evidence,
    good_beside,
    good_content,
    good_parts,
    signed,
)
from triaxis.verif.signoff.tests.test_signoff import GOOD
from triaxis.verif.signoff.verify import BESIDE, PARTS


def survivor(mutation):
    mutation["files"]["a.sv"].update(mutants=13, surviving=1)
    mutation["survivors"] = [{"id": "x", "place": "a.sv:3", "original": "a < b", "changed": "a <= b"}]


BREAKS = [
    ("lint", lambda e: e.update(findings=1), "in the SystemVerilog around it: 1"),
    ("simulation", lambda e: e["runs"][0].update(passed=False), "runs that passed: 0 %"),
    ("simulation", lambda e: e.update(mismatches=1), "answered wrongly: 1"),
    ("simulation", lambda e: e.update(pairs_checked=99_999_999), "checked: 99,999,999"),
    ("simulation", lambda e: e["coverage"]["core_w16_m0"]["claim"].update(hit=32), "goals: 96.96 %"),
    ("code_coverage", lambda e: e["totals"]["line"].update(hit=8), "lines hit or waived: 90 %"),
    ("code_coverage", lambda e: e["totals"]["branch"].update(hit=8), "branches hit or waived: 90 %"),
    ("code_coverage", lambda e: e["totals"]["expression"].update(hit=8), "terms hit or waived: 90 %"),
    ("code_coverage", lambda e: e["totals"]["toggle"].update(hit=8), "toggles hit or waived: 90 %"),
    ("code_coverage", lambda e: e.update(waivers_void=1), "waivers that"),
    ("faults", lambda e: e["faults"][0].update(caught=False, pairs=None), "were caught: 50 %"),
    ("mutation", survivor, "shown equivalent: 92.3 %"),
    ("proofs", lambda e: e["proofs"][0].update(passed=False), "proofs that hold: 0 %"),
    ("proofs", lambda e: e.update(undecided=1), "proofs that hold: not measured"),
    ("testplan", lambda e: e["testpoints"][2].update(passed=False), "testpoints of V3 that are met: 0 %"),
    ("testplan", lambda e: e["problems"].append("testpoint x: no tests"), "testplan: testpoint x: no tests"),
    ("mutation", lambda e: e.update(rtl_hash="0" * 64), "mutation: is of another RTL: 000000000000"),
    ("proofs", lambda e: e.update(passed=False), "proofs: did not pass"),
    ("exhaustive", lambda e: e.update(problems=["1 mismatches"]), "exhaustive: 1 mismatches"),
]


def refused(folder, content):
    path = folder / "signoff.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return refusals(path, HERE.rtl_hash, HERE.environment_hash)


@pytest.mark.long
@pytest.mark.parametrize(("part", "change", "message"), BREAKS)
def test_each_break_turns_it_red_and_shuts_the_gate(tmp_path, part, change, message):
    parts = good_parts()
    change(parts[part].evidence)
    result = signed(parts)
    assert not result.passed
    assert any(message in problem for problem in result.problems), result.problems
    assert refused(tmp_path, result.content())


@pytest.mark.parametrize("name", good_parts())
def test_what_is_absent_is_null_and_fails(tmp_path, name):
    result = signed({**good_parts(), name: Part(None, "the tool is not there")})
    assert not result.passed
    assert f"{name.replace('_', ' ')}: not measured: the tool is not there" in result.problems
    content = json.loads(json.dumps(result.content()))
    assert name == "exhaustive" or None in content["figures"].values()
    assert content["parts"][name] == {"absent": "the tool is not there"}
    assert refused(tmp_path, content)


def test_an_exception_passes_and_is_named(tmp_path):
    parts = good_parts()
    evidence = parts["proofs"].evidence
    assert evidence
    evidence["proofs"].append(
        {**evidence["proofs"][0], "name": "theorem", "passed": False, "result": "not measured"}
    )
    evidence["exceptions"].append("theorem: not measured: coqc is not installed")
    result = signed(parts)
    assert result.passed, result.problems
    assert not refused(tmp_path, result.content())
    assert "signed off without theorem: not measured: coqc is not installed" in remarks(
        tmp_path / "signoff.json"
    )
    page = signoff_page(result.content(), read_figures())
    assert page.count("coqc is not installed") == 1


def test_no_other_proof_may_be_absent():
    parts = good_parts()
    evidence = parts["proofs"].evidence
    assert evidence
    evidence["proofs"].append({**evidence["proofs"][0], "name": "streams", "result": "not measured"})
    assert "proofs: streams: not measured" in signed(parts).problems


def test_what_stands_beside_may_be_absent_but_not_fail(tmp_path):
    absent = signed(beside={**good_beside(), "four_state": Part(None, "run `make four-state`")})
    assert absent.passed, absent.problems
    assert not refused(tmp_path, absent.content())
    assert "signed off without four state: not measured: run `make four-state`" in remarks(
        tmp_path / "signoff.json"
    )
    content = {**good_beside()["four_state"].as_json, "passed": False, "problems": ["2 values unknown"]}
    failed = signed(beside={**good_beside(), "four_state": Part(content)})
    assert not failed.passed and "four state: 2 values unknown" in failed.problems


@pytest.mark.parametrize("key", ["rtl_hash", "environment_hash", "verilator", "synthesiser", "simulator"])
def test_what_stands_beside_is_of_this_rtl_and_this_environment(tmp_path, monkeypatch, key):
    path = tmp_path / "netlist.json"
    one = replace(signoff_parts._BESIDE["netlist"], path=path, sources=SOURCES)
    monkeypatch.setattr(signoff_parts, "_BESIDE", {"netlist": one})
    monkeypatch.setattr(signoff_parts, "yosys_version", lambda: "Yosys 0.99")
    monkeypatch.setattr(signoff_parts, "icarus_installed", lambda: True)
    monkeypatch.setattr(signoff_parts, "icarus_version", lambda: "Icarus 99")
    assert signoff_parts.results_beside()["netlist"].absent == "run `make netlist`"
    here = {**vars(validity(SOURCES)), "synthesiser": "Yosys 0.99", "simulator": "Icarus 99"}
    path.write_text(json.dumps(evidence(**here)))
    assert signoff_parts.results_beside()["netlist"].evidence
    path.write_text(json.dumps(evidence(**{**here, key: "another"})))
    assert "another RTL, environment or tool" in (signoff_parts.results_beside()["netlist"].absent or "")


def without_coq():
    """Return parts in which nobody could try the theorem."""
    parts = good_parts()
    proofs = parts["proofs"].evidence
    assert proofs
    theorem = {**proofs["proofs"][0], "name": "theorem", "passed": False, "result": "not measured"}
    proofs["proofs"].append(theorem)
    proofs["exceptions"].append("theorem: not measured: coqc is not installed: apt-get install coq")
    return parts


def with_a_record(**taken):
    parts = good_parts()
    mutation = parts["mutation"].evidence
    assert mutation
    mutation.update(sample=1, **taken)
    return parts


AS_RECORDED = "mutants: 1,234 as recorded of this very state, 56 more played again"
AS_PROVED = "proofs of equivalence: 1,234 as recorded of this very state, 66 more made again"
PLAYED, PROVED = {"recorded": 1234, "sampled": 56}, {"entries": 1300, "entries_recorded": 1234}


@pytest.mark.long
@pytest.mark.parametrize(
    ("parts", "absent", "said"),
    [
        (with_a_record(**PLAYED), None, AS_RECORDED),
        (with_a_record(**PROVED), None, AS_PROVED),
        (without_coq(), None, "theorem: not measured: coqc is not installed: apt-get install coq"),
        (None, "four_state", "four state: not measured: iverilog: not found: apt-get install iverilog"),
        (None, "netlist", "netlist: not measured: iverilog: not found: apt-get install iverilog"),
    ],
)
def test_in_a_whole_sign_off_nothing_may_be_absent(tmp_path, parts, absent, said):
    beside = good_beside()
    if absent:
        beside[absent] = Part(None, "iverilog: not found: apt-get install iverilog")
    assert signed(parts, beside).passed
    result = signed(parts, beside, whole=True)
    assert not result.passed and result.problems == [said] and result.exceptions == []
    content = json.loads(json.dumps(result.content()))
    assert content["whole"] and content["command"].endswith(" --whole")
    # Nor does the gate believe a file that says it passed.
    assert refused(tmp_path, {**content, "passed": True, "problems": []})
    assert signoff_page(content, read_figures()).count(said.partition(": ")[2]) >= 1


@pytest.mark.parametrize("taken", [PLAYED, PROVED])
def test_what_is_recorded_is_said_whatever_the_file_says(tmp_path, taken):
    content = signed(with_a_record(**taken)).content()
    for said in (content["exceptions"], []):
        assert not refused(tmp_path, {**content, "exceptions": said})
        assert any("1234" in line.replace(",", "") for line in remarks(tmp_path / "signoff.json"))


def test_a_whole_sign_off_passes_where_all_is_there_and_the_gate_says_so(tmp_path):
    content = signed(whole=True).content()
    assert content["passed"] and not refused(tmp_path, content)
    assert any("as a whole" in line for line in remarks(tmp_path / "signoff.json"))
    page = signoff_page(content, read_figures())
    assert "as a whole, stage V3" in page and "Signed off as a whole" in page
    assert "as a whole" not in signoff_page(good_content(), read_figures())
    for beside in ({}, {**content["beside"], "netlist": {"absent": "run it"}}):
        assert any("netlist" in line for line in refused(tmp_path, {**content, "beside": beside}))


def test_a_whole_sign_off_makes_what_is_not_there_and_takes_what_is(tmp_path, monkeypatch):
    made, steps = [], []

    def make(name):
        def making(seed, progress):
            made.append((name, seed))
            if name == "four_state":
                raise InputError("iverilog: not found")
            path = tmp_path / name
            path.write_text(json.dumps(evidence(**vars(validity(SOURCES)))))
            return path

        return making

    assert tuple(signoff_parts._BESIDE) == BESIDE
    changed = {
        name: replace(one, path=tmp_path / name, sources=SOURCES, make=make(name), steps=lambda _: 7)
        for name, one in signoff_parts._BESIDE.items()
    }
    monkeypatch.setattr(signoff_parts, "_BESIDE", changed)
    for again in (False, True):
        found = signoff_parts.make_beside(3, steps.append)
        assert found["four_state"].absent == "iverilog: not found"
        assert found["netlist"].evidence
        assert made == [("four_state", 3)] if again else [("four_state", 3), ("netlist", 3)]
        assert steps == ([7] if again else [])
        made.clear()


@pytest.mark.prover
@pytest.mark.parametrize(("whole", "wanted"), [(False, [7]), (True, [7, None])])
def test_a_whole_sign_off_takes_no_mutant_from_the_record(tmp_path, monkeypatch, whole, wanted):
    """Nor from a result in build/ that did."""
    asked: list[int | None] = []
    evidence = tmp_path / "mutation.json"

    def mutate(seed, progress, sample):
        assert seed == SEED
        asked.append(sample)
        trial = 3 if sample is None else 0
        fate = Fate(
            "m/op/1", "runtime", "dut/core/a.sv:1", "a", "b", KILLED, "run", "T", "w8", "x", 1, "w8", trial
        )
        record = content_hash([RECORD])
        taken = (0, 4, 0) if sample is None else (1, 4, 3)
        return MutationResult(
            (fate,), (), seed, 1.0, rtl_hash(), killers_hash(), (), sample, 1, record, *taken,
            evidence_hash(DUT),
        )  # fmt: skip

    monkeypatch.setattr(signoff_parts, "mutate", mutate)
    monkeypatch.setattr(signoff_parts, "known_result", lambda sample: known_result(sample, evidence))
    monkeypatch.setattr(
        signoff_parts, "write_result", lambda found, command: write_result(found, command, evidence)
    )
    monkeypatch.setattr(signoff_parts, "mutant_names", lambda: ["m/op/1"])
    found = [signoff_parts.mutation_part(7, lambda _: None, also) for also in (False, whole)]
    assert asked == wanted
    assert [part and part["recorded"] for part in found] == [1, 0 if whole else 1]
    assert [part and part["entries_recorded"] for part in found] == [3, 0 if whole else 3]
    # Of other mutants, or where one is no longer listed as equivalent, it is no result.
    monkeypatch.setattr(signoff_parts, "mutant_names", lambda: ["m/op/1", "m/op/2"])
    assert "of other mutants" in (attempt(lambda: signoff_parts.mutation_part(7, print)).absent or "")
    monkeypatch.setattr(signoff_parts, "mutant_names", lambda: ["m/op/1"])
    monkeypatch.setattr(signoff_parts, "EQUIVALENT", KILLED)
    assert "no longer listed" in (attempt(lambda: signoff_parts.mutation_part(7, print)).absent or "")
    # All that the gate and the evidence that is handed over ask for.
    assert all(
        part and set(signed().content()["parts"]["mutation"]) - {"absent"} <= set(part) for part in found
    )


def made(name, monkeypatch, act=lambda: None):
    def part(*_):
        act()
        return {"part": name, "passed": name != "lint"}

    monkeypatch.setattr(signoff_run, f"{name}_part", part)


@pytest.fixture
def stubbed(monkeypatch, tmp_path):
    """A sign-off whose parts cost nothing, and build nothing."""
    monkeypatch.setattr(signoff_run, "BUILD", tmp_path)
    monkeypatch.setattr(signoff_run, "NATIVE", tmp_path / "native")
    monkeypatch.setattr(signoff_run.simulation, "simulate", lambda *_: replace(GOOD, coverage=[]))
    simulated = {"part": "simulation", "passed": True}
    monkeypatch.setattr(signoff_run.simulation, "as_evidence", lambda *_: simulated)
    for name in PARTS:
        if name != "simulation":
            made(name, monkeypatch)
    return monkeypatch


def test_every_part_is_in_its_place_whatever_goes_on_beside_it(stubbed):
    def refuse():
        raise InputError("no compiler")

    made("code_coverage", stubbed, refuse)
    said: list[str] = []
    found = signoff_run.signoff(1, lambda _: None, say=said.append)
    assert tuple(found.parts) == PARTS
    assert said[:3] == ["lint begins", "lint: FAILED, 0 s", "simulation begins"]
    assert "code coverage: not measured, 0 s" in said and "mutation: passed, 0 s" in said
    assert found.parts["code_coverage"].absent == "no compiler"
    assert all(
        part.evidence and part.evidence["part"] == name
        for name, part in found.parts.items()
        if name != "code_coverage"
    )
    assert {span.name for span in found.timeline} == set(PARTS)


def test_nothing_is_taken_that_was_built_before(stubbed, tmp_path):
    stale = [
        tmp_path / "library" / "w8_m8-0123456789ab", tmp_path / "runtime" / "headers-456789abcdef",
        # What a sign-off as a whole is of besides.
        tmp_path / "icarus" / "w8_m8-0123456789ab", tmp_path / "netlist" / "cells-0123456789ab",
        tmp_path / "netlist" / "synthesis" / "w8_m8-0123456789ab",
        tmp_path / "native" / "a.so",
    ]  # fmt: skip
    for place in stale[:-1]:
        place.mkdir(parents=True)
    # Locks may be gone.
    stale[0].with_name(f"{stale[0].name}.lock").touch()
    (tmp_path / "native").mkdir()
    stale[-1].touch()
    # Of runs that wait for each other, and what is no build.
    kept = [
        tmp_path / "faults" / ".lock", tmp_path / "mutation" / "outcomes" / "core.json",
        tmp_path / "runs" / "a.lock", tmp_path / "netlist" / "netlist.json",
    ]  # fmt: skip
    for place in kept:
        place.parent.mkdir(parents=True, exist_ok=True)
        place.touch()
    signoff_run.signoff(1, lambda _: None)
    assert [place for place in (*stale, *kept) if place.exists()] == kept


def test_what_is_written_to_meanwhile_is_a_problem_though_it_is_as_before(stubbed, tmp_path):
    file = tmp_path / "a.sv"
    file.write_text("module a; endmodule\n")
    stubbed.setattr("triaxis.sim.validity.rtl_files", lambda _: [file])
    stubbed.setattr("triaxis.sim.validity._is_clean", lambda _: True)
    stubbed.setattr(signoff_run, "SOURCES", Sources(("triaxis.verif.signoff.plan",)))
    # Time stamps of files may be some milliseconds late.
    time.sleep(0.05)
    assert not signoff_run.signoff(1, lambda _: None).touched
    # While it waits for whoever builds, too.
    with stubbed.context() as patch:
        patch.setattr(signoff_run, "_forget_builds", lambda: file.write_text(file.read_text()))
        assert signoff_run.signoff(1, lambda _: None).touched
    made("proofs", stubbed, lambda: file.write_text(file.read_text()))
    assert signoff_run.signoff(1, lambda _: None).touched
    changed = replace(signed(), touched=True).problems
    assert any("changed during the run" in problem for problem in changed)


def test_variables_that_bring_other_files_are_told(stubbed):
    for name in signoff_run._VARIABLES:
        stubbed.delenv(name, raising=False)
    # Bytecode that is kept elsewhere is not forgotten; cocotb takes unknown values for zeros.
    for name in ("PYTHONPYCACHEPREFIX", "COMPILER_PATH", "COCOTB_RESOLVE_X"):
        with stubbed.context() as patch:
            patch.setenv(name, "zeros")
            assert signoff_run.signoff(1, lambda _: None).variables == (name,)
    stubbed.setenv("PYTHONPATH", "/elsewhere")
    found = signoff_run.signoff(1, lambda _: None)
    assert found.variables == ("PYTHONPATH",)
    said = "variables: PYTHONPATH set: tools may have loaded what no hash is of"
    assert replace(signed(), variables=found.variables).exceptions[-1] == said
    assert replace(signed(whole=True), variables=found.variables).problems == [said]


@pytest.mark.parametrize("interrupted", ["faults", "mutation"])
def test_an_interrupt_ends_what_goes_on_beside(stubbed, interrupted):
    begun = Event()

    def proofs_part(progress):
        begun.set()
        # As long as proofs may take; here a test that fails must end.
        for _ in range(2000):
            time.sleep(0.01)
            progress(1)
        return {"part": "proofs", "passed": True}

    def interrupt():
        assert begun.wait(60)
        raise KeyboardInterrupt

    stubbed.setattr(signoff_run, "proofs_part", proofs_part)
    made(interrupted, stubbed, interrupt)
    told: list[int] = []
    with pytest.raises(KeyboardInterrupt):
        signoff_run.signoff(1, told.append)
    assert sum(told) < 2000


def test_findings_of_several_builds_are_one_and_named_with_the_first(monkeypatch):
    found = {"a": ["x.sv:1: bad"], "b": ["x.sv:1: bad", "y.sv:2: worse"], "c": []}
    monkeypatch.setattr(signoff_parts, "rtl_linters", dict)
    monkeypatch.setattr(signoff_parts, "lint_rtl", lambda _: found)
    part = signoff_parts.lint_part()
    assert part["problems"] == ["a: x.sv:1: bad", "b: y.sv:2: worse"]
    assert (part["passed"], part["findings"]) == (False, 2)
    # Where no linter ran nothing is clean.
    monkeypatch.setattr(signoff_parts, "lint_rtl", lambda _: {})
    assert not signoff_parts.lint_part()["passed"]


@pytest.mark.simulator
def test_types_are_checked_of_this_checkout_and_a_checker_that_does_not_run_is_no_success(
    tmp_path, monkeypatch, capsys
):
    (tmp_path / "typing" / "triaxis").mkdir(parents=True)
    link = tmp_path / "typing" / "triaxis" / "verif"
    link.symlink_to(tmp_path / "another" / "checkout")
    monkeypatch.setattr(lint, "BUILD", tmp_path)
    for said, told in (
        ("", "no runtime"),
        ('{"summary": {"filesAnalyzed": 0}, "generalDiagnostics": []}', ""),
    ):
        tool = tmp_path / "basedpyright"
        tool.write_text(f"#!/bin/sh\necho '{said}'\necho '{told}' >&2\n")
        tool.chmod(0o755)
        monkeypatch.setattr(lint, "_bin", lambda name: str(tmp_path / name))
        assert not lint._types()
        assert told in capsys.readouterr().out
    assert link.readlink() == lint.ROOT / "verif"
    tool.unlink()
    with pytest.raises(
        InputError, match=r"^\S+/basedpyright: not found: run `make lint`, which installs it$"
    ):
        lint._types()


def test_the_linters_of_the_sign_off_find_what_is_put_in(tmp_path, monkeypatch):
    bad = tmp_path / "bad.sv"
    bad.write_text("module bad (input logic [3:0] a, output logic [2:0] b);\n\tassign b = a ;\nendmodule\n")
    commands = rtl_linters()
    verilator = [name for name in commands if name.startswith("verilator -Wall ")]
    assert {name.split()[2] for name in verilator} >= {"triaxis_core", "triaxis_mesh", "nexys4ddr_top"}
    core = commands[verilator[0]]
    begin = [word for word in core if not word.endswith(".sv") and not word.startswith("-G")]
    begin[begin.index("--top-module") + 1] = "bad"
    changed = {"verilator": [*begin, str(bad)]}
    for name in ("verible lint", "verible format"):
        changed[name] = [word for word in commands[name] if not word.endswith(".sv")]
        changed[name].append(str(bad))
    found = lint_rtl(changed)
    assert any("WIDTHTRUNC" in line for line in found["verilator"])
    assert any("tabs" in line for line in found["verible lint"])
    assert found["verible format"] == [f"{bad}: Needs formatting."]
    assert bad.read_text().count("\t") == 1
    # Nothing is taken from where it is run, as that is in no hash of the RTL.
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    (elsewhere / "hidden.sv").write_text("module hidden;\nendmodule\n")
    bad.write_text("module bad;\n  hidden u_hidden ();\nendmodule\n")
    monkeypatch.setattr(lint, "ROOT", elsewhere)
    monkeypatch.chdir(elsewhere)
    assert any("'hidden'" in line for line in lint_rtl({"apart": [*begin, str(bad)]})["apart"])
    # One that says nothing and fails has failed.
    assert lint_rtl({"none": [*begin, str(tmp_path / "none.sv")]})["none"]
    assert lint_rtl({"none": ["false"]}) == {"none": ["exit code 1"]}


def test_each_link_says_what_it_rests_on():
    def states(result):
        return [(link.step, link.state.value) for link in result.chain]

    good = states(signed())
    assert [state for _, state in good] == [
        "not measured", "proved", "not measured", "checked", "checked", "not measured", "checked", "checked",
        "not covered", "not covered",
    ]  # fmt: skip
    parts = good_parts()
    assert parts["proofs"].evidence and parts["mutation"].evidence
    proofs = parts["proofs"].evidence["proofs"]
    small = {"W": 4, "Depth": 1024}
    proofs += [{**proofs[0], "name": name, "parameters": small} for name in ("theorem", "engine_walk")]
    proofs.append({**proofs[0], "name": "board_go"})
    result = signed(parts)
    assert states(result)[0] == ("distance to 32 axes", "proved")
    assert result.chain[2].amount == "1 of 1 proofs; `engine_walk` at W = 4, Depth = 1,024"
    proofs[0].update(passed=False, result="failed")
    parts["mutation"].evidence.update(passed=False)
    broken = states(
        signed(
            {**parts, "simulation": Part(None, "no tool")},
            {**good_beside(), "four_state": Part(None, "none")},
        )
    )
    assert [state for _, state in broken] == [
        "proved", "failed", "proved", "not measured", "failed", "proved", "not measured", "checked",
        "not covered", "not covered",
    ]  # fmt: skip


def test_all_well_passes_and_a_change_of_the_checkout_fails(tmp_path):
    result = signed()
    assert result.problems == [] and result.passed
    for clean, said in (
        (True, []),
        (False, ["signed off from a checkout with uncommitted changes, or outside git"]),
    ):
        assert refused(tmp_path, {**result.content(), "git_clean": clean}) == []
        assert remarks(tmp_path / "signoff.json") == said
    moved = replace(result, provenance=replace(HERE, environment_hash="0"))
    assert any("changed during the run" in problem for problem in moved.problems)


@pytest.mark.parametrize(
    ("place", "value", "reason"),
    [
        ("rtl_hash", "b" * 64, "signed off for RTL bbbbbbbbbbbb, this is"),
        ("rtl_hash", None, "of unknown hash"),
        ("environment_hash", "d" * 64, "by the environment dddddddddddd, this is"),
        ("environment_hash", None, "of unknown hash"),
        ("passed", False, "did not pass"),
        ("passed", "yes", "did not pass"),
        ("problems", ["mutation: 1 survivor"], "mutation: 1 survivor"),
        ("problems", None, "does not list its problems"),
        ("figures", None, "no figures"),
        ("figures", {}, "measured without a bound"),
        ("figures.mutation_score", "100", "no figures"),
        ("figures.mutation_score", True, "no figures"),
        ("figures.mutation_score", float("nan"), "no figures"),
        ("figures.mutation_score", 250, "no figures"),
        ("figures.mismatches", -1, "no figures"),
        ("figures.pairs_checked", 10**400, "no figures"),
        ("figures.mutation_score", 99.99, "wanted at least 100 %"),
        ("figures.proofs_passed", None, "not measured"),
        ("parts", None, "no evidence"),
        ("parts", {}, "mutation: no evidence"),
        ("parts.proofs", {"absent": "no tool"}, "proofs: did not pass"),
        ("parts.faults", {"passed": True}, "faults: is of RTL of unknown"),
        ("beside.netlist", {"passed": False, "rtl_hash": HERE.rtl_hash}, "netlist: did not pass"),
        ("beside.four_state", {"passed": True, "rtl_hash": "0" * 64}, "four_state: is of RTL 000000000000"),
        ("exceptions", None, "does not tell its exceptions"),
        ("exceptions", [1], "does not tell its exceptions"),
        ("parts.mutation", {"passed": True, "rtl_hash": HERE.rtl_hash}, "does not tell its exceptions"),
        ("waivers", None, "measured with 0"),
        ("waivers", [{**waiver, "reason": "because"} for waiver in WAIVERS], "reason changed"),
    ],
)
def test_each_reason_to_refuse(tmp_path, place, value, reason):
    head, _, key = place.partition(".")
    good = good_content()
    found = refused(tmp_path, {**good, head: {**good[head], key: value} if key else value})
    assert any(reason in line for line in found), found


def test_what_does_not_follow_from_what_was_counted_is_refused(tmp_path):
    """By hand nothing can be made to pass that an archive of it would not."""
    for change, said in (
        (lambda c: c["parts"]["simulation"]["runs"][0].update(passed=False), "runs.0.passed: False"),
        (
            lambda c: c["parts"]["simulation"]["runs"][0]["counts"].update(failed=7),
            "mismatches: 7 by what was",
        ),
        (lambda c: c["parts"]["mutation"]["files"]["a.sv"].update(killed=0, surviving=10), "surviving: 10"),
        (lambda c: c["parts"]["proofs"]["proofs"][0].update(result="failed"), "failed"),
        (lambda c: c["parts"]["lint"].update(problems=["x"]), "open_problems: 1 by what was counted"),
        (lambda c: c.update(stage="V1"), "another stage"),
        (lambda c: c.update(beside={}), "other parts"),
        (lambda c: c.update(whole="true"), "whole"),
        (lambda c: c["checklist"][0].update(answer="open"), "checklist"),
        (lambda c: c["parts"].update(lint={"passed": True, "rtl_hash": c["rtl_hash"]}), "KeyError"),
        (lambda c: (c["beside"].update(netlist={"absent": "no"}), c.update(exceptions=[])), "no exception"),
    ):
        content = json.loads(json.dumps(signed().content()))
        assert not refused(tmp_path, content)
        change(content)
        assert any(said in line for line in refused(tmp_path, content)), said
    content = json.loads(json.dumps(signed(without_coq()).content()))
    assert not refused(tmp_path, content)
    assert refused(tmp_path, {**content, "exceptions": []})[0].endswith("theorem: absent, and no exception")
    text = (tmp_path / "signoff.json").read_text()
    (tmp_path / "signoff.json").write_text('{"passed": false, ' + text[1:])
    assert "stands twice" in refusals(tmp_path / "signoff.json", HERE.rtl_hash, HERE.environment_hash)[0]


def test_what_is_no_sign_off_is_refused(tmp_path):
    cut = json.dumps(good_content())[:-20]
    deep = "[" * 100_000
    for text, reason in (("", "readable"), (cut, "readable"), (deep, "readable"), ("[]", "not a sign-off")):
        assert reason in refused(tmp_path, text)[0]
    assert "run `make signoff`" in refusals(tmp_path / "none.json", "", "")[0]


def test_page_stands_alone_and_tells_every_problem_and_every_absent_part():
    def page_of(result):
        return signoff_page(result.content(), read_figures())

    page = page_of(signed())
    assert not re.findall(r"""(?:src|href)=["']?(?:https?:)?//""", page)
    assert "PASSED" in page
    # What took the time: a part, and a stage of one, with the seconds of the processor.
    for piece in ("simulation", "1111 s", "w8_m8: 24 built", "1234 s"):
        assert f"{piece}</text>" in page
    broken = good_parts()
    for part, change, _ in BREAKS:
        change(broken[part].evidence)
    page = page_of(signed(broken))
    assert "FAILED" in page
    assert all(problem.partition(":")[0] in page for problem in signed(broken).problems)
    page = page_of(signed({name: Part(None, f"{name} is not there") for name in broken}))
    assert all(f"not measured: {name} is not there" in page for name in broken)


@pytest.mark.parametrize(
    ("file", "attribute", "said"),
    [
        ("board/triaxis_reset_sync.sv", 'ASYNC_REG = "TRUE"', "u_reset.stage_q: must have ASYNC_REG = TRUE"),
        ("board/triaxis_safety.sv", 'keep = "true", dont_touch = "true"', "go_q: must have keep = true"),
        (
            "mesh/triaxis_mesh.sv",
            'keep_hierarchy = "yes"',
            "u_walk: must have keep_hierarchy = yes",
        ),
    ],
)
def test_what_synthesis_is_to_keep_is_looked_at(tmp_path, file, attribute, said):
    assert not_kept() == []
    shutil.copytree(DUT, tmp_path / "dut")
    path = tmp_path / "dut" / file
    path.write_text(path.read_text().replace(attribute, "other", 1))
    found = not_kept(tmp_path / "dut")
    assert any(said in line for line in found), found
