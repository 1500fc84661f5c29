import json

import pytest

from triaxis.fpga import ecp5_timing
from triaxis.fpga.ecp5_timing import (
    TARGET_MHZ,
    TOP,
    Absorbed,
    absorb_registers,
    read_timing,
    route,
    write_timing,
)
from triaxis.golden.errors import InputError


def _register(d, q, clock=2, **changes):
    pins = {"DI": [d], "Q": [q], "CLK": [clock], "LSR": ["0"]} | changes.pop("pins", {})
    return {
        "type": "TRELLIS_FF",
        "parameters": {"CEMUX": "1 ", "CLKMUX": "CLK", "LSRMUX": "LSR"} | changes,
        "port_directions": {pin: "output" if pin == "Q" else "input" for pin in pins},
        "connections": pins,
    }


def _multiplier(**pins):
    return {
        "type": "MULT18X18D",
        "parameters": {},
        "port_directions": {pin: "output" if pin.startswith("P") else "input" for pin in pins},
        "connections": {pin: [net] for pin, net in pins.items()},
    }


def _module(**replaced):
    """Two bits of A, one of B, one of P, with a register at each; 20 is an output of the module."""
    cells = {
        "a0": _register(10, 11),
        "a1": _register(12, 13),
        "b0": _register(14, 15),
        "mul": _multiplier(A0=11, A1=13, A2=13, A3="0", B0=15, P0=16, P1=17),
        "p0": _register(16, 20),
    }
    return {"cells": cells | replaced, "ports": {"out": {"bits": [20]}}}


def test_registers_move_into_the_block():
    module = _module()
    assert absorb_registers(module) == Absorbed(blocks=1, before=1, behind=1)
    assert list(module["cells"]) == ["mul"]
    block = module["cells"]["mul"]
    pins = {pin: nets[0] for pin, nets in block["connections"].items()}
    assert pins == {
        "A0": 10, "A1": 12, "A2": 12, "A3": "0", "B0": 14, "P0": 20, "P1": 17,
        "CLK0": 2, "CE0": "1", "RST0": "0",
    }  # fmt: skip
    assert block["parameters"]["REG_INPUTA_CLK"] == block["parameters"]["REG_OUTPUT_CLK"] == "CLK0"


@pytest.mark.parametrize(
    ("replaced", "moved", "stays"),
    [
        # Others need the register, or the product as it is.
        ({"other": _register(11, 30), "more": _register(30, 20)}, (1, 1), "a0"),
        ({"other": _register(16, 20)}, (1, 0), "p0"),
        # An enable, a reset, another edge, another clock.
        ({"a0": _register(10, 11, CEMUX="CE", pins={"CE": [40]})}, (0, 1), "a0"),
        ({"a0": _register(10, 11, pins={"LSR": [41]})}, (0, 1), "a0"),
        ({"a0": _register(10, 11, clock=3)}, (0, 1), "a0"),
    ],
)
def test_registers_that_must_stay(replaced, moved, stays):
    module = _module(**replaced)
    absorbed = absorb_registers(module)
    assert (absorbed.before, absorbed.behind) == moved
    assert stays in module["cells"]


def _step(kind, cell, ns, net=""):
    return {"type": kind, "to": {"cell": cell}, "delay": ns, "net": net}


def _report(tmp_path, mhz):
    clock = "$glbnet$clk"
    path = [
        _step("clk-to-q", "u_a.x_q_TRELLIS_FF_Q_14", 0.5),
        _step("routing", "s_CCU2C_S0", 2.0, "u_a.x_q[3]"),
        _step("logic", "s_CCU2C_S0", 0.5),
        _step("routing", "s_CCU2C_S0_1", 0.0, "carry"),
        _step("logic", "s_CCU2C_S0_1", 0.5),
        _step("routing", "u_b.y_q_TRELLIS_FF_Q", 1.0, "sum"),
        _step("setup", "u_b.y_q_TRELLIS_FF_Q", 0.25),
    ]
    content = {
        "fmax": {clock: {"achieved": mhz, "constraint": 100}},
        "critical_paths": [
            {"from": "<async>", "to": f"posedge {clock}", "path": []},
            {"from": f"posedge {clock}", "to": f"posedge {clock}", "path": path},
        ],
        "utilization": {"MULT18X18D": {"available": 156, "used": 120}, "DTR": {"available": 1, "used": 0}},
    }
    report = tmp_path / "report.json"
    report.write_text(json.dumps(content))
    return report


def test_the_critical_path_is_told_by_registers(tmp_path):
    timing = read_timing(_report(tmp_path, TARGET_MHZ - 0.01))
    path = timing.path
    assert (path.start, path.end, path.levels) == ("u_a.x_q[3]", "u_b.y_q", 2)
    assert (path.logic_ns, path.routing_ns) == (1.75, 3.0)
    assert [(hop.net, hop.cells) for hop in path.hops] == [("", 0), ("u_a.x_q[3]", 2), ("sum", 0)]
    file = tmp_path / "fpga" / "timing.json"
    write_timing(file, timing, Absorbed(1, 1, 1), {"W": 16}, "hash", "tool")
    content = json.loads(file.read_text())
    assert (content["mhz"], content["reached"], content["critical_path"]["end"]) == (99.99, False, "u_b.y_q")
    file.write_text('{"fmax": {}, "critical_paths": [], "utilization": {}}')
    with pytest.raises(InputError, match="no timing report"):
        read_timing(file)


_SYNTHESISE = f"""
netlist = sys.argv[2].split("-json ")[1]
pathlib.Path(netlist).write_text(json.dumps({{"modules": {{"{TOP}": {{"cells": {{}}, "ports": {{}}}}}}}}))
"""
_ROUTE = """
pathlib.Path(sys.argv[sys.argv.index("--report") + 1]).write_text("{}")
assert pathlib.Path(sys.argv[sys.argv.index("--json") + 1]).exists()
"""


@pytest.mark.parametrize(
    ("yosys", "nextpnr", "message"),
    [
        (_SYNTHESISE, _ROUTE, None),
        ("print('ERROR: bad'); sys.exit(1)", _ROUTE, "yosys: ERROR: bad"),
        (_SYNTHESISE, "", "nextpnr: no result, exit status 0"),
    ],
)
def test_the_flow_hands_on_what_each_tool_leaves_or_fails(tmp_path, monkeypatch, yosys, nextpnr, message):
    for name, script in (("yosys", yosys), ("nextpnr", nextpnr)):
        tool = tmp_path / name
        tool.write_text(f"#!/usr/bin/env python3\nimport json, pathlib, sys\n{script}\n")
        tool.chmod(0o755)
        monkeypatch.setattr(ecp5_timing, name, lambda tool=tool: tool)
    # What an earlier run left must not be taken for an answer.
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "report.json").write_text("older")
    if message is None:
        report, absorbed = route([tmp_path / "a.sv"], {"W": 16}, tmp_path / "out", lambda _: None)
        assert report.read_text() == "{}" and absorbed == Absorbed(0, 0, 0)
    else:
        with pytest.raises(InputError, match=message):
            route([tmp_path / "a.sv"], {}, tmp_path / "out", lambda _: None)
