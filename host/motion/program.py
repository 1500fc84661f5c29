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
from triaxis.host.motion.moves import Program
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
    here = vector(map(Rational, start or ORIGIN))
    state = Interpreter(here, {"G54": ORIGIN, **zeros}, modal, machine=machine, loaded=machine.loaded)
    memory = Memory(state.ask)
    try:
        _run(Execution(path, memory, skip_optional), state, skip_optional, progress)
        state.end()
    except InputError as error:
        state.tell_refused(error)
    except RecursionError as error:
        raise InputError(f"{path}: expressions or O words nested too deeply: simplify it") from error
    state.tell_refused()
    return state.program(path, start)


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
