"""The build script and the constraints, really run by Tcl with the commands of Vivado recorded."""

import contextlib
import math
import re
import subprocess
import time
import tomllib
from itertools import pairwise
from pathlib import Path

import pytest

from triaxis.fpga.bitstream import STAGES, RefusedError, run_vivado
from triaxis.fpga.board_build import (
    BUILD_SCRIPT,
    CONSTRAINTS,
    FPGA,
    PART,
    SIGNED_OFF,
    TOP,
    VIVADO,
    Inputs,
    generics,
)
from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT

pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")

from triaxis.fpga.tests.vivado_stand_in import Behaviour, Recorder, calls, make_vivado

REPORTS = (
    "timing", "utilisation", "utilisation_hierarchy", "power", "drc", "methodology", "route_status", "io",
)  # fmt: skip


def build(tmp_path, behaviour=None, activity=False, progress=None):
    # What Tcl would read otherwise must not matter.
    source, saif = tmp_path / "a [b] {c $d.sv", tmp_path / "activity.saif"
    source.write_text("module a; endmodule\n")
    inputs = Inputs((source,), (tmp_path,), generics(SIGNED_OFF, 0xDEADBEEF), saif if activity else None)
    vivado = make_vivado(tmp_path / "bin", behaviour or Behaviour())
    return run_vivado(vivado, inputs, tmp_path / "out", progress)


def commands(tmp_path):
    return [call[0] for call in calls(tmp_path / "bin")]


def test_a_build_that_is_in_time(tmp_path):
    steps = []
    result = build(tmp_path, progress=steps.append, activity=True)
    assert result.bitstream == tmp_path / "out" / f"{TOP}.bit" and result.bitstream.read_bytes() == b"bits"
    figures = {name: result.figures[name] for name in ("wns_ns", "whs_ns", "dsps")}
    assert figures == {"wns_ns": 0.25, "whs_ns": 0.05, "dsps": 2}
    assert len(steps) == len(STAGES)
    assert all((tmp_path / "out" / f"{name}.rpt").exists() for name in REPORTS)
    asked = commands(tmp_path)
    flow = [name for name in asked if name.endswith("_design") and not name.startswith("get")]
    assert flow == ["synth_design", "opt_design", "place_design", "phys_opt_design", "route_design"]
    assert asked.index("read_saif") < asked.index("report_power") and asked[-1] == "write_bitstream"
    said = {call[0]: call for call in calls(tmp_path / "bin")}
    synthesis, saif = said["synth_design"], said["read_saif"]
    given = {value for option, value in pairwise(synthesis) if option == "-generic"}
    sizes = {"W=16", "M=16", "Depth=4096", "Group=8", "Lanes=8"}
    times = {f"{name}={value}" for name, value in SIGNED_OFF.rtl.items() if name.endswith(("Clocks", "Bits"))}
    assert len(times) == 5 and given == {*sizes, *times, "Certify=1'b1", "BuildId=32'hdeadbeef"}
    assert (synthesis[synthesis.index("-part") + 1], synthesis[synthesis.index("-top") + 1]) == (PART, TOP)
    assert (saif[saif.index("-strip_path") + 1], saif[-1]) == (TOP, str(tmp_path / "activity.saif"))
    assert said["read_xdc"][-1] == str(CONSTRAINTS)
    assert Recorder().split(said["read_verilog"][-1]) == (str(tmp_path / "a [b] {c $d.sv"),)


@pytest.mark.parametrize(
    ("behaviour", "reason"),
    [
        (Behaviour(setup=-0.001), "worst slack -0.001 ns"),
        (Behaviour(hold=-0.02), "worst hold slack -0.02 ns"),
        (Behaviour(met=False), "not all constraints are met"),
        (Behaviour(setup=None), "no constrained path"),
        (Behaviour(hold=None), "no constrained path"),
        # Of a path without a constraint.
        (Behaviour(setup=math.inf), "no constrained path"),
        (Behaviour(hold=math.inf), "no constrained path"),
        (Behaviour(setup=math.nan), "no constrained path"),
        (Behaviour(unrouted=2), "2 nets are not routed"),
    ],
)
def test_no_bitstream_where_timing_or_routing_is_not_met(tmp_path, behaviour, reason):
    old = tmp_path / "out" / f"{TOP}.bit"
    old.parent.mkdir()
    old.write_bytes(b"older")
    with pytest.raises(RefusedError, match=reason):
        build(tmp_path, behaviour)
    assert "write_bitstream" not in commands(tmp_path)
    assert not old.exists()
    assert (tmp_path / "out" / "timing.rpt").exists() or "no constrained" in reason


def test_no_bitstream_after_a_critical_warning(tmp_path):
    for command in ("read_xdc", "synth_design", "place_design"):
        with pytest.raises(RefusedError, match=r"1 critical warnings?: .*log"):
            build(tmp_path, Behaviour(critical=command))
        assert "write_bitstream" not in commands(tmp_path)
        # A constraint that was not understood is found before hours of placement.
        assert ("place_design" in commands(tmp_path)) == (command == "place_design")


def test_a_failure_of_the_tool_is_its_first_error(tmp_path):
    for command in ("synth_design", "report_drc", "write_bitstream"):
        with pytest.raises(InputError, match=rf"vivado: ERROR: \[Synth 8-439\] {command}: .*vivado.log"):
            build(tmp_path, Behaviour(failing=command))
    with pytest.raises(InputError, match="no bitstream, exit status 0"):
        build(tmp_path, Behaviour(writes_bitstream=False))


def test_an_interrupt_ends_vivado_and_what_it_started(tmp_path):
    slow, started = tmp_path / "vivado", tmp_path / "child"
    slow.write_text(f"#!/bin/sh\nsleep 600 &\necho $! > {started}\necho triaxis: stage: synthesis\nwait\n")
    slow.chmod(0o755)

    def interrupt(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        run_vivado(slow, Inputs((), ()), tmp_path / "out", interrupt)
    status = Path(f"/proc/{int(started.read_text())}/stat")
    end = time.monotonic() + 600
    # Gone, or dead and not yet collected.
    with contextlib.suppress(OSError):
        while status.read_text().split()[2] != "Z":
            assert time.monotonic() < end
            time.sleep(0.05)


@pytest.mark.parametrize(
    ("options", "status", "says"),
    [
        ({"part": "x"}, 1, "ERROR: .*top is missing"),
        ({"part": "x", "speed": "fast"}, 1, "ERROR: .*speed=fast: no such option"),
        ({"part": "x\npart=y"}, 1, "ERROR: .*part=y: part is given twice"),
        ({"part": PART, "top": TOP, "source": "a.sv", "xdc": "a.xdc"}, 3, "triaxis: refused: timing"),
    ],
)
def test_by_itself_the_script_checks_its_options_and_removes_an_older_bitstream(
    tmp_path, options, status, says
):
    vivado, file = make_vivado(tmp_path, Behaviour(setup=-1)), tmp_path / "options.txt"
    file.write_text("".join(f"{name}={value}\n" for name, value in {**options, "out": tmp_path}.items()))
    command = [str(vivado), "-source", str(BUILD_SCRIPT), "-tclargs", str(file)]
    old = tmp_path / f"{TOP}.bit"
    old.write_bytes(b"older")
    answer = subprocess.run(command, capture_output=True, text=True, check=False)
    assert answer.returncode == status and re.search(says, answer.stdout)
    assert old.exists() is (status == 1)


def test_scripts_are_plain_ascii_and_name_every_stage():
    for path in VIVADO.iterdir():
        assert path.read_text(encoding="utf-8").isascii()
    assert all(re.search(rf"^\s*stage {name}$", BUILD_SCRIPT.read_text(), re.MULTILINE) for name in STAGES)


BOARD = tomllib.loads((FPGA / "nexys4ddr_pins.toml").read_text())


def by_bit(names):
    """Return what each name has, by bit where it has several: ``{"LED[0]": "H17", ..}``."""
    several = {name: values for name, values in names.items() if not isinstance(values, str)}
    bits = {f"{name}[{bit}]": value for name, values in several.items() for bit, value in enumerate(values)}
    return {name: value for name, value in names.items() if name not in several} | bits


# The pins as the board's maker publishes them; a port may be on a whole vector of the board.
PINS = by_bit(BOARD["pins"])
WHOLE = {name: list(by_bit({name: pins})) for name, pins in BOARD["pins"].items() if isinstance(pins, list)}
NAMES = {port: WHOLE.get(str(name), name) for port, name in BOARD["ports"].items()}
PORTS = {port: PINS[name] for port, name in by_bit(NAMES).items()}


def constraints(path=CONSTRAINTS):
    """Run constraints: all calls, and a function that returns (port, value) wherever a property is set."""
    recorder = Recorder()
    assert recorder.run(path) == 0

    def properties(wanted):
        found = []
        for command, *arguments in recorder.calls:
            if command == "set_property" and arguments[-1]:
                words = recorder.split(arguments[1]) if arguments[0] == "-dict" else tuple(arguments[:2])
                pairs = zip(words[::2], words[1::2], strict=True)
                found += [(arguments[-1], value) for name, value in pairs if name == wanted]
        return sorted(found)

    return recorder.calls, properties


def test_every_port_is_on_its_published_pin_once_with_the_standard_of_its_bank():
    calls, properties = constraints()
    assert BOARD["part"] == PART and len(set(PINS.values())) == len(PINS)
    assert (PINS["CLK100MHZ"], PINS["LED[15]"], PORTS["seg_no[7]"]) == ("E3", "V11", PINS["DP"])
    assert properties("PACKAGE_PIN") == sorted(PORTS.items())
    assert properties("IOSTANDARD") == [(port, BOARD["io_standard"]) for port in sorted(PORTS)]
    # Go falls and stop rises where nothing drives them.
    pulls = {"stop_o": "PULLUP", "uart_rx_i": "PULLUP"}
    pulls |= dict.fromkeys(("go_o", "beat_o", "beyond_slow_o", "beyond_warn_o"), "PULLDOWN")
    assert dict(properties("PULLTYPE")) == pulls
    assert ("set_property", "CFGBVS", "VCCO", "") in calls
    assert ("set_property", "CONFIG_VOLTAGE", "3.3", "") in calls
    (clock,) = [call for call in calls if call[0] == "create_clock"]
    assert clock[-1] == "clk_100mhz_i"
    assert float(clock[clock.index("-period") + 1]) == 1000 / BOARD["clock_mhz"]
    # All other pins are declared asynchronous.
    paths = {port: call[1] for call in calls if call[0] == "set_false_path" for port in call[2].split()}
    named = {port.partition("[")[0] for port in PORTS} - {"clk_100mhz_i"}
    assert {port.removesuffix("[*]") for port in paths} == named
    assert all(way == ("-from" if port.endswith("i") else "-to") for port, way in paths.items())
    declared = re.findall(
        r"^\s*(?:input|output)\s+(?:logic\s+)?(?:\[(\d+):0\]\s*)?(\w+)\s*,?\s*(?://.*)?$",
        (DUT / "board" / f"{TOP}.sv").read_text(),
        re.MULTILINE,
    )
    widths = {name: int(high) + 1 if high else 0 for high, name in declared}
    bits = {f"{name}[{i}]" for name, width in widths.items() for i in range(width)}
    assert bits | {name for name, width in widths.items() if not width} == PORTS.keys()


def test_a_wrong_pin_is_seen(tmp_path):
    text, broken = CONSTRAINTS.read_text(), tmp_path / "broken.xdc"
    for old, new in (
        ("PACKAGE_PIN C17", "PACKAGE_PIN C16"),
        ("{led_o[3]}", "{led_o[4]}"),
        ("[get_ports {stop_o}]", "[get_ports {stop}]"),
    ):
        assert text.count(old) == 1
        broken.write_text(text.replace(old, new))
        assert constraints(broken)[1]("PACKAGE_PIN") != sorted(PORTS.items())
