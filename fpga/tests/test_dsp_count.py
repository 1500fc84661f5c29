"""What builds take: DSP blocks by our count and by the synthesiser's, cells, block RAM, limits."""

import json
import shutil

import pytest

from triaxis.fpga.board_build import BOARD_LIMITS, TOP, WHOLE_PART, XC7A100T, Resources
from triaxis.fpga.dsp_count import DspCount, DspCounts, count_dsps
from triaxis.fpga.resources import Build, Row, count, memories, synthesise
from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT, rtl_sources
from triaxis.sim.programs import read_slang, run_to_result, yosys

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

# Width and margin bits: around the number of bits from which a margin takes blocks.
THRESHOLDS = [(8, 1), (12, 2), (16, 4), (16, 5), (16, 16), (24, 1), (26, 4), (32, 18)]
MAPPING = (
    "synth_xilinx -family xc7 -flatten -noiopad -top triaxis_threshold -run begin:map_dsp; "
    "techmap -map +/mul2dsp.v -map +/xilinx/xc7_dsp_map.v -D DSP_A_MAXWIDTH=25 -D DSP_B_MAXWIDTH=18 "
    "-D DSP_A_MAXWIDTH_PARTIAL=18 -D DSP_A_MINWIDTH=2 -D DSP_B_MINWIDTH=2 -D DSP_Y_MINWIDTH=9 "
    "-D DSP_SIGNEDONLY=1 -D DSP_NAME=$__MUL25X18"
)


def test_builds_take_what_the_synthesiser_takes():
    counts = DspCounts(DUT)
    assert {build: counts.core(*build[:2], bool(build[2])).dsps for build in SYNTHESISED} == SYNTHESISED
    assert counts.core(16, 16) == DspCount(65 + 29, 125, 125)
    assert counts.board(16, 16, 4096, 8, 8).dsps == 126
    with pytest.raises(InputError, match=r"W = 16, M = 17.*does not elaborate"):
        counts.core(16, 17)


@pytest.mark.regress
@pytest.mark.synthesiser
def test_thresholds_take_what_the_installed_synthesiser_takes(tmp_path):
    shapes = {
        f"t_{components}_{width}_{bits}": {
            "M": bits,
            "Components": components,
            "CWidth": 2 * width + 2 if components == 3 else width + 1,
        }
        for width, bits in THRESHOLDS
        for components in (2, 3)
    }
    names = ("pkg", "delay", "sum", "narrow_mul", "mul", "threshold")
    sources = [path for path in rtl_sources() if path.stem.removeprefix("triaxis_") in names]
    # The tool has a /tmp of its own, so it must find its files where it stands.
    for path in (*sources, DUT / "core" / "triaxis_stage.svh"):
        shutil.copy(path, tmp_path)
    script = "; ".join(
        f"{read_slang([path.name for path in sources], 'triaxis_threshold', shape)}; {MAPPING}; "
        f"tee -q -o {name}.json stat -json; design -reset"
        for name, shape in shapes.items()
    )
    last = tmp_path / f"{list(shapes)[-1]}.json"
    run_to_result([str(yosys()), "-p", script], last, tmp_path / "log", tmp_path)
    counted = [
        count_dsps(sources, DUT / "core", "triaxis_threshold", shape).dsps for shape in shapes.values()
    ]
    statistics = [json.loads((tmp_path / f"{name}.json").read_text()) for name in shapes]
    assert counted == [each["design"]["num_cells_by_type"].get("DSP48E1", 0) for each in statistics]
    assert min(counted) == 0 < max(counted)


def test_cells_are_counted_as_what_they_occupy():
    cells = {"DSP48E1": 3, "LUT6": 10, "LUT1": 1, "SRL16E": 2, "RAM32M": 2, "FDRE": 5, "FDCE": 1, "CARRY4": 9}
    found = count({**cells, "RAMB36E1": 3, "RAMB18E1": 5})
    assert found == Resources(dsps=3, luts=10 + 1 + 2 + 8, ffs=6, brams=5.5)


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


def test_the_meshes_must_be_in_block_ram():
    build = Build("board", "x", {}, top=TOP)
    found = memories(LOG)
    assert set(found.values()) == {"block", "look-up tables"}
    assert Row(build, Resources(0, 0, 0), found).within_limit
    broken = Row(build, Resources(0, 0, 0), memories(LOG.replace("BLOCKRAM_SDP", "LUTRAM_SDP")))
    assert broken.problems == ["nexys4ddr_top.u_mesh.u_store_b.g_lane[1].u_boxes.memory_q: not in block RAM"]
    assert "none found" in Row(build, Resources(0, 0, 0), memories("another log")).problems[0]


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
