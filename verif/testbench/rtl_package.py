"""A package of the RTL, evaluated: its constants, and what its functions answer."""

from functools import cached_property
from pathlib import Path

from pyslang import SVInt
from pyslang.ast import ScriptSession

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT

CORE_PACKAGE = "core/triaxis_pkg.sv"


class Package:
    """A package of a folder of RTL."""

    def __init__(self, dut: Path = DUT, file: str = CORE_PACKAGE) -> None:
        """Remember where the package is."""
        self._path = dut / file
        self._known: dict[str, int] = {}

    @cached_property
    def _session(self) -> ScriptSession:
        session = ScriptSession()
        session.eval(self._path.read_text(encoding="utf-8"))
        return session

    def call(self, name: str, *arguments: int) -> int:
        """Return a constant, or what a function answers; InputError where the package has none so called."""
        expression = f"{name}({', '.join(map(str, arguments))})" if arguments else name
        if expression not in self._known:
            value = self._session.eval(f"{self._path.stem}::{expression}").value
            if not isinstance(value, SVInt):
                raise InputError(f"{self._path}: {expression} has no value")
            self._known[expression] = int(value)
        return self._known[expression]
