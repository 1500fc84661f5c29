"""Each check of the board is tried before it is used; one that does not tell of its fault ends that."""

from collections import Counter
from dataclasses import dataclass, field, replace

import pytest

from triaxis.host.cli.board import simulated_parameters
from triaxis.host.link.board import Board
from triaxis.host.link.exchange import LinkError
from triaxis.host.link.messages import (
    SCRUB,
    WHICHES,
    ZONES,
    Code,
    Command,
    Flag,
    LoadHead,
    Memory,
    RunEnd,
    RunRequest,
    Status,
    TrialKind,
    pack_triangles,
)
from triaxis.host.link.self_test import TRIANGLE, self_test, trials
from triaxis.host.tests.scripted_board import BOARD, ScriptedLine
from triaxis.sim.simulated_board import SimulatedTop
from triaxis.sim.simulated_line import SimulatedLine, SimulatedWire

# The payload of the only LOAD that a self-test sends, of mesh A.
LOADS = LoadHead(0, 0, 1).pack() + pack_triangles(TRIANGLE, BOARD.width)
NEAR = Status(1, 2, 1, ZONES, 2, 0, 0, 0, 0, 60, 0, 1, 0, 1, 1, 0, 1, 1)


@dataclass
class TriedLine(ScriptedLine):
    """A line to a board whose checks tell of their faults, but for those that are ``silent``."""

    status: Status = NEAR
    near_status: Status = NEAR
    silent: tuple[tuple[int, int], ...] = ()
    # Runs that fail without a trial, by number.
    failing: tuple[int, ...] = ()
    stuck: bool = False
    tried: list[tuple[int, int]] = field(default_factory=list)

    def answer(self, command, payload):
        if command == Command.HELLO and not self.stuck:
            self.status = self.near_status
        if command == Command.RUN:
            self.tried.append(tried := divmod(RunRequest.unpack(payload).trial, WHICHES))
            if (tried[0] and tried not in self.silent) or len(self.tried) in self.failing:
                self.status = replace(NEAR, end=RunEnd.FAULT, flags=Flag.FAULT)
        return super().answer(command, payload)


def self_tested(line):
    board = Board(line)
    board.hello()
    self_test(board)
    return line.tried


def test_every_kind_is_tried_and_what_is_one_of_many_changes():
    found = [self_tested(TriedLine()) for _ in range(40)]
    for tried in found:
        assert tried[0] == (TrialKind.NOTHING, 0)
        count = Counter(kind for kind, _ in tried[1:])
        assert count == {**dict.fromkeys(list(TrialKind)[1:], 1), TrialKind.MEMORY: 13, TrialKind.BOARD: 2}
        assert {(TrialKind.MEMORY, first + memory) for first in (0, SCRUB) for memory in Memory} < set(tried)
        assert (TrialKind.BOARD, WHICHES - 1) in tried
    memories = {one for tried in found for one in tried if one[0] == TrialKind.MEMORY}
    assert len(memories) > 2 * len(Memory) + 5
    for kind in (TrialKind.CLAIM, TrialKind.PARITY, TrialKind.WALK, TrialKind.INTAKE, TrialKind.BOARD):
        assert len({one for tried in found for one in tried if one[0] == kind}) > 5


def test_without_certificates_there_are_none_to_try():
    tried = self_tested(TriedLine(board=replace(BOARD, certifies=0)))
    assert {kind for kind, _ in tried} == {0, *range(TrialKind.MEMORY, TrialKind.BOARD + 1)}


@pytest.mark.parametrize("kind", list(TrialKind)[1:])
def test_a_check_that_does_not_tell_ends_the_use(kind):
    line = TriedLine(silent=tuple((kind, which) for which in range(WHICHES)))
    with pytest.raises(
        LinkError, match=r"the board's check of .* does not tell of .*: do not use it"
    ) as error:
        self_tested(line)
    assert "\n" not in str(error.value) and str(error.value).endswith("verdict unknown")
    assert line.tried[-1][0] == kind


def test_a_fault_without_a_trial_or_that_stays_ends_the_use():
    for line in (TriedLine(failing=(1,)), TriedLine(stuck=True)):
        with pytest.raises(LinkError, match="the board has found a fault in itself"):
            self_tested(line)
    line = TriedLine()
    line.near_status = replace(NEAR, near=0)
    with pytest.raises(LinkError, match="finds a triangle clear of itself"):
        self_tested(line)


def test_a_lost_session_is_begun_again_but_not_for_ever():
    line = TriedLine()
    lost = iter([(Code.BAD_SEQUENCE, b"\x07")])
    line.answers[Command.LOAD] = lambda: next(lost, None) or line.answer(Command.LOAD, LOADS)
    assert len(self_tested(line)) == 1 + len(list(trials(BOARD)))
    line.answers[Command.LOAD] = lambda: (Code.BAD_SEQUENCE, b"\x07")
    with pytest.raises(LinkError, match="BAD_SEQUENCE: state lost"):
        self_tested(line)


@pytest.mark.simulator
def test_the_board_passes():
    with SimulatedTop(simulated_parameters(16, 512)) as top:
        board = Board(SimulatedLine(SimulatedWire(top, 1_200_000)))
        board.hello()
        begun = top.clocks
        self_test(board)
        assert top.go_clocks == 0
        assert top.clocks - begun < 400_000
        assert board.status().count_a == 0
