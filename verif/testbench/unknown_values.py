"""Values that are unknown, in simulators that know of them: put on idle inputs, looked for on outputs."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cocotb.triggers import RisingEdge
from cocotb.types import LogicArray
from pyuvm import uvm_monitor

from triaxis.golden.outputs import write_whole
from triaxis.verif.testbench.reports import ERROR, report
from triaxis.verif.testbench.settings import RunSettings

# Messages a run gives of its unknown values.
_SHOWN = 5


def withdraw(dut: Any, stream: str, settings: RunSettings) -> None:
    """Offer nothing on an input stream; what is on its other pins then must not matter."""
    getattr(dut, f"{stream}_tvalid_i").value = 0
    if settings.four_state:
        for pins in ("tdata_i", "tuser_i"):
            handle = getattr(dut, f"{stream}_{pins}")
            handle.value = LogicArray("X" * len(handle))


def unknown_file(folder: Path) -> Path:
    """Return the file into which a run writes how many values it looked at, and how many were unknown."""
    return folder / "unknown.json"


class UnknownMonitor(uvm_monitor):
    """Counts unknown values of outputs at every edge out of reset, where they count.

    ``outputs``: each output, and the one that must be 1 for it to count; None: it always does. ``reset_n``:
    also a signal of the inside, where the pin is a button.
    """

    dut: Any
    settings: RunSettings
    outputs: Mapping[str, str | None]
    clock: str
    reset_n: str
    looked = unknown = 0

    async def run_phase(self) -> None:
        """Watch."""
        dut, edge = self.dut, RisingEdge(getattr(self.dut, self.clock))
        reset_n = getattr(dut, self.reset_n)
        watched = [
            (name, getattr(dut, name), None if valid is None else getattr(dut, valid))
            for name, valid in self.outputs.items()
        ]
        while True:
            await edge
            if str(reset_n.value) != "1":
                continue
            for name, handle, valid in watched:
                if valid is None or str(valid.value) == "1":
                    self.looked += 1
                    if not handle.value.is_resolvable:
                        self._found(name, str(handle.value))

    def _found(self, name: str, value: str) -> None:
        self.unknown += 1
        if self.unknown <= _SHOWN:
            report(ERROR, f"{name} is unknown out of reset: {value}", "UNKNOWN")
            # At once: what reads such a value as a number ends the run.
            self._write()

    def _write(self) -> None:
        counts = {"looked": self.looked, "unknown": self.unknown}
        write_whole(unknown_file(Path(self.settings.folder)), json.dumps(counts) + "\n")

    def check_phase(self) -> None:
        """Write the counts; fail where a value was unknown."""
        self._write()
        assert self.looked and not self.unknown, f"{self.unknown} unknown values on outputs"
