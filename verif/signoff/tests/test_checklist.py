"""Each way to answer an item can say no, and the list as it is has an answer to everything."""

import re

import pytest

from triaxis.golden.errors import InputError
from triaxis.verif.signoff.checklist import Answer, answered, open_items, read_checklist
from triaxis.verif.signoff.parts import Part
from triaxis.verif.signoff.tests.signoff_evidence import evidence, good_parts, signed
from triaxis.verif.signoff.verify import KINDS

NOT_HIT = {"hit": 8, "waived": 0, "total": 10}
ENTRY = '[[{}]]\nitem = "X"\nasks = "is it so"\n{}\n'


def checked(tmp_path, name, answer, figures=None, parts=None):
    path = tmp_path / "checklist.toml"
    lists = ("D1", "D2", "D3", "V1", "V2", "V3")
    texts = [ENTRY.format(one, answer if one == name else 'none = "-"') for one in lists]
    path.write_text("".join(texts), encoding="utf-8")
    items = answered(read_checklist(path), figures or {}, parts or {}, tmp_path)
    (found,) = [one for one in items if one.item.list == name]
    assert len(items) == len(lists)
    return found, list(open_items(items))


def test_figures_parts_files_and_patterns_can_say_no(tmp_path):
    for value, answer in ((100, Answer.MET), (99.9, Answer.OPEN), (None, Answer.OPEN)):
        figures = {"line_coverage": value}
        assert checked(tmp_path, "D3", 'figure = ["line_coverage"]', figures)[0].answer is answer
    # A bound of the stage of the same number, and not of the last.
    assert (
        checked(tmp_path, "V1", 'figure = ["line_coverage"]', {"line_coverage": 80})[0].answer is Answer.MET
    )
    # Of several each.
    several = 'figure = ["line_coverage", "toggle_coverage"]'
    for toggled, answer in ((90, Answer.MET), (89.9, Answer.OPEN), (None, Answer.OPEN)):
        figures = {"line_coverage": 95, "toggle_coverage": toggled}
        assert checked(tmp_path, "V2", several, figures)[0].answer is answer
    for part, answer in (
        (Part(evidence()), Answer.MET),
        (Part(evidence(passed=False)), Answer.OPEN),
        (Part(None, "no tool"), Answer.ABSENT),
    ):
        assert checked(tmp_path, "V2", 'part = "x"', parts={"x": part})[0].answer is answer
    (tmp_path / "a.md").write_text("# A\n\n## One thing\n")
    for files, answer in (
        ('["a.md"]', Answer.MET),
        ('["a.md#One thing"]', Answer.MET),
        ('["a.md#One"]', Answer.OPEN),
        ('["a.md", "b.md"]', Answer.OPEN),
    ):
        found, lines = checked(tmp_path, "D1", f"file = {files}")
        assert found.answer is answer and len(lines) == (answer is Answer.OPEN)
    (tmp_path / "dut").mkdir()
    # Where nothing is looked at nothing is found.
    assert checked(tmp_path, "D2", 'without = "to be done"')[0].answer is Answer.OPEN
    for text, answer in (("// done", Answer.MET), ("// to be done", Answer.OPEN)):
        (tmp_path / "dut" / "a.sv").write_text(text)
        assert checked(tmp_path, "D2", 'without = "to be done"')[0].answer is answer


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ("", "must hold item, asks, and one of"),
        ('file = []\nnone = "two answers"', "must hold item, asks, and one of"),
        ("answer = 1", "must hold item, asks, and one of"),
        ('figure = ["beauty"]', "V1 X: no such figure: 'beauty'"),
        ("figure = []", "V1 X: figure must be a list that names at least one"),
        ('figure = "line_coverage"', "V1 X: figure must be a list"),
        ("file = []", "V1 X: file must be a list that names at least one"),
        ('figure = ["mutation_score"]', "V1 X: V1 asks nothing of mutation_score"),
        ('part = "beauty"', "V1 X: no such part: 'beauty'"),
    ],
)
def test_what_cannot_be_answered_is_refused(tmp_path, answer, message):
    with pytest.raises(InputError, match=re.escape(message)):
        checked(tmp_path, "V1", answer)


def test_a_list_that_is_damaged_or_of_other_stages_is_refused(tmp_path):
    for text, said in (
        ("[[", "cannot be read"),
        (ENTRY.format("D1", 'none = "-"'), "must hold the lists D1, D2"),
    ):
        (tmp_path / "list.toml").write_text(text)
        with pytest.raises(InputError, match=said):
            read_checklist(tmp_path / "list.toml")


def test_lint_each_kind_of_coverage_and_a_waiver_without_a_reason_leave_their_items_open():
    def left_open(part, change):
        parts = good_parts()
        change(parts[part].evidence)
        return {(a.item.list, a.item.item) for a in signed(parts).checklist if a.answer is Answer.OPEN}

    found = left_open("lint", lambda e: e.update(findings=1, passed=False, problems=["a.sv:1: unused"]))
    assert found >= {
        ("D1", "LINT_SETUP"), ("D2", "LINT_PASS"), ("D3", "LINT_COMPLETE"), ("V3", "NO_TOOL_WARNINGS_THROWN"),
        ("V3", "TB_LINT_COMPLETE"),
    }  # fmt: skip
    for kind in KINDS:
        found = left_open("code_coverage", lambda e, kind=kind: e["totals"].update({kind: dict(NOT_HIT)}))
        assert ("V2", "SIM_CODE_COVERAGE") in found, kind
        assert ("V3", "SIM_CODE_COVERAGE_AT_100, FPV_CODE_COVERAGE_AT_100") in found, kind
    found = left_open("proofs", lambda e: e.update(passed=False))
    assert ("V1", "FPV_MAIN_ASSERTIONS_PROVEN") in found
    waived, hidden, for_one, read_in = (
        one for one in read_checklist() if one.item == "LINT_COMPLETE" and one.kind == "without"
    )
    for item, text, answer in (
        (hidden, "  // verilator coverage_off\n", True),
        (hidden, "  /*verilator coverage_block_off*/\n", True),
        (hidden, "  // synthesis translate_off\n", True),
        (hidden, "  assign off = coverage;\n", False),
        (for_one, "`ifdef SYNTHESIS\n", True),
        (for_one, "  `ifndef  YOSYS\n", True),
        (for_one, "`ifdef TRIAXIS_DSP_PORT_A\n", False),
        (for_one, "`ifndef TRIAXIS_STAGE_SVH\n", False),
        (read_in, '`include "rule.inc"\n', True),
        (read_in, '`include "../rule.svh"\n', True),
        (read_in, "`include `RULE\n", True),
        (read_in, '  initial $readmemh("table.mem", table_q);\n', True),
        (read_in, '`include "triaxis_stage.svh"\n', False),
    ):
        assert bool(re.search(item.value, text)) == answer, text
    for above, answer in (
        ("  // For this reason.\n", False),
        ("  // verilator lint_on X\n", True),
        ("\n", True),
    ):
        text = f"// A header.\n\n{above}  // verilator lint_off X\n"
        assert bool(re.search(waived.value, text)) == answer, above


def test_nothing_is_open_where_all_is_well():
    answers = signed().checklist
    assert not [one for one in answers if one.answer is Answer.OPEN]
    assert {one.answer for one in answers} >= {Answer.MET, Answer.YOURS, Answer.NONE}
