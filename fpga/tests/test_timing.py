import json

import pytest

from triaxis.fpga import gowin_timing
from triaxis.fpga.gowin_timing import TARGET_MHZ, UNTIMED, read_timing, route, write_timing
from triaxis.golden.errors import InputError
from triaxis.host.tests.published import read_published


def _step(kind, cell, ns, net=""):
    return {"type": kind, "to": {"cell": cell}, "delay": ns, "net": net}


def _report(tmp_path, mhz):
    clock = "$glbnet$clk"
    path = [
        _step("clk-to-q", "u_a.x_q_DFF_Q_14", 0.5),
        _step("routing", "s_ALU_SUM", 2.0, "u_a.x_q[3]"),
        _step("logic", "s_ALU_SUM", 0.5),
        _step("routing", "s_ALU_SUM_1", 0.0, "carry"),
        _step("logic", "s_ALU_SUM_1", 0.5),
        _step("routing", "u_b.y_q_DFFRE_Q", 1.0, "sum"),
        _step("setup", "u_b.y_q_DFFRE_Q", 0.25),
    ]
    content = {
        "fmax": {clock: {"achieved": mhz, "constraint": 100}},
        "critical_paths": [
            {"from": "<async>", "to": f"posedge {clock}", "path": []},
            {"from": f"posedge {clock}", "to": f"posedge {clock}", "path": path},
        ],
        # What the tool counts and the part has not is its own affair.
        "utilization": {
            name: {"available": available, "used": used}
            for name, available, used in (("DFF", 149, 120), ("DTR", 1, 0), ("DUMMY_CELL", 0, 3))
        },
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
    write_timing(file, timing, {"W": 16}, "0" * 64, "tool")
    content = read_published(file, "timing")
    assert (content["mhz"], content["reached"], content["critical_path"]["end"]) == (99.99, False, "u_b.y_q")
    assert (content["not_timed"], content["used"]) == (UNTIMED, {"DFF": 120})
    file.write_text('{"fmax": {}, "critical_paths": [], "utilization": {}}')
    with pytest.raises(InputError, match="no timing report"):
        read_timing(file)


_SYNTHESISE = """
netlist = sys.argv[2].split("-json ")[1]
pathlib.Path(netlist).write_text("netlist")
"""
_ROUTE = """
pathlib.Path(sys.argv[sys.argv.index("--report") + 1]).write_text("{}")
assert pathlib.Path(sys.argv[sys.argv.index("--json") + 1]).exists()
(pins,) = [value.removeprefix("cst=") for value in sys.argv if value.startswith("cst=")]
assert "clk_i" in pathlib.Path(pins).read_text()
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
        tool.write_text(f"#!/usr/bin/env python3\nimport pathlib, sys\n{script}\n")
        tool.chmod(0o755)
        monkeypatch.setattr(gowin_timing, name, lambda tool=tool: tool)
    # What an earlier run left must not be taken for an answer.
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "report.json").write_text("older")
    if message is None:
        report = route([tmp_path / "a.sv"], {"W": 16}, tmp_path / "out", lambda _: None)
        assert report.read_text() == "{}"
    else:
        with pytest.raises(InputError, match=message):
            route([tmp_path / "a.sv"], {}, tmp_path / "out", lambda _: None)
