"""A Tcl interpreter in which the commands of Vivado are recorded instead of done, and a stand-in for Vivado.

The stand-in really runs the script that it is given, and makes up what the tool would do. ``make_vivado``
writes an executable called vivado. What it does is in `Behaviour`; what the script asked for is in calls.json
beside it.
"""

import json
import os
import sys
import tkinter
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

VIVADO_COMMANDS = (
    "create_clock", "set_property", "set_false_path", "current_design", "set_part", "read_verilog",
    "read_xdc", "synth_design", "opt_design", "place_design", "phys_opt_design", "route_design",
    "write_checkpoint", "write_bitstream", "read_saif", "report_timing_summary", "report_utilization",
    "report_clock_utilization", "report_io", "report_drc", "report_methodology", "report_route_status",
    "report_power", "get_ports", "get_cells", "get_nets", "get_timing_paths", "get_property",
    "get_msg_config", "create_project", "add_files", "get_files", "current_fileset",
    "update_compile_order", "ipx::package_project", "ipx::current_core", "ipx::get_hdl_parameters",
    "ipx::get_user_parameters", "ipx::get_bus_interfaces", "ipx::remove_bus_interface",
    "ipx::add_bus_interface", "ipx::add_port_map", "ipx::add_bus_parameter", "ipx::check_integrity",
    "ipx::save_core",
)  # fmt: skip

Answers = dict[str, Callable[[tuple[str, ...]], str]]


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
        self.tcl.eval("namespace eval ipx {}")
        for command in VIVADO_COMMANDS:
            self.tcl.createcommand(command, lambda *a, command=command: self._record(command, *a))
        # The real one would end this process; an error ends the script.
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
        raise RuntimeError(status)


_MET = "All user specified timing constraints are met."
_SLACKS = {"max": "setup", "min": "hold"}


@dataclass(frozen=True)
class Behaviour:
    """Slacks in ns (None: no constrained path), nets that are not routed, and what goes wrong.

    ``critical``: the command that gives a critical warning.
    """

    setup: float | None = 0.25
    hold: float | None = 0.05
    met: bool = True
    unrouted: int = 0
    failing: str = ""
    critical: str = ""
    writes_bitstream: bool = True


def make_vivado(folder: Path, behaviour: Behaviour) -> Path:
    """Write an executable that behaves so."""
    folder.mkdir(parents=True, exist_ok=True)
    script = folder / "vivado"
    said = json.dumps(json.dumps(asdict(behaviour)))
    script.write_text(
        f"#!{sys.executable}\n"
        "import json, sys\n"
        "from pathlib import Path\n"
        "from triaxis.fpga.tests.vivado_stand_in import Behaviour, stand_in\n"
        f"sys.exit(stand_in(Behaviour(**json.loads({said})), Path(__file__).parent, sys.argv[1:]))\n"
    )
    script.chmod(0o755)
    return script


def calls(folder: Path) -> list[list[str]]:
    """Return the commands that the script gave."""
    return json.loads((folder / "calls.json").read_text())


def stand_in(behaviour: Behaviour, folder: Path, arguments: list[str]) -> int:
    """Run the script named by ``-source`` with what follows ``-tclargs``; return the exit status."""
    print("****** Vivado v2023.2 (64-bit)", flush=True)
    recorder = Recorder()
    recorder.answers = _answers(behaviour, recorder.calls)
    script = Path(arguments[arguments.index("-source") + 1])
    status = recorder.run(script, arguments[arguments.index("-tclargs") + 1 :])
    # Tcl has a buffer of its own.
    recorder.tcl.eval("flush stdout")
    (folder / "calls.json").write_text(json.dumps([list(call) for call in recorder.calls]))
    (folder / "arguments.json").write_text(json.dumps(arguments))
    sys.stdout.flush()
    os._exit(status)


def _answers(behaviour: Behaviour, calls: list[tuple[str, ...]]) -> Answers:
    def fails(_: tuple[str, ...]) -> str:
        print(f"ERROR: [Synth 8-439] {behaviour.failing}: module 'x' not found", flush=True)
        raise RuntimeError(behaviour.failing)

    def writes(call: tuple[str, ...]) -> str:
        if "-return_string" in call:
            return _MET if behaviour.met else "Timing constraints are not met."
        if "-file" in call:
            Path(call[call.index("-file") + 1]).write_text("report\n")
        return ""

    def slack(call: tuple[str, ...]) -> str:
        kind = _SLACKS[call[call.index("-delay_type") + 1]]
        return "" if getattr(behaviour, kind) is None else f"path_{kind}"

    def bitstream(call: tuple[str, ...]) -> str:
        if behaviour.writes_bitstream:
            Path(call[-1]).write_bytes(b"bits")
        return ""

    answers: Answers = {
        "get_timing_paths": slack,
        "get_property": lambda call: str(getattr(behaviour, call[-1].removeprefix("path_"), "")),
        "get_nets": lambda _: " ".join(f"net{i}" for i in range(behaviour.unrouted)),
        "get_cells": lambda _: "cell_a cell_b",
        "get_msg_config": lambda _: str(sum(name == behaviour.critical for name, *_ in calls)),
        "write_bitstream": bitstream,
        "write_checkpoint": lambda call: str(Path(call[-1]).write_text("checkpoint\n") and ""),
    }
    answers |= {name: writes for name in VIVADO_COMMANDS if name.startswith("report_")}
    return answers | ({behaviour.failing: fails} if behaviour.failing else {})
