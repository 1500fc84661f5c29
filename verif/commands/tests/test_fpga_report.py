"""``triaxis fpga report``: every build is made of its own sources; one beyond its limit is an exit code."""

import pytest

from triaxis.fpga.board_build import TOP, TWICE, Resources
from triaxis.fpga.logic_depth import LogicDepth, LogicPath, Tightest
from triaxis.fpga.resources import BUILDS, Synthesis
from triaxis.host.cli import main
from triaxis.host.tests.published import read_published
from triaxis.verif.commands import fpga

MEMORIES = {f"{TOP}.u_mesh.u_store_a.u_{name}.memory_q": "block" for name in ("triangles", "boxes")}

TWINS = frozenset(f"{TOP}.{place}" for place in TWICE)


@pytest.mark.parametrize(("dsps", "status"), [(67, 0), (241, 1)])
def test_command(tmp_path, monkeypatch, capsys, dsps, status):
    made = []

    def synthesise_nothing(sources, _include, top, parameters, _folder):
        made.append((top, len(sources)))
        return Synthesis(Resources(dsps, 10, 20, 30), MEMORIES, tmp_path / "netlist.json", TWINS)

    path = LogicPath("from_q", "to_q", ("LUT6", "CARRY4"), 2, cells_ns=1.5, wires=2)
    monkeypatch.setattr(fpga, "synthesise", synthesise_nothing)
    monkeypatch.setattr(fpga, "logic_depth", lambda netlist: LogicDepth(path, (Tightest(200, 1.75, path),)))
    monkeypatch.setattr(fpga, "yosys_version", lambda: "Yosys 0")
    monkeypatch.setattr(fpga, "bitstream_sources", lambda _: [])
    monkeypatch.setattr(fpga, "BUILD", tmp_path)
    assert main(["fpga", "report"]) == status
    assert len(made) == len(BUILDS) and all((count == 0) == (top == TOP) for top, count in made)
    said = capsys.readouterr().out
    assert ("board_fine: EXCEEDED: dsps" in said) is bool(status) and "operand gating: " in said
    assert "200 MHz where each wire takes at most 1.75 ns; tightest: from_q to to_q, 1.50 ns" in said
    builds = read_published(tmp_path / "fpga" / "report.json", "resources")["builds"]
    assert len(builds) == len(BUILDS) and builds["board_fine"]["dsps"] == dsps
    assert builds["board_fine"]["within_limit"] is not bool(status)
