"""The bounds of the stages decide, and a figure that was not measured meets none."""

import pytest

from triaxis.coverage.stages import STAGES, STAGES_FILE, judge, read_figures
from triaxis.golden.errors import InputError

FIGURES = read_figures()


def perfect():
    return {figure.name: figure.bounds["V3"] for figure in FIGURES}


@pytest.mark.parametrize("figure", FIGURES, ids=lambda figure: figure.name)
def test_each_figure_alone_stands_against_a_pass(figure):
    bound = figure.bounds["V3"]
    # The last stage asks for everything; what proofs do not look at is named instead.
    others = {"pairs_checked": 1e8, "registers_proved": 88}
    assert bound == (0 if figure.is_most else others.get(figure.name, 100))
    for value in (bound + 0.01 if figure.is_most else bound - 0.01, None):
        judgement = judge(FIGURES, {**perfect(), figure.name: value})
        assert not judgement.passed
        assert judgement.stage in (None, *STAGES[:-1])
        assert len(judgement.shortfalls) == 1
        assert figure.meaning in judgement.shortfalls[0]
    assert "not measured" in judgement.shortfalls[0]


def test_stages_are_reached_in_order():
    judgement = judge(FIGURES, perfect())
    assert (judgement.passed, judgement.stage, judgement.shortfalls) == (True, "V3", ())
    lowest = {figure.name: figure.bounds.get("V1", 1e9 if figure.is_most else None) for figure in FIGURES}
    assert judge(FIGURES, lowest).stage == "V1"
    assert judge(FIGURES, {**lowest, "runs_passed": 99}).stage is None
    second = {figure.name: figure.bounds.get("V2", 1e9 if figure.is_most else None) for figure in FIGURES}
    assert judge(FIGURES, second).stage == "V2"


def test_figures_of_another_sign_off_are_refused():
    with pytest.raises(InputError, match="mutation_score"):
        judge(FIGURES, {name: value for name, value in perfect().items() if name != "mutation_score"})
    with pytest.raises(InputError, match="unheard_of"):
        judge(FIGURES, {**perfect(), "unheard_of": 1})


def test_damaged_bounds_are_refused(tmp_path):
    text, path = STAGES_FILE.read_text(), tmp_path / "stages.toml"
    old = "at_least = { V2 = 90, V3 = 100 }"
    assert old in text
    for new, message in (
        ("at_least = { V2 = 90 }", "V3 needs one"),
        ("at_least = { V2 = 100, V3 = 90 }", "asks for less"),
        ("at_least = { V2 = 90, V9 = 100 }", "must be numbers"),
        ("at_least = { V3 = true }", "must be numbers"),
        ("at_least = { V3 = nan }", "must be numbers"),
        ("wanted = 100", "must hold meaning"),
        ("unit = ", "cannot be read"),
    ):
        path.write_text(text.replace(old, new, 1))
        with pytest.raises(InputError, match=message):
            read_figures(path)
    path.write_text("")
    with pytest.raises(InputError, match="would pass"):
        read_figures(path)
