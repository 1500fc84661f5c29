"""A run on the pins leaves its waves with views of them, whose signals are all there."""

import pytest

from triaxis.golden.errors import InputError
from triaxis.verif.testbench import waves
from triaxis.verif.testbench.settings import BURST, PIN, VERILATOR
from triaxis.verif.testbench.simulation import run, run_settings
from triaxis.verif.testbench.waves import check_waves, finished, signals_in, view

HEADER = """$timescale 1ps $end
 $scope module triaxis_core $end
  $var wire 1 # clk_i $end
  $var wire 16 $ a[0][0] [15:0] $end
  $scope module u_datapath $end
   $var wire 3 % box_separated [2:0] $end
  $upscope $end
 $upscope $end
$enddefinitions $end
$var wire 1 & no_signal $end
"""


def test_the_views_have_what_the_file_has(tmp_path):
    (tmp_path / "waves.vcd").write_text(HEADER)
    held = signals_in(tmp_path / "waves.vcd")
    assert held == {
        "triaxis_core.clk_i": 1, "triaxis_core.a[0][0]": 16, "triaxis_core.u_datapath.box_separated": 3,
    }  # fmt: skip
    settings = run_settings("RandomTest", "w16_m0", 1, 1, folder=tmp_path, waves="vcd")
    assert finished(tmp_path, settings) == tmp_path / "waves.vcd"
    lines = (tmp_path / "waves.gtkw").read_text().splitlines()
    assert lines[0] == '[dumpfile] "waves.vcd"'
    for base, signal in (
        ("@28", "triaxis_core.clk_i"),
        ("@420", "triaxis_core.a[0][0][15:0]"),
        ("@22", "triaxis_core.u_datapath.box_separated[2:0]"),
    ):
        assert lines[lines.index(signal) - 1] == base
    surfer = (tmp_path / "waves.sucl").read_text().splitlines()
    assert "variable_add triaxis_core.a.[0].[0]" in surfer and "divider_add pairs_in" in surfer
    assert finished(tmp_path, settings, 1000)
    lines = (tmp_path / "waves.gtkw").read_text().splitlines()
    assert lines[1:3] == ["[timestart] 9760000", "*-16.000000 10000000"]
    (tmp_path / "waves.vcd").unlink()
    assert finished(tmp_path, settings) is None


def test_what_leaves_no_waves_is_refused(monkeypatch):
    check_waves("vcd", PIN, VERILATOR)
    for agent, simulator, what in ((BURST, VERILATOR, "say --agent pin"), (PIN, "icarus", "leave out --sim")):
        with pytest.raises(InputError, match=what):
            check_waves("vcd", agent, simulator)
    monkeypatch.setattr(waves.shutil, "which", lambda _: None)
    with pytest.raises(InputError, match="or take vcd"):
        check_waves("fst", PIN, VERILATOR)


def test_a_conversion_that_fails_is_told(tmp_path, monkeypatch):
    (tmp_path / "waves.vcd").write_text(HEADER)
    converter = tmp_path / "converter"
    converter.write_text("#!/bin/sh\necho no space >&2\nexit 1\n")
    converter.chmod(0o755)
    monkeypatch.setattr(waves, "_CONVERTER", str(converter))
    settings = run_settings("RandomTest", "w16_m0", 1, 1, folder=tmp_path, waves="fst")
    with pytest.raises(InputError, match=r"waves\.vcd: .* cannot convert it: no space"):
        finished(tmp_path, settings)


@pytest.mark.long
@pytest.mark.simulator
@pytest.mark.parametrize(
    ("test", "config"),
    [
        ("StallsTest", "w16_m0"),
        ("MeshStallsTest", "mesh_w16_m16_d64_g8_l8"),
        ("BoardNothingTest", "board_w8_m0_d16_g4_l2"),
    ],
)
def test_every_signal_of_a_view_is_in_the_waves(tmp_path, test, config):
    result = run(run_settings(test, config, 1, 40, folder=tmp_path, waves="vcd"))
    # Where nothing was checked a test fails, and is short.
    assert result.waves and result.passed == (test != "BoardNothingTest"), result.explain()
    held = signals_in(result.waves)
    wanted = [path for paths in view(result.settings).values() for path in paths]
    assert not [path for path in wanted if path not in held]
