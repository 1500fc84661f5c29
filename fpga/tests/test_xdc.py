"""The pins as the board's maker publishes them; the constraints, run as Tcl: every port once, on its pin."""

import re
import tomllib

import pytest

from triaxis.fpga.board_build import CONSTRAINTS, FPGA, PART, TOP_RTL

pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")

from triaxis.fpga.tests.vivado_stand_in import Recorder

BOARD = tomllib.loads((FPGA / "nexys4ddr_pins.toml").read_text())


def by_bit(names):
    """Return what each name has, by bit where it has several: ``{"LED[0]": "H17", ..}``."""
    found = {}
    for name, values in names.items():
        if isinstance(values, str):
            found[name] = values
        else:
            found |= {f"{name}[{bit}]": value for bit, value in enumerate(values)}
    return found


PINS = by_bit(BOARD["pins"])
WHOLE = {name: list(by_bit({name: pins})) for name, pins in BOARD["pins"].items() if isinstance(pins, list)}
# A port may be on a whole vector of the board.
NAMES = {
    port: name if isinstance(name, list) else WHOLE.get(name, name) for port, name in BOARD["ports"].items()
}
PORTS = {port: PINS[name] for port, name in by_bit(NAMES).items()}


def test_what_is_published():
    assert BOARD["part"] == PART and BOARD["source"].startswith("https://github.com/Digilent/")
    assert (PINS["CLK100MHZ"], PINS["LED[15]"], PORTS["seg_no[7]"]) == ("E3", "V11", PINS["DP"])
    assert all(re.fullmatch(r"[A-HJ-NPRT-V]\d{1,2}", pin) for pin in PINS.values())
    assert len(set(PINS.values())) == len(PINS)


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
    assert sorted(port_properties(recorder, "PACKAGE_PIN")) == sorted(PORTS.items())
    assert len(set(PORTS.values())) == len(PORTS)
    assert sorted(port_properties(recorder, "IOSTANDARD")) == [
        (p, BOARD["io_standard"]) for p in sorted(PORTS)
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
    assert float(clock[clock.index("-period") + 1]) == 1000 / BOARD["clock_mhz"]


def test_all_other_pins_are_declared_asynchronous():
    calls = [call for call in constrained().calls if call[0] == "set_false_path"]
    named = {re.sub(r"\[\*\]", "", port) for call in calls for port in call[2].split()}
    assert named == {port.partition("[")[0] for port in PORTS} - {"clk_100mhz_i"}
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
    assert sorted(port_properties(constrained(broken), "PACKAGE_PIN")) != sorted(PORTS.items())


def test_the_constraints_name_the_ports_of_the_top():
    declared = re.findall(
        r"^\s*(?:input|output)\s+(?:logic\s+)?(?:\[(\d+):0\]\s*)?(\w+)\s*,?\s*(?://.*)?$",
        TOP_RTL.read_text(),
        re.MULTILINE,
    )
    bits = {
        name if not high else f"{name}[{i}]" for high, name in declared for i in range(int(high or 0) + 1)
    }
    assert bits == PORTS.keys()
