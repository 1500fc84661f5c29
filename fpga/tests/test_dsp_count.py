import json
import shutil

import pytest

from triaxis.fpga import dsp_count
from triaxis.fpga.dsp_count import DspCount, DspCounts, count_dsps
from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT, rtl_sources
from triaxis.sim.programs import read_slang, run_to_result, yosys

# Blocks of the whole core as yosys 0.69 maps it (`synth_xilinx -flatten`, then its mapping to DSP blocks), by
# width, margin bits and the edge x box axes. Some multipliers of margins are too narrow for a block.
SYNTHESISED = {
    (8, 0, 1): 90,
    (8, 1, 1): 119,
    (12, 2, 1): 119,
    (16, 0, 1): 120,
    (16, 0, 0): 84,
    (16, 1, 1): 149,
    (16, 16, 1): 160,
    (17, 17, 1): 160,
    (18, 3, 1): 250,
    (20, 18, 1): 279,
    (24, 1, 1): 210,
    (24, 2, 1): 250,
    (26, 4, 1): 471,
    (32, 9, 1): 489,
}

# Margins have the multipliers that the rule's exceptions are about: width and margin bits.
THRESHOLDS = [(8, 1), (12, 2), (16, 1), (16, 16), (24, 1), (24, 2), (26, 3), (26, 4), (32, 18)]
MAPPING = (
    "synth_xilinx -family xc7 -flatten -noiopad -top triaxis_threshold -run begin:map_dsp; "
    "techmap -map +/mul2dsp.v -map +/xilinx/xc7_dsp_map.v -D DSP_A_MAXWIDTH=25 -D DSP_B_MAXWIDTH=18 "
    "-D DSP_A_MAXWIDTH_PARTIAL=18 -D DSP_A_MINWIDTH=2 -D DSP_B_MINWIDTH=2 -D DSP_Y_MINWIDTH=9 "
    "-D DSP_SIGNEDONLY=1 -D DSP_NAME=$__MUL25X18"
)


def test_builds_take_what_the_synthesiser_takes():
    counts = DspCounts(DUT)
    assert {build: counts.core(*build[:2], bool(build[2])).dsps for build in SYNTHESISED} == SYNTHESISED
    assert counts.core(16, 16) == DspCount(90 + 29, 160, 160)
    assert counts.board(16, 16, 4096, 8, 8).dsps == 161
    with pytest.raises(InputError, match=r"W = 16, M = 17.*does not elaborate"):
        counts.core(16, 17)


def test_a_wrong_rule_is_noticed(monkeypatch):
    for rule, value, build in (("_UNUSED", 0, (26, 4, 1)), ("_LEAST_OPERAND", 1, (24, 1, 1))):
        with monkeypatch.context() as patch:
            patch.setattr(dsp_count, rule, value)
            assert DspCounts(DUT).core(*build[:2]).dsps != SYNTHESISED[build]


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
    names = ("pkg", "delay", "sum", "mul", "threshold")
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
