"""The board's safety module alone: any history of what happens to it, and what it must then say.

Also its mutants: one for each condition, without that condition.
"""

import ctypes
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from triaxis.golden.errors import InputError
from triaxis.sim.models import safety_build
from triaxis.sim.verilate import library

COMPLETE = 1
_FILE = "triaxis_safety.sv"
_PORTS = "    input logic rst_ni,\n"

# Bits of a clock's events, as safety.cpp takes them.
HELLO, LOAD, MOVE, RUN, ABORT, LINK_ERROR, REFUSED, ALIVE, DONE = (1 << bit for bit in range(9))
STATUS_SHIFT = 9
NEAR, RESET = 1 << 12, 1 << 13

GO, STOP = 1, 2

Words = npt.NDArray[np.uint16]


@dataclass(frozen=True)
class Mutant:
    """In the expression assigned to ``target``, ``operand`` is replaced."""

    target: str
    operand: str
    replacement: str


def _without(target: str, neutral: str, *operands: str) -> list[Mutant]:
    return [Mutant(target, operand, neutral) for operand in operands]


MUTANTS: tuple[Mutant, ...] = (
    *_without("changed", "1'b0", "hello_i", "load_i", "move_i", "run_i", "abort_i"),
    *_without("fault", "1'b0", "link_error_i", "refused_i", "!alive_i"),
    *_without("clear", "1'b1", "done_i", "engine_status_i == StatusComplete", "near_i == '0"),
    *_without("armed_d", "1'b0", "run_i", "armed_q"),
    *_without("armed_d", "1'b1", "armed_q", "!changed", "!fault"),
    *_without("go_d", "1'b0", "go_q", "clear"),
    *_without("go_d", "1'b1", "armed_q", "clear", "!changed", "!fault"),
    *_without("go_o", "1'b1", "go_q"),
    *_without("stop_o", "1'b0", "stop_q"),
)


def mutated(rtl: Path, folder: Path) -> Path:
    """Write the safety module with all mutants, chosen by an input, to ``folder``; return ``folder``.

    Raises InputError where a mutant's condition is not, or more than once, in its expression.
    """
    text = (rtl / _FILE).read_text(encoding="utf-8")
    text = text.replace(_PORTS, _PORTS + "    input logic [7:0] mutant_i,\n")
    for target in dict.fromkeys(mutant.target for mutant in MUTANTS):
        pattern = re.compile(rf"^  assign {target}\s*= (.*?);$", re.MULTILINE | re.DOTALL)
        found = pattern.findall(text)
        if len(found) != 1:
            raise InputError(f"{rtl / _FILE}: {target}: must be assigned once, not {len(found)} times")
        text = pattern.sub(lambda match, target=target: _selected(target, match[1]), text)
    (folder / _FILE).write_text(text, encoding="utf-8")
    return folder


def _selected(target: str, expression: str) -> str:
    """Return the assignment with the mutants of one expression ahead of it."""
    selected = expression
    for number, mutant in enumerate(MUTANTS, 1):
        if mutant.target != target:
            continue
        if len(re.findall(rf"(?<!\w){re.escape(mutant.operand)}(?!\w)", expression)) != 1:
            raise InputError(f"{_FILE}: {target}: {mutant.operand}: must be there once")
        changed = expression.replace(mutant.operand, mutant.replacement)
        selected = f"mutant_i == 8'd{number} ? ({changed}) : ({selected})"
    return f"  assign {target} = {selected};"


class SafetyModule:
    """The Verilated module; ``rtl`` a folder with its file, as it is or `mutated`."""

    def __init__(self, rtl: Path) -> None:
        """Build it where needed."""
        self._run = ctypes.CDLL(str(library(safety_build(rtl)))).safety_run
        self._run.restype = ctypes.c_int
        self._run.argtypes = [ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_int64]

    def run(self, events: Words, mutant: int = 0) -> tuple[int, npt.NDArray[np.uint8]]:
        """Return what the outputs say at power-up, and after each clock of ``events`` (N,).

        ``mutant``: a number from 1 in MUTANTS, 0 for none.
        """
        events = np.ascontiguousarray(events, np.uint16)
        outputs = np.zeros(len(events), np.uint8)
        before = self._run(mutant, events.ctypes.data, outputs.ctypes.data, len(events))
        return before, outputs


def allowed(events: Words) -> npt.NDArray[np.bool_]:
    """Return after which clocks of ``events`` (N,) the board must say go.

    The last clock in which anything but the end of a run happened must have begun a run and been without
    fault, and a complete clear end must have come since.
    """
    faults = (events & (LINK_ERROR | REFUSED | RESET) != 0) | (events & ALIVE == 0)
    disturbed = faults | (events & (HELLO | LOAD | MOVE | RUN | ABORT) != 0)
    clear = (events & DONE != 0) & (events >> STATUS_SHIFT & 7 == COMPLETE) & (events & NEAR == 0)
    clock = np.arange(len(events))
    last = np.maximum.accumulate(np.where(disturbed, clock, -1))
    last_clear = np.maximum.accumulate(np.where(clear, clock, -1))
    begun = (events[last] & RUN != 0) & ~faults[last] & (last >= 0)
    return begun & (last_clear > last)


def random_events(rng: np.random.Generator, count: int) -> Words:
    """Return a history (count,) in which each thing happens now and then, several at once as well."""
    rates = {
        HELLO: 0.01, LOAD: 0.01, MOVE: 0.01, RUN: 0.15, ABORT: 0.01, LINK_ERROR: 0.01, REFUSED: 0.01,
        ALIVE: 0.99, DONE: 0.3, NEAR: 0.2, RESET: 0.005,
    }  # fmt: skip
    events = sum(np.where(rng.random(count) < rate, bit, 0) for bit, rate in rates.items())
    status = np.where(rng.random(count) < 0.7, COMPLETE, rng.integers(0, 8, count))
    return (events + (status << STATUS_SHIFT)).astype(np.uint16)
