"""Programs as files: from their lines to the moves of a tool in millimetres."""

from fractions import Fraction
from pathlib import Path

from triaxis.golden.errors import InputError
from triaxis.golden.exact import Rational
from triaxis.host.engines import Progress, unwatched
from triaxis.host.motion.expression import Memory
from triaxis.host.motion.gcode import Execution
from triaxis.host.motion.interpreter import ORIGIN, Interpreter, Modal
from triaxis.host.motion.machine import Machine
from triaxis.host.motion.moves import LATE_CHANGE, Program, assumed_start, assumed_state
from triaxis.host.motion.program_text import lines_of
from triaxis.host.quantise import Vector, vector

# Lines after which progress is told.
TOLD_AFTER = 1000


def read_program(
    path: Path, start: Vector | None, skip_optional: bool = False, machine: Machine | None = None,
    progress: Progress = unwatched,
) -> Program:  # fmt: skip
    """Read the moves of a program that begins at ``start``, in millimetres; None: nobody has said where.

    ``skip_optional`` leaves out lines that begin with /; ``progress`` is told of lines done. Raises
    InputError, naming file, line and word, at whatever is not understood or stands after the program's end,
    and where there is no move.
    """
    machine = machine or Machine()
    first = machine.offsets.get("G54", ORIGIN)
    zeros = {
        name: vector(Rational(a - b) for a, b in zip(zero, first, strict=True))
        for name, zero in machine.offsets.items()
        if "G54" in machine.offsets
    }
    modal = Modal(tolerance=machine.tolerance or Fraction(0))
    state = Interpreter(
        machine, vector(map(Rational, start or ORIGIN)), {"G54": ORIGIN, **zeros}, machine.loaded, modal
    )
    state.exact_path = machine.tolerance is not None
    memory = Memory(state.ask)
    try:
        _run(Execution(path, memory, skip_optional), state, skip_optional, progress)
        state.end()
    except InputError as error:
        state.tell_refused(error)
    except RecursionError as error:
        raise InputError(f"{path}: expressions or O words nested too deeply: simplify it") from error
    state.tell_refused()
    if not state.moves:
        raise InputError(f"{path}: no moves: a program with at least one G0 or G1 move is needed")
    if start is None:
        state.notes["start"] = assumed_start(state.moves)
    if state_note := assumed_state(lines_of(path), state.moves):
        state.notes["state"] = state_note
    state.notes |= machine.assumed
    changes = (state.loaded or 0, state.changes) != (state.moves[-1].tool, state.moves[-1].changes)
    if changes:
        state.notes["late change"] = LATE_CHANGE
    return Program(path, tuple(state.moves), tuple(state.notes.values()), changes)


def _run(execution: Execution, state: Interpreter, skip_optional: bool, progress: Progress) -> None:
    told = 0
    for block in execution.blocks():
        if block.line >= told + TOLD_AFTER:
            progress(block.line - told)
            told = block.line
        if block.optional:
            done = "left out" if skip_optional else "run"
            state.notes.setdefault("optional", f"lines that begin with / are {done}")
        if block.words and state.run(block):
            execution.refuse_following()
            return
