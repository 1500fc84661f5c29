"""`triaxis fpga bitstream`: the gate first; a bitstream and its manifest only where all is well."""

import hashlib
import json
from argparse import ArgumentParser
from functools import partial

import pytest

from triaxis.fpga import bitstream as bitstream_module
from triaxis.fpga import board_build
from triaxis.fpga.bitstream import build_id, manifest_path
from triaxis.fpga.board_build import SIGNED_OFF, bitstream_sources, generics
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.host.cli import fpga
from triaxis.host.cli.board_check import checkout_id
from triaxis.sim.build import rtl_hash
from triaxis.sim.paths import DUT
from triaxis.verif.signoff.gate import PARTS, refusals
from triaxis.verif.signoff.tests.test_gate import LAST_DAY, signed

pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")

from triaxis.fpga.tests.vivado_stand_in import Behaviour, calls, make_vivado

RTL = rtl_hash()


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Lay out a board of one file, a good sign-off, and results in a folder of the test's own."""
    source = tmp_path / "top.sv"
    source.write_text("module nexys4ddr_top; endmodule\n")
    monkeypatch.setattr(fpga, "bitstream_sources", lambda _: [source])
    monkeypatch.setattr(fpga, "BITSTREAM", tmp_path / "fpga" / "nexys4ddr.bit")
    monkeypatch.setattr(fpga, "REPORTS", tmp_path / "fpga" / "vivado")
    monkeypatch.setattr(fpga, "SAIF", tmp_path / "activity.saif")
    monkeypatch.setattr(fpga.measuring, "RESULT", tmp_path / "activity.json")
    monkeypatch.setattr(fpga, "refusals", partial(refusals, today=LAST_DAY))
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    sign(tmp_path)
    return tmp_path


def sign(folder, **changes):
    parts = {name: {"passed": True, "rtl_hash": RTL} for name in PARTS}
    content = {**signed(), "rtl_hash": RTL, "parts": parts, **changes}
    (folder / "signoff.json").write_text(json.dumps(content))


def run(bench):
    parser = ArgumentParser()
    fpga.add_bitstream(parser)
    options = parser.parse_args(["--result", str(bench / "signoff.json")])
    return options.run(options)


def test_bitstream_and_manifest(bench, capsys):
    make_vivado(bench / "bin", Behaviour())
    assert run(bench) == 0
    bits = bench / "fpga" / "nexys4ddr.bit"
    assert bits.read_bytes() == b"bits"
    manifest = json.loads(manifest_path(bits).read_text())
    assert manifest["rtl_hash"] == RTL
    assert manifest["parameters"]["BuildId"] == f"32'h{build_id(RTL, manifest['board_hash']):08x}"
    assert manifest["figures"]["wns_ns"] == 0.25
    assert manifest["activity"] is None
    assert len(manifest["sha256"]) == len(manifest["board_hash"]) == len(manifest["signoff"]["sha256"]) == 64
    assert "wns_ns: 0.25" in capsys.readouterr().out


def activity_of(folder, rtl):
    (folder / "activity.saif").write_text("(SAIFILE)")
    others = dict.fromkeys(("passed", "problems", "summary", "command", "seconds"))
    (folder / "activity.json").write_text(json.dumps({**others, "rtl_hash": rtl}))


def test_activity_of_other_rtl_is_not_used(bench, capsys):
    make_vivado(bench / "bin", Behaviour())
    activity_of(bench, "b" * 64)
    assert run(bench) == 0
    assert not any(call[0] == "read_saif" for call in calls(bench / "bin"))
    assert json.loads((bench / "fpga" / "nexys4ddr.json").read_text())["activity"] is None
    assert "without simulated activity of this RTL" in capsys.readouterr().out
    # Nor is one that says nothing of its RTL.
    (bench / "activity.json").unlink()
    assert run(bench) == 0
    assert not any(call[0] == "read_saif" for call in calls(bench / "bin"))


def test_simulated_activity_is_used_where_there_is_one(bench):
    activity_of(bench, RTL)
    make_vivado(bench / "bin", Behaviour())
    assert run(bench) == 0
    assert any(call[0] == "read_saif" for call in calls(bench / "bin"))
    assert json.loads((bench / "fpga" / "nexys4ddr.json").read_text())["activity"] is not None


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"rtl_hash": "b" * 64}, "signed off for RTL bbbbbbbbbbbb"),
        ({"passed": False}, "did not pass"),
        ({"parts": {}}, "no evidence"),
        (None, "no sign-off"),
    ],
)
def test_the_gate_refuses_before_vivado_is_looked_for(bench, capsys, changes, reason):
    if changes is None:
        (bench / "signoff.json").unlink()
    else:
        sign(bench, **changes)
    assert run(bench) == 1
    said = capsys.readouterr().err
    assert reason in said
    assert all(line.startswith("gate: refused: ") for line in said.splitlines())
    assert not (bench / "fpga").exists()


@pytest.mark.parametrize("gate", ["refuses", "passes"])
def test_a_refusal_leaves_no_older_bitstream(bench, gate):
    make_vivado(bench / "bin", Behaviour())
    assert run(bench) == 0
    (bench / "bin" / "vivado").unlink()
    if gate == "refuses":
        sign(bench, passed=False)
        assert run(bench) == 1
    else:
        with pytest.raises(InputError, match="vivado: not on PATH"):
            run(bench)
    assert not (bench / "fpga" / "nexys4ddr.bit").exists()
    assert not (bench / "fpga" / "nexys4ddr.json").exists()


def test_no_bitstream_is_ever_without_its_manifest(bench, monkeypatch):
    make_vivado(bench / "bin", Behaviour())
    written = []

    def only_the_first(path, content):
        written.append(path)
        if len(written) > 1:
            raise KeyboardInterrupt
        return write_whole(path, content)

    monkeypatch.setattr(bitstream_module, "write_whole", only_the_first)
    with pytest.raises(KeyboardInterrupt):
        run(bench)
    assert not (bench / "fpga" / "nexys4ddr.bit").exists()


def test_without_vivado_one_line(bench):
    with pytest.raises(InputError, match=r"^vivado: not on PATH: [^\n]*$"):
        run(bench)


@pytest.mark.parametrize("behaviour", [Behaviour(setup=-1.5), Behaviour(failing="place_design")])
def test_a_failed_build_leaves_no_bitstream_not_even_an_older_one(bench, capsys, behaviour):
    make_vivado(bench / "bin", Behaviour())
    assert run(bench) == 0
    make_vivado(bench / "bin", behaviour)
    if behaviour.failing:
        with pytest.raises(InputError, match="vivado: ERROR"):
            run(bench)
    else:
        assert run(bench) == 1
        assert "bitstream: refused: timing: worst slack -1.5 ns" in capsys.readouterr().err
    assert not (bench / "fpga" / "nexys4ddr.bit").exists()
    assert not (bench / "fpga" / "nexys4ddr.json").exists()


def test_rtl_that_changes_during_the_build_is_refused(bench, capsys, monkeypatch):
    make_vivado(bench / "bin", Behaviour())
    hashes = iter([RTL, "c" * 64])
    monkeypatch.setattr(fpga, "rtl_hash", lambda: next(hashes))
    assert run(bench) == 1
    assert "this is cccccccccccc" in capsys.readouterr().err
    assert not (bench / "fpga" / "nexys4ddr.bit").exists()


def test_a_board_that_changes_during_the_build_is_refused(bench, capsys, monkeypatch):
    make_vivado(bench / "bin", Behaviour())
    hashes = iter(["a" * 64, "b" * 64])
    monkeypatch.setattr(fpga, "board_hash", lambda: next(hashes))
    assert run(bench) == 1
    assert "changed during the build" in capsys.readouterr().err
    assert not (bench / "fpga" / "nexys4ddr.bit").exists()


def test_the_build_id_tells_rtl_and_board(tmp_path, monkeypatch):
    assert build_id("a" * 64, "b" * 64) == int(hashlib.sha256(b"a" * 64 + b"b" * 64).hexdigest()[:8], 16)
    ids = {build_id(rtl, board) for rtl in ("a" * 64, "b" * 64) for board in ("a" * 64, "b" * 64)}
    assert len(ids) == 4
    # What a checkout says changes with any file of the board.
    before = checkout_id()
    copy = tmp_path / "top.sv"
    copy.write_text(board_build.TOP_RTL.read_text() + "// changed")
    monkeypatch.setattr(bitstream_module, "TOP_RTL", copy)
    assert checkout_id() != before
    assert generics(SIGNED_OFF, 0x0000CAFE)["BuildId"] == "32'h0000cafe"


def test_sources_of_the_board():
    names = [path.name for path in bitstream_sources(DUT)]
    assert names[0] == "triaxis_pkg.sv"
    assert names[-1] == "nexys4ddr_top.sv"
    assert len(names) == len(set(names))
    assert "CollisionDetector.sv" not in names


@pytest.mark.parametrize(("content", "says"), [("none.sv\n", "none.sv: not there"), ("", "no file")])
def test_a_list_of_files_that_are_not_there(tmp_path, content, says):
    (tmp_path / "core").mkdir()
    (tmp_path / "core" / "triaxis.f").write_text(content)
    with pytest.raises(InputError, match=says):
        bitstream_sources(tmp_path)
