"""The pins as the board's maker publishes them; the constraints, run as Tcl: every port once, on its pin."""

import re

import pytest

from triaxis.fpga.board_build import CONSTRAINTS, PART, PINS, TOP_RTL, read_pins
from triaxis.golden.errors import InputError

pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")

from triaxis.fpga.tests.vivado_stand_in import Recorder

BOARD = read_pins()


def test_what_is_published():
    assert BOARD.part == PART and BOARD.source.startswith("https://github.com/Digilent/")
    assert (BOARD.pins["CLK100MHZ"], BOARD.pins["LED[15]"]) == ("E3", "V11")
    assert BOARD.ports["seg_no[7]"] == BOARD.pins["DP"]
    assert all(re.fullmatch(r"[A-HJ-NPRT-V]\d{1,2}", pin) for pin in BOARD.pins.values())


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ('JA2 = "D18"', 'JA2 = "C17"', "C17: given to more than one name"),
        ('go_o = "JA1"', 'go_o = "JZ1"', "go_o: no such pin"),
        ('"CF", "CG", "DP"]', '"CF", "CG", "DQ"]', r"port seg_no\[7\]: no pin called DQ"),
    ],
)
def test_wrong_data_is_one_clear_error(tmp_path, old, new, says):
    text = PINS.read_text()
    assert text.count(old) == 1
    path = tmp_path / "pins.toml"
    path.write_text(text.replace(old, new))
    with pytest.raises(InputError, match=says):
        read_pins(path)


def constrained(path=CONSTRAINTS):
    recorder = Recorder()
    assert recorder.run(path) == 0
    return recorder


def port_properties(recorder, wanted):
    """Return (port, value) of a property, of all ports for which it is set."""
    found = []
    for command, *arguments in recorder.calls:
        if command != "set_property" or arguments[-1] == "":
            continue
        settings = recorder.split(arguments[1]) if arguments[0] == "-dict" else tuple(arguments[:2])
        pairs = zip(settings[::2], settings[1::2], strict=True)
        found += [(arguments[-1], value) for name, value in pairs if name == wanted]
    return found


def test_every_port_is_on_its_published_pin_once_and_has_the_standard_of_its_bank():
    recorder = constrained()
    assert sorted(port_properties(recorder, "PACKAGE_PIN")) == sorted(BOARD.ports.items())
    assert len(set(BOARD.ports.values())) == len(BOARD.ports)
    assert sorted(port_properties(recorder, "IOSTANDARD")) == [
        (p, BOARD.io_standard) for p in sorted(BOARD.ports)
    ]
    # Go falls and stop rises where nothing drives them.
    pulls = dict(port_properties(recorder, "PULLTYPE"))
    assert pulls == {"go_o": "PULLDOWN", "stop_o": "PULLUP", "beat_o": "PULLDOWN", "uart_rx_i": "PULLUP"}


def test_clock_and_configuration_voltage():
    calls = constrained().calls
    assert ("set_property", "CFGBVS", "VCCO", "") in calls
    assert ("set_property", "CONFIG_VOLTAGE", "3.3", "") in calls
    (clock,) = [call for call in calls if call[0] == "create_clock"]
    assert clock[-1] == "clk_100mhz_i"
    assert float(clock[clock.index("-period") + 1]) == 1000 / BOARD.clock_mhz


def test_all_other_pins_are_declared_asynchronous():
    calls = [call for call in constrained().calls if call[0] == "set_false_path"]
    named = {re.sub(r"\[\*\]", "", port) for call in calls for port in call[2].split()}
    assert named == {port.partition("[")[0] for port in BOARD.ports} - {"clk_100mhz_i"}
    directions = {port: call[1] for call in calls for port in call[2].split()}
    assert all(way == ("-from" if port.endswith("i") else "-to") for port, way in directions.items())


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("PACKAGE_PIN C17", "PACKAGE_PIN C16"),
        ("{led_o[3]}", "{led_o[4]}"),
        ("PACKAGE_PIN C12", "PACKAGE_PIN E3"),
        ("[get_ports {stop_o}]", "[get_ports {stop}]"),
    ],
)
def test_a_wrong_pin_is_seen(tmp_path, old, new):
    text = CONSTRAINTS.read_text()
    assert text.count(old) == 1
    broken = tmp_path / "broken.xdc"
    broken.write_text(text.replace(old, new))
    assert sorted(port_properties(constrained(broken), "PACKAGE_PIN")) != sorted(BOARD.ports.items())


def test_the_constraints_name_the_ports_of_the_top():
    declared = re.findall(
        r"^\s*(?:input|output)\s+(?:logic\s+)?(?:\[(\d+):0\]\s*)?(\w+)\s*,?\s*(?://.*)?$",
        TOP_RTL.read_text(),
        re.MULTILINE,
    )
    bits = {
        name if not high else f"{name}[{i}]" for high, name in declared for i in range(int(high or 0) + 1)
    }
    assert bits == BOARD.ports.keys()
