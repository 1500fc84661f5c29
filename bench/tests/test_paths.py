"""The benchmark of paths: what is planted is there, and a miss is a problem."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from triaxis.bench.paths import report as paths
from triaxis.bench.peers.peer import Peer, Question
from triaxis.golden.judge import judge
from triaxis.host.broadphase import candidates


@pytest.mark.long
def test_a_small_program_is_clear_and_what_is_planted_is_found(tmp_path):
    ours = paths.measured(tmp_path, 400, 30, 4, lambda _: None)
    assert (ours.clear, ours.missed, ours.moves, ours.facets) == (True, 0, 402, 1800)
    assert not paths.findings(ours, [], []).problems
    assert paths.findings(replace(ours, missed=1), [], []).problems == [
        "1 of 4 planted collisions were missed"
    ]
    assert paths.findings(replace(ours, clear=False), [], []).problems


def test_planted_moves_collide_between_ends_that_are_clear():
    tool, relief = paths.ball_nosed(24), paths.relief(40)

    def meet(place):
        a, b = (np.round(1000 * mesh).astype(np.int64) for mesh in (tool + place, relief))
        pairs = [(i, j) for blocks in candidates(a, b, 0) for i, j in zip(*blocks, strict=True)]
        return any(judge(a[i].tolist(), b[j].tolist(), 0).distance == Fraction(0) for i, j in pairs)

    for start, end in paths.planted(2, np.random.default_rng(3)):
        assert [meet(place) for place in (start, (start + end) / 2, end)] == [False, True, False]


def test_answers_of_others_are_compared():
    moves, truth = paths.asked_moves(3)
    peer = Peer("x", "x", "x", lambda: "1", lambda a, b: Question(lambda: np.array([True, False] * 3)))
    found = paths.asked(peer, truth, 8)
    assert (len(moves), found.moves, found.missed, found.false) == (6, 6, 1, 1)
