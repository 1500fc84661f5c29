"""The board's safety module against a model of it in other words, and every condition of it shown needed."""

import numpy as np
import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.verif.board.safety import (
    ALIVE,
    COMPLETE,
    DONE,
    GO,
    MUTANTS,
    RESET,
    RUN,
    STATUS_SHIFT,
    STOP,
    SafetyModule,
    allowed,
    mutated,
    random_events,
)

pytestmark = pytest.mark.simulator

CLOCKS = 20_000
CLEAR = ALIVE | DONE | COMPLETE << STATUS_SHIFT


@pytest.fixture(scope="module")
def mutants(tmp_path_factory):
    return SafetyModule(mutated(DUT / "board", tmp_path_factory.mktemp("safety")))


def said(events, allow):
    return np.where(allow, GO, STOP).astype(np.uint8)


def test_the_module_does_what_the_model_says(rng):
    events = random_events(rng, 10 * CLOCKS)
    before, outputs = SafetyModule(DUT / "board").run(events)
    allow = allowed(events)
    assert before == STOP
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
        ([run | DONE | COMPLETE << STATUS_SHIFT, quiet], [0, 0]),
    ]
    for events, expected in cases:
        assert allowed(np.array(events, np.uint16)).tolist() == [bool(go) for go in expected]


def test_every_condition_is_needed(mutants, rng):
    events = random_events(rng, CLOCKS)
    expected = said(events, allowed(events))
    assert (mutants.run(events)[1] == expected).all()
    survivors = [
        mutant
        for number, mutant in enumerate(MUTANTS, 1)
        if (mutants.run(events, number)[1] == expected).all()
    ]
    assert not survivors


def test_a_condition_that_is_gone_is_no_mutant(tmp_path):
    text = (DUT / "board" / "triaxis_safety.sv").read_text()
    (tmp_path / "triaxis_safety.sv").write_text(text.replace("|| refused_i ", ""))
    with pytest.raises(InputError, match="refused_i"):
        mutated(tmp_path, tmp_path)
