"""Statuses of runs that ended early, without a simulator: right ones pass, each wrong counter is told."""

import struct

import numpy as np
import pytest

from triaxis.golden.scene import scene_answer
from triaxis.verif.board.board_state import Due, Frame, Run
from triaxis.verif.board.protocol import REPLY, Code, Command, Mode, Reply, State, Status
from triaxis.verif.board.protocol import End as RunEnd
from triaxis.verif.board.reply_check import ReplyCheck
from triaxis.verif.mesh.expectation import walked


class Bench:
    """A run of two meshes, and what is said of a status that tells how it ended."""

    def __init__(self, seed, mode, cut_off=False):
        rng = np.random.default_rng(seed)
        a, b = (rng.integers(-50, 50, (16, 1, 3)) + rng.integers(-30, 31, (16, 3, 3)) for _ in range(2))
        self.answer = answer = scene_answer(a, b, 5, 4)
        near = answer.near[tuple(answer.to_be_tested.T)]
        self.first = int(near.argmax()) + 1
        aborted = mode != Mode.FIRST
        self.run = Run(
            mode=int(mode), state=State.DONE, answer=answer, maybe_aborted=aborted, cut_off=cut_off
        )
        tested = answer.tested // 2 if aborted else self.first
        assert near.sum() > 3 and near[:tested].any()
        counts = (*walked(answer, tested).values(), tested, int(near[:tested].sum()))
        end = RunEnd.ABORTED if aborted else RunEnd.FIRST
        self.right = Status._make((0, State.DONE, end, 0, mode, 0, 0, 0, 5, 99, *counts, 0, 16, 16))
        totals = (answer.group_pairs_skipped, answer.group_pairs_opened, answer.pairs_skipped, answer.tested)
        self.whole = self.right._replace(
            end=self.run.end, groups_skipped=totals[0], groups_opened=totals[1], pairs_skipped=totals[2],
            tested=totals[3], near=self.run.near,
        )  # fmt: skip

    def said(self, status):
        """Return what is wrong with a status."""
        told = []
        check = ReplyCheck(told.append, lambda *_: None)
        frame = Frame(Command.STATUS, 7, 9, b"", 0)
        payload = struct.pack("<5B3i7I3H", *status)
        reply = Reply(Command.STATUS | REPLY, 7, 9, Code.OK, payload, np.empty((0, 2), np.int64))
        check.compare(Due(frame, Code.OK, b"", self.whole, busy=False), reply, self.run)
        return told


@pytest.mark.parametrize("mode", [Mode.FIRST, Mode.ALL])
def test_a_run_that_ended_early_has_counted_what_it_passed(seed, mode):
    bench = Bench(seed, mode)
    assert not bench.said(bench.right)
    wrong = [{"groups_opened": 0}, {"tested": 0}, {"near": 0}, {"near": bench.right.tested + 1}]
    wrong += [{"groups_skipped": bench.whole.groups_skipped + 1}]
    wrong += [{"pairs_skipped": bench.right.pairs_skipped - 1}] * bool(bench.right.pairs_skipped)
    if mode == Mode.FIRST:
        wrong += [{"tested": bench.first + 1}, {"near": 2}]
    for change in wrong:
        assert bench.said(bench.right._replace(**change)), change


def test_a_run_that_was_cut_off_long_ago_has_not_ended_by_itself(seed):
    assert not Bench(seed, Mode.ALL).said(Bench(seed, Mode.ALL).whole)
    bench = Bench(seed, Mode.ALL, cut_off=True)
    assert bench.said(bench.whole) and not bench.said(bench.right)
