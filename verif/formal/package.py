"""The functions and constants of the RTL package, evaluated from its source."""

from functools import cached_property
from pathlib import Path

from pyslang import SVInt
from pyslang.ast import ScriptSession

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT


class Package:
    """``triaxis_pkg`` of a folder of RTL."""

    def __init__(self, dut: Path = DUT) -> None:
        """Remember where the package is."""
        self._path = dut / "core" / "triaxis_pkg.sv"
        self._known: dict[str, int] = {}

    @cached_property
    def _session(self) -> ScriptSession:
        session = ScriptSession()
        session.eval(self._path.read_text(encoding="utf-8"))
        return session

    def constant(self, name: str) -> int:
        """Return a constant; raise InputError where the package has none of that name."""
        return self._evaluate(name)

    def call(self, name: str, *arguments: int) -> int:
        """Return what a function answers; raise InputError where the package has none of that name."""
        return self._evaluate(f"{name}({', '.join(map(str, arguments))})")

    def _evaluate(self, expression: str) -> int:
        if expression not in self._known:
            value = self._session.eval(f"triaxis_pkg::{expression}").value
            if not isinstance(value, SVInt):
                raise InputError(f"{self._path}: {expression} has no value")
            self._known[expression] = int(value)
        return self._known[expression]
