"""What builds take: DSP blocks by our count and by the synthesiser's, cells, block RAM, limits."""

from pathlib import Path

import pytest

from triaxis.fpga.board_build import BOARD_LIMITS, TOP, TWICE, WHOLE_PART, XC7A100T, Resources
from triaxis.fpga.dsp_count import DspCount, DspCounts
from triaxis.fpga.resources import Build, Row, Synthesis, count, memories, synthesise
from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT

# Blocks of the whole core as yosys 0.69 maps it (`synth_xilinx -flatten`, then its mapping to DSP blocks), by
# width, margin bits and the edge x box axes.
SYNTHESISED = {
    (8, 0, 1): 65,
    (8, 1, 1): 65,
    (12, 2, 1): 65,
    (16, 0, 1): 85,
    (16, 0, 0): 67,
    (16, 1, 1): 85,
    (16, 4, 1): 85,
    (16, 16, 1): 125,
    (18, 3, 1): 85,
    (24, 1, 1): 170,
}


def test_builds_take_what_the_synthesiser_takes():
    counts = DspCounts(DUT)
    assert {build: counts.core(*build[:2], bool(build[2])).dsps for build in SYNTHESISED} == SYNTHESISED
    assert counts.core(16, 16) == DspCount(65 + 29, 125, 125)
    # Tables that constant functions fill take none, whatever W is.
    assert {counts.board(w, 8, 4096, 8, 8).dsps for w in (15, 16)} == {164}
    with pytest.raises(InputError, match=r"W = 16, M = 17.*does not elaborate"):
        counts.core(16, 17)


def test_cells_are_counted_as_what_they_occupy():
    cells = {"DSP48E1": 3, "LUT6": 10, "LUT1": 1, "SRL16E": 2, "RAM32M": 2, "FDRE": 5, "FDCE": 1, "CARRY4": 9}
    found = count({**cells, "RAMB36E1": 3, "RAMB18E1": 5})
    assert found == Resources(dsps=3, luts=10 + 1 + 2 + 8, ffs=6, brams=5.5)
    found = count({"RAM64X1S": 3, "RAM128X1D": 2, "RAM256X1S": 1, "FDRE_1": 4, "INV": 7})
    assert found == Resources(0, 3 + 8 + 4 + 7, 4)
    # What is not known would be within every limit.
    for kind in ("RAM64X8SW", "SRLC64E", "LDCE", "DSP48E2", "RAMB18E2"):
        with pytest.raises(InputError, match=f"{kind}: it is not known"):
            count({**cells, kind: 1})


def test_limits():
    assert BOARD_LIMITS.exceeded(Resources(200, 44_380, 0, 108)) == []
    assert BOARD_LIMITS.exceeded(Resources(201, 44_381, 0, 108.5)) == ["dsps", "luts", "brams"]
    assert WHOLE_PART.exceeded(XC7A100T) == []
    assert WHOLE_PART.exceeded(Resources(240, 63_400, 126_801, 135.5)) == ["ffs", "brams"]


LOG = """
mapping memory nexys4ddr_top.u_mesh.u_store_a.u_triangles.memory_q via $__XILINX_BLOCKRAM_TDP_
mapping memory nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_boxes.memory_q via $__XILINX_BLOCKRAM_SDP_
mapping memory nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_groups.memory_q via $__XILINX_LUTRAM_SDP_
"""


def test_the_meshes_must_be_in_block_ram_and_twins_be_two():
    build = Build("board", "x", {}, BOARD_LIMITS, TOP)
    twins = frozenset(f"{TOP}.{place}" for place in TWICE)

    def problems(log=LOG, apart=twins):
        return Row(build, Synthesis(Resources(0, 0, 0), memories(log), Path("netlist"), apart)).problems

    assert set(memories(LOG).values()) == {"block", "look-up tables"}
    assert problems() == []
    assert problems(LOG.replace("BLOCKRAM_SDP", "LUTRAM_SDP")) == [
        "nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_boxes.memory_q: not in block RAM"
    ]
    assert "none found" in problems("another log")[0]
    (problem,) = problems(apart=twins - {f"{TOP}.g_runner[1].u_runner"})
    assert problem.startswith("nexys4ddr_top.g_runner[1].u_runner: not kept")


@pytest.mark.synthesiser
@pytest.mark.parametrize(("attribute", "ffs"), [("", 1), ('(* keep_hierarchy = "yes" *)', 2)])
def test_twins_are_counted_twice_where_they_are_to_be_kept(tmp_path, attribute, ffs):
    """Without the attribute yosys makes one of two that are alike."""
    source = tmp_path / "top.sv"
    source.write_text(f"""
module half (input logic clk_i, d_i, output logic q_o); always_ff @(posedge clk_i) q_o <= d_i; endmodule
module top (input logic clk_i, d_i, output logic [1:0] q_o);
  for (genvar i = 0; i < 2; i++) begin : g_half
    {attribute} half u_half (.clk_i, .d_i, .q_o(q_o[i]));
  end
endmodule
""")
    made = synthesise([source], tmp_path, "top", {}, tmp_path / "made")
    assert made.used.ffs == ffs
    assert made.apart == {f"top.g_half[{i}].u_half" for i in range(2) if attribute}


def test_a_tool_that_ends_silently_is_an_error(tmp_path, monkeypatch):
    """The real one has been seen to end with status 0 and no result."""
    silent = tmp_path / "yosys"
    silent.write_text("#!/bin/sh\nexit 0\n")
    silent.chmod(0o755)
    monkeypatch.setattr("triaxis.fpga.resources.yosys", lambda: silent)
    with pytest.raises(InputError, match="no result, exit status 0"):
        synthesise([], tmp_path, "top", {}, tmp_path / "out")


@pytest.mark.synthesiser
def test_broken_rtl_is_one_clear_error(tmp_path):
    broken = tmp_path / "broken.sv"
    broken.write_text("module broken; nonsense endmodule\n")
    with pytest.raises(InputError, match=r"yosys: ERROR: Design elaboration failed"):
        synthesise([broken], tmp_path, "broken", {}, tmp_path)
