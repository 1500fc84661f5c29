"""Each way to answer an item can say no, and the list as it is has an answer to everything."""

import re

import pytest

from triaxis.golden.errors import InputError
from triaxis.verif.signoff.checklist import Answer, answered, open_items, read_checklist
from triaxis.verif.signoff.parts import Part
from triaxis.verif.signoff.tests.signoff_evidence import evidence, signed

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
        assert checked(tmp_path, "D3", 'figure = "line_coverage"', figures)[0].answer is answer
    # A bound of the stage of the same number, and not of the last.
    assert checked(tmp_path, "V1", 'figure = "line_coverage"', {"line_coverage": 80})[0].answer is Answer.MET
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
    for text, answer in (("// done", Answer.MET), ("// to be done", Answer.OPEN)):
        (tmp_path / "dut" / "a.sv").write_text(text)
        assert checked(tmp_path, "D2", 'without = "to be done"')[0].answer is answer


@pytest.mark.parametrize(
    ("answer", "message"),
    [
        ("", "must hold item, asks, and one of"),
        ('file = []\nnone = "two answers"', "must hold item, asks, and one of"),
        ("answer = 1", "must hold item, asks, and one of"),
        ('figure = "beauty"', "V1 X: no such figure: 'beauty'"),
        ('part = "beauty"', "V1 X: no such part: 'beauty'"),
    ],
)
def test_what_cannot_be_answered_is_refused(tmp_path, answer, message):
    with pytest.raises(InputError, match=re.escape(message)):
        checked(tmp_path, "V1", answer)


def test_nothing_is_open_where_all_is_well():
    answers = signed().checklist
    assert not [one for one in answers if one.answer is Answer.OPEN]
    assert {one.answer for one in answers} >= {Answer.MET, Answer.YOURS, Answer.NONE}
