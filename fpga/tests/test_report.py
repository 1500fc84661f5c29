import json

import pytest

from triaxis.fpga.board_build import BOARD_LIMITS, TOP, WHOLE_PART, XC7A100T, Limits, Resources
from triaxis.fpga.logic_depth import LogicDepth, LogicPath
from triaxis.fpga.resources import BUILDS, Build, Row, Synthesis, count, memories, synthesise, write_report
from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.verif.commands import fpga


def test_cells_are_counted_as_what_they_occupy():
    cells = {"DSP48E1": 3, "LUT6": 10, "LUT1": 1, "SRL16E": 2, "RAM32M": 2, "FDRE": 5, "FDCE": 1, "CARRY4": 9}
    assert count(cells) == Resources(dsps=3, luts=10 + 1 + 2 + 8, ffs=6)


def test_half_a_block_ram_is_half():
    assert count({"RAMB36E1": 3, "RAMB18E1": 5}).brams == 5.5


def test_limits():
    build = Build("x", "x", {}, Limits(dsps=86))
    assert Row(build, Resources(86, 0, 0)).within_limit
    assert Row(build, Resources(87, 0, 0)).problems == ["dsps"]
    board = Build("x", "x", {}, BOARD_LIMITS)
    assert Row(board, Resources(200, 44_380, 0, 108)).within_limit
    assert Row(board, Resources(201, 44_381, 0, 108.5)).problems == ["dsps", "luts", "brams"]
    assert WHOLE_PART.exceeded(XC7A100T) == []
    assert WHOLE_PART.exceeded(Resources(240, 63_400, 126_801, 135.5)) == ["ffs", "brams"]


def test_what_is_limited():
    limits = {build.name: build.limits for build in BUILDS}
    assert limits == {
        "all_axes": Limits(dsps=124),
        "no_edge_box": Limits(dsps=86),
        "margins": Limits(),
        "board": Limits(dsps=200, luts=44_380, brams=108),
        "board_fine": Limits(240, 63_400, 126_800, 135),
    }
    boards = {build.parameters["W"]: build.parameters for build in BUILDS if build.top == TOP}
    assert boards[16]["Depth"] >= 4096
    assert boards[16]["M"] > 0
    assert boards[24]["Lanes"] == 1
    assert boards[24]["M"] > 0


LOG = """
mapping memory nexys4ddr_top.u_mesh.u_store_a.u_triangles.memory_q via $__XILINX_BLOCKRAM_TDP_
mapping memory nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_boxes.memory_q via $__XILINX_BLOCKRAM_SDP_
mapping memory nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_groups.memory_q via $__XILINX_LUTRAM_SDP_
"""


def test_the_meshes_must_be_in_block_ram():
    build = Build("board", "x", {}, top=TOP)
    found = memories(LOG)
    assert set(found.values()) == {"block", "look-up tables"}
    assert Row(build, Resources(0, 0, 0), found).within_limit
    broken = Row(build, Resources(0, 0, 0), memories(LOG.replace("BLOCKRAM_SDP", "LUTRAM_SDP")))
    assert broken.problems == ["nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_boxes.memory_q: not in block RAM"]
    assert "none found" in Row(build, Resources(0, 0, 0), memories("another log")).problems[0]


def test_report_file(tmp_path):
    path = tmp_path / "fpga" / "report.json"
    write_report(path, [Row(BUILDS[0], Resources(130, 1000, 2000, 1.5))], "hash", "tool")
    content = json.loads(path.read_text())
    assert content["builds"]["all_axes"]["within_limit"] is False
    assert content["builds"]["all_axes"]["problems"] == ["dsps"]
    assert content["builds"]["all_axes"]["dsps"] == 130
    assert content["builds"]["all_axes"]["brams"] == 1.5
    assert content["available"]["brams"] == 135


def test_a_tool_that_ends_silently_is_an_error(tmp_path, monkeypatch):
    """The real one has been seen to end with status 0 and no result."""
    silent = tmp_path / "yosys"
    silent.write_text("#!/bin/sh\nexit 0\n")
    silent.chmod(0o755)
    monkeypatch.setattr("triaxis.fpga.resources.yosys", lambda: silent)
    with pytest.raises(InputError, match="no result, exit status 0"):
        synthesise([], tmp_path, "top", {}, tmp_path / "out")


@pytest.mark.parametrize(("dsps", "status"), [(84, 0), (241, 1)])
def test_command(tmp_path, monkeypatch, capsys, dsps, status):
    """All builds are made, each of its own sources, and one beyond its limit is an exit code."""
    made = []

    def synthesise_nothing(sources, _include, top, parameters, _folder):
        made.append((top, parameters["W"], len(sources)))
        return Synthesis(Resources(dsps, 10, 20, 30), memories(LOG), tmp_path / "netlist.json")

    path = LogicPath("from_q", "to_q", ("LUT6", "CARRY4"), 2)
    monkeypatch.setattr(fpga, "synthesise", synthesise_nothing)
    monkeypatch.setattr(fpga, "logic_depth", lambda netlist: LogicDepth(path, path))
    monkeypatch.setattr(fpga, "yosys_version", lambda: "Yosys 0")
    monkeypatch.setattr(fpga, "bitstream_sources", lambda _: [])
    monkeypatch.setattr(fpga, "BUILD", tmp_path)
    assert main(["fpga", "report"]) == status
    assert len(made) == len(BUILDS)
    assert all((count == 0) == (top == TOP) for top, _, count in made)
    said = capsys.readouterr().out
    assert ("board_fine: EXCEEDED: dsps" in said) is bool(status)
    assert "operand gating: " in said
    assert len(json.loads((tmp_path / "fpga" / "report.json").read_text())["builds"]) == len(BUILDS)


@pytest.mark.synthesiser
def test_broken_rtl_is_one_clear_error(tmp_path):
    broken = tmp_path / "broken.sv"
    broken.write_text("module broken; nonsense endmodule\n")
    with pytest.raises(InputError, match=r"yosys: ERROR: Design elaboration failed"):
        synthesise([broken], tmp_path, "broken", {}, tmp_path)
