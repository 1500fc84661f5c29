"""The board's safety module against a model of it in other words, and every condition of it shown needed."""

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.verif.board import safety
from triaxis.verif.board.safety import ALIVE, COMPLETE, DONE, MUTANTS, RESET, RUN, SafetyModule, allowed

pytestmark = pytest.mark.simulator

CLOCKS = 20_000
CLEAR = ALIVE | DONE | COMPLETE << safety.STATUS_SHIFT


def said(events, allow):
    return np.where(allow, safety.GO, safety.STOP).astype(np.uint8)


def test_the_module_does_what_the_model_says(rng):
    events = safety.random_events(rng, 10 * CLOCKS)
    before, outputs = SafetyModule(DUT / "board").run(events)
    allow = allowed(events)
    assert before == safety.STOP
    assert (outputs == said(events, allow)).all()
    # Neither is the exception.
    assert 0.1 < allow.mean() < 0.9


def test_the_model_on_histories_that_can_be_judged_by_eye():
    quiet, run = ALIVE, ALIVE | RUN
    cases = [
        ([quiet, quiet], [0, 0]),
        ([run, quiet, CLEAR, quiet], [0, 0, 1, 1]),
        ([CLEAR, run, quiet], [0, 0, 0]),
        ([run, 0, CLEAR], [0, 0, 0]),
        ([run, CLEAR, 0, CLEAR], [0, 1, 0, 0]),
        ([run, CLEAR, run, CLEAR], [0, 1, 0, 1]),
        ([run, CLEAR | RESET, CLEAR], [0, 0, 0]),
        ([run | RESET, CLEAR], [0, 0]),
        ([RUN, CLEAR], [0, 0]),
        ([run | DONE | COMPLETE << safety.STATUS_SHIFT, quiet], [0, 0]),
    ]
    for events, expected in cases:
        assert allowed(np.array(events, np.uint16)).tolist() == [bool(go) for go in expected]


def test_every_condition_is_needed(tmp_path, rng):
    mutants = SafetyModule(safety.mutated(DUT / "board", tmp_path))
    events = safety.random_events(rng, CLOCKS)
    expected = said(events, allowed(events))
    runs = [(mutants.run(events, number)[1] == expected).all() for number in range(len(MUTANTS) + 1)]
    assert runs == [True] + [False] * len(MUTANTS)
    # A condition that is gone is no mutant.
    text = (DUT / "board" / "triaxis_safety.sv").read_text()
    (tmp_path / "triaxis_safety.sv").write_text(text.replace("|| refused_i ", ""))
    with pytest.raises(InputError, match="refused_i"):
        safety.mutated(tmp_path, tmp_path)
