"""What `triaxis sim` refuses, and what it says of a fault that a test does not notice."""

from types import SimpleNamespace

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli.commands import runner
from triaxis.verif.commands import sim


def test_the_board_judges_all():
    with pytest.raises(InputError, match="--judged goes with tests of the core or the mesh engine"):
        runner("sim", ["BoardTrialsTest", "--judged", "5"])()


def test_a_fault_that_is_not_noticed_is_told_and_is_no_healthy_run(monkeypatch, capsys):
    folders = list[str]()

    def passes(settings, _):
        folders.append(settings.folder)
        counts = dict.fromkeys(("checked", "judged_by_golden_model", "clear_claims_rechecked"), 1)
        return SimpleNamespace(waves=None, passed=True, counts=counts, seconds=1.0)

    monkeypatch.setattr(sim, "run_and_explain", passes)
    said = list[str]()
    for fault in ([], ["--fault", "F1-box"]):
        assert runner("sim", ["RandomTest", "--pairs", "9", *fault])() == 0
        said.append(capsys.readouterr().out)
    assert said[0].startswith("passed: RandomTest") and "coverage page" in said[0]
    assert said[1].startswith("passed, without noticing F1-box: ") and "coverage" not in said[1]
    assert folders[1] == f"{folders[0]}_F1-box"
