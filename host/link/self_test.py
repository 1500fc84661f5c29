"""Tries the checks of a board before anything rests on them: each must tell of the fault put before it.

A check that has failed silently would let a second failure through, so a board with one is not used.
"""

import secrets
from collections.abc import Iterator

import numpy as np

from triaxis.host.link.audit import FaultError
from triaxis.host.link.board import Board
from triaxis.host.link.exchange import LinkError, SessionLostError
from triaxis.host.link.messages import (
    SCRUB,
    SCRUB_COMPARISONS,
    SCRUBBED,
    WHICHES,
    Description,
    Flag,
    Memory,
    Mesh,
    Mode,
    RunEnd,
    TrialKind,
    trial_of,
)
from triaxis.sim.packing import PARITIES

# The same triangle as both meshes: near, so that no run of it gives go, whatever does not work.
TRIANGLE = np.array([[[0, 0, 0], [9, 0, 0], [0, 9, 0]]])
# Bits of a pair's number that every board has.
_NUMBER_BITS = 4
_FRAMES = WHICHES - 1
# Frames that come late may undo a session; so many in a row are no accident.
_ATTEMPTS = 3


def trials(board: Description) -> Iterator[tuple[str, int]]:
    """Yield what is tried, in words and as RUN has it: of many bits another one at each start."""
    if board.certifies:
        yield "of the axis of a clear", trial_of(TrialKind.CLAIM, secrets.randbelow(WHICHES))
        yield "of the words in the core", trial_of(TrialKind.PARITY, secrets.choice(PARITIES))
        yield "of the order of pairs", trial_of(TrialKind.NUMBER, secrets.randbelow(_NUMBER_BITS))
    for memory in Memory:
        yield f"of the memory {memory.name}", trial_of(TrialKind.MEMORY, memory)
        yield f"between runs of the memory {memory.name}", trial_of(TrialKind.MEMORY, SCRUB + memory)
    comparison = secrets.randbelow(SCRUB_COMPARISONS)
    yield "between runs of what was loaded", trial_of(TrialKind.MEMORY, SCRUBBED + comparison)
    yield "of one scan by another", trial_of(TrialKind.WALK, secrets.randbelow(WHICHES))
    yield "of one intake by another", trial_of(TrialKind.INTAKE, secrets.randbelow(WHICHES))
    yield "of one runner by another", trial_of(TrialKind.BOARD, secrets.randbelow(_FRAMES))
    yield "of the bytes of frames", trial_of(TrialKind.BOARD, _FRAMES)


def self_test(board: Board, attempts: int = _ATTEMPTS) -> None:
    """Try each kind of check once, and empty the board again; it must be in our hands, after `Board.hello`.

    Raises LinkError where one does not tell of its fault, or one stands without.
    """
    try:
        _begin(board)
        status = board.run(Mode.COUNT, 0).status
        if status.flags & Flag.FAULT:
            raise FaultError
        if status.near != 1:
            raise LinkError("the board finds a triangle clear of itself: do not use it; verdict unknown")
        for check, trial in trials(board.description):
            _begin(board)
            _try(board, check, trial)
        board.begin_again()
        if board.status().flags & Flag.FAULT:
            raise FaultError
        return
    except SessionLostError:
        if attempts == 1:
            raise
    board.take_again()
    self_test(board, attempts - 1)


def _begin(board: Board) -> None:
    board.begin_again()
    for mesh in Mesh:
        board.load(mesh, TRIANGLE)


def _try(board: Board, check: str, trial: int) -> None:
    status = board.run(Mode.COUNT, 0, trial=trial).status
    if not status.flags & Flag.FAULT:
        # Two triangles have been scrubbed long before another frame comes.
        status = board.status()
    if status.end != RunEnd.FAULT or not status.flags & Flag.FAULT:
        raise LinkError(
            f"the board's check {check} does not tell of the fault put before it (trial {trial:#04x}): do "
            "not use it; load the bitstream again, and where that does not help, take another board; "
            "verdict unknown"
        )
