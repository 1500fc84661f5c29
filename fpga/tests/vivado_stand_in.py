"""A stand-in for Vivado: really runs the script that it is given, and makes up what the tool would do.

``make_vivado`` writes an executable called vivado. What it does is in `Behaviour`; what the script asked
for is in calls.json beside it.
"""

import json
import os
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

from triaxis.fpga.tests.tcl_stand_in import Recorder

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


def _answers(behaviour: Behaviour, calls: list[tuple[str, ...]]):
    def fails(_: tuple[str, ...]) -> str:
        print(f"ERROR: [Synth 8-439] {behaviour.failing}: module 'x' not found", flush=True)
        raise RuntimeError(behaviour.failing)

    def writes(call: tuple[str, ...]) -> str:
        if "-file" in call:
            Path(call[call.index("-file") + 1]).write_text("report\n")
        return ""

    def slack(call: tuple[str, ...]) -> str:
        kind = _SLACKS[call[call.index("-delay_type") + 1]]
        return "" if getattr(behaviour, kind) is None else f"path_{kind}"

    def summary(call: tuple[str, ...]) -> str:
        return (
            (_MET if behaviour.met else "Timing constraints are not met.")
            if "-return_string" in call
            else writes(call)
        )

    def bitstream(call: tuple[str, ...]) -> str:
        if behaviour.writes_bitstream:
            Path(call[-1]).write_bytes(b"bits")
        return ""

    def messages(call: tuple[str, ...]) -> str:
        assert call == ("-count", "-severity", "CRITICAL WARNING")
        return str(sum(name == behaviour.critical for name, *_ in calls))

    answers = {
        "get_timing_paths": slack,
        "get_property": lambda call: str(getattr(behaviour, call[-1].removeprefix("path_"), "")),
        "get_nets": lambda _: " ".join(f"net{i}" for i in range(behaviour.unrouted)),
        "get_cells": lambda _: "cell_a cell_b",
        "get_msg_config": messages,
        "report_timing_summary": summary,
        "write_bitstream": bitstream,
        "write_checkpoint": lambda call: str(Path(call[-1]).write_text("checkpoint\n") and ""),
    }
    reports = ("utilization", "clock_utilization", "io", "drc", "methodology", "route_status", "power")
    answers |= {f"report_{name}": writes for name in reports}
    return answers | ({behaviour.failing: fails} if behaviour.failing else {})
