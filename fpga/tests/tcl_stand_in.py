"""A Tcl interpreter in which the commands of Vivado are recorded instead of done."""

import tkinter
from collections.abc import Callable
from pathlib import Path

VIVADO_COMMANDS = (
    "create_clock", "set_property", "set_false_path", "current_design", "set_part", "read_verilog",
    "read_xdc", "synth_design", "opt_design", "place_design", "phys_opt_design", "route_design",
    "write_checkpoint", "write_bitstream", "read_saif", "report_timing_summary", "report_utilization",
    "report_clock_utilization", "report_io", "report_drc", "report_methodology", "report_route_status",
    "report_power", "get_ports", "get_cells", "get_nets", "get_timing_paths", "get_property",
    "get_msg_config",
)  # fmt: skip

Answers = dict[str, Callable[[tuple[str, ...]], str]]


class ExitedError(Exception):
    """The script called exit."""

    def __init__(self, status: int) -> None:
        super().__init__(f"exit {status}")
        self.status = status


class Recorder:
    """Runs Tcl; ``calls`` are the Vivado commands that it gave, in order, with their arguments.

    ``answers`` says what a command returns for its arguments; otherwise nothing, and for the ``get_``
    commands their last argument.
    """

    def __init__(self, answers: Answers | None = None) -> None:
        self.calls: list[tuple[str, ...]] = []
        self.tcl = tkinter.Tcl()
        self.answers = answers or {}
        self._status: int | None = None
        for command in VIVADO_COMMANDS:
            self.tcl.createcommand(command, lambda *a, command=command: self._record(command, *a))
        # The real one would end this process.
        self.tcl.createcommand("exit", self._exit)
        # Anything else unknown is an error, and not looked for on PATH.
        self.tcl.eval('proc unknown {args} {error "invalid command name [lindex $args 0]"}')

    def split(self, value: str) -> tuple[str, ...]:
        """Return the elements of a Tcl list."""
        return tuple(map(str, self.tcl.splitlist(value)))

    def run(self, script: Path, arguments: list[str] | None = None) -> int:
        """Run a script; return its exit status, 1 where it fails as Vivado's batch mode does."""
        self.tcl.setvar("argv", "")
        for argument in arguments or []:
            self.tcl.call("lappend", "argv", argument)
        try:
            self.tcl.eval(f"source {{{script}}}")
        except tkinter.TclError as error:
            if self._status is None:
                print(f"ERROR: {error}")
                return 1
        return self._status or 0

    def _record(self, command: str, *arguments: str) -> str:
        call = tuple(map(str, arguments))
        self.calls.append((command, *call))
        if command in self.answers:
            return self.answers[command](call)
        return call[-1] if command.startswith("get_") and call else ""

    def _exit(self, status: str = "0") -> None:
        self._status = int(status)
        raise ExitedError(self._status)
