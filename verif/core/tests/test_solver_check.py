"""The check of the golden model's solver: it agrees with PPL, and one that lies is noticed."""

import signal
import sys
from dataclasses import replace

import numpy as np
import pytest

from triaxis.golden.bulk import bulk_facts
from triaxis.golden.errors import InputError
from triaxis.golden.game_solver import GameSolver
from triaxis.verif.core import detector_check, solver_check
from triaxis.verif.core.solver_check import check_solvers, other_solver


class FarSolver(GameSolver):
    """Finds what is apart an eighth nearer than it is, by an axis that shows that much."""

    def best_axis(self, a, b):
        best = super().best_axis(a, b)
        return replace(best, distance=best.distance * 7 / 8)

    def nearest_points(self, a, b):
        return replace(super().nearest_points(a, b), distance=self.best_axis(a, b).distance)


def test_both_agree_and_signals_stay_as_they_were(seed):
    pytest.importorskip("ppl", reason="pplpy is not installed: nothing to compare")
    before = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    found = check_solvers(seed, (8, 32), 60)
    assert (found.pairs, found.different) == (120, 0)
    after = [signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)]
    assert before == after


def test_a_solver_that_lies_is_noticed(seed, monkeypatch):
    pytest.importorskip("ppl", reason="pplpy is not installed: nothing to compare")
    monkeypatch.setattr(solver_check, "SOLVER", FarSolver())
    assert check_solvers(seed, (16,), 60).different > 0


@pytest.mark.parametrize(("place", "clear", "wrong"), [(None, 15, 0), (14, 14, 0), (15, 15, 1)])
def test_a_wrapper_that_is_wrong_in_one_answer_is_noticed(seed, monkeypatch, place, clear, wrong):
    def detect(pairs, _):
        near = bulk_facts(pairs, np.zeros(len(pairs), np.int64)).near
        return near ^ (np.arange(len(pairs)) == place)

    monkeypatch.setattr(detector_check, "detect", detect)
    monkeypatch.setattr(detector_check, "_PAIRS", 300)
    assert detector_check.check_detector(seed) == detector_check.DetectorResult(clear, 300, wrong)


def test_without_ppl_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "triaxis.golden.ppl_solver", None)
    with pytest.raises(InputError, match="pplpy: not installed"):
        other_solver()
