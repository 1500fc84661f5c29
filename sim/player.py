"""The libraries of Verilated models as Python sees them: what all players share. See player.h."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

# What is wrong with a play, if anything, in the order of player.h.
ASSERTION, HANGS = "assertion", "hangs"
SYMPTOMS = ("", ASSERTION, "does not settle")
# The clock of every simulation; player.h has half of it.
PERIOD_NS = 10
# Registers and memories begin with 0.
ZEROS = -1


@dataclass(frozen=True)
class Register:
    """A register, or a memory of so many elements, of so many bits each; its name is its place."""

    name: str
    elements: int
    bits: int


class Player:
    """A library that is loaded, and the model in it, with the mutant of that number where it holds any."""

    def __init__(self, library: Path, selected: int = 0, initial: int = ZEROS) -> None:
        """Load the library, and make a model; ``initial``: the seed of its registers and memories."""
        self.library: Any = ctypes.CDLL(str(library))
        self.library.triaxis_open.restype = ctypes.c_void_p
        self.library.triaxis_open.argtypes = [ctypes.c_uint32, ctypes.c_int64]
        self.library.triaxis_close.argtypes = [ctypes.c_void_p]
        self.library.triaxis_close.restype = None
        self.model: ctypes.c_void_p | None = None
        self.renew(selected, initial)

    def renew(self, selected: int = 0, initial: int = ZEROS) -> None:
        """Free the model, and make another one."""
        self.free()
        # Not a number: functions whose arguments are not described would take 32 bits of it.
        self.model = ctypes.c_void_p(self.library.triaxis_open(selected, initial))

    def registers(self) -> tuple[Register, ...]:
        """Return the registers and memories, of a build that makes them public."""
        name = self.library.triaxis_register
        name.restype = ctypes.c_char_p
        name.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.POINTER(ctypes.c_int32 * 2)]
        self.library.triaxis_upset.argtypes = [
            ctypes.c_void_p, ctypes.c_int32, ctypes.c_int64, ctypes.c_int32, ctypes.c_int32,
        ]  # fmt: skip
        self.library.triaxis_upset.restype = None
        self.library.triaxis_ignore.argtypes = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int32]
        self.library.triaxis_ignore.restype = None
        self.library.triaxis_state.argtypes = [ctypes.c_void_p]
        self.library.triaxis_state.restype = ctypes.c_uint64
        sizes, found = (ctypes.c_int32 * 2)(), list[Register]()
        while said := name(self.model, len(found), ctypes.byref(sizes)):
            found.append(Register(said.decode(), *sizes))
        return tuple(found)

    def upset(self, kind: int, register: int, element: int, bit: int) -> None:
        """Upset a bit of one of the `registers`, or an element, before the next clock; see registers.h."""
        self.library.triaxis_upset(self.model, kind, register, element, bit)

    def ignore(self, register: int, element: int) -> None:
        """Have `state` say nothing of an element of one of the `registers`."""
        self.library.triaxis_ignore(self.model, register, element)

    def state(self) -> int:
        """Return a hash of all `registers`, but for what is ignored."""
        return self.library.triaxis_state(self.model)

    def free(self) -> None:
        """Free the model."""
        if self.model is not None:
            self.library.triaxis_close(self.model)
            self.model = None

    def __del__(self) -> None:
        """Free the model."""
        if hasattr(self, "model"):
            self.free()

    def write_coverage(self, file: Path) -> None:
        """Write what the model's counters have counted since its first clock in reset; none, nothing."""
        if not hasattr(self.library, "triaxis_coverage"):
            return
        self.library.triaxis_coverage.restype = None
        self.library.triaxis_coverage.argtypes = [ctypes.c_void_p, ctypes.c_char_p]
        self.library.triaxis_coverage(self.model, str(file).encode())


@contextmanager
def followed(library: Any, file: Path) -> Iterator[None]:
    """Write what toggles in the model of a traced build while the block runs to a file: SAIF, at 100 MHz."""
    file.parent.mkdir(parents=True, exist_ok=True)
    library.triaxis_trace.restype = None
    library.triaxis_trace(str(file).encode())
    try:
        yield
    finally:
        library.triaxis_trace(b"")
