"""`triaxis fpga bitstream`: the gate first; a bitstream and its manifest only where all is well."""

import json
import shutil
from argparse import ArgumentParser

import pytest

from triaxis.fpga import bitstream as bitstream_module
from triaxis.fpga.bitstream import build_id, manifest_path
from triaxis.fpga.board_build import BUILD_SCRIPT, bitstream_sources
from triaxis.golden.errors import InputError
from triaxis.golden.outputs import write_whole
from triaxis.host.cli.engine import checkout_id
from triaxis.host.tests.published import read_published
from triaxis.sim.build import rtl_hash
from triaxis.sim.paths import DUT
from triaxis.verif.commands import fpga
from triaxis.verif.signoff.tests.signoff_evidence import good_content

pytest.importorskip("tkinter", reason="this Python has no Tcl (Debian: apt-get install python3-tk)")

from triaxis.fpga.tests.vivado_stand_in import Behaviour, calls, make_vivado

RTL = rtl_hash()


@pytest.fixture
def bench(tmp_path, monkeypatch):
    """Lay out a board of one file, a good sign-off, and results in a folder of the test's own."""
    sign(tmp_path)
    source = tmp_path / "top.sv"
    source.write_text("module nexys4ddr_top; endmodule\n")
    monkeypatch.setattr(fpga, "bitstream_sources", lambda _: [source])
    monkeypatch.setattr(fpga, "BITSTREAM", tmp_path / "fpga" / "nexys4ddr.bit")
    monkeypatch.setattr(fpga, "REPORTS", tmp_path / "fpga" / "vivado")
    monkeypatch.setattr(fpga, "SAIF", tmp_path / "activity.saif")
    monkeypatch.setattr(fpga, "ACTIVITY", tmp_path / "activity.json")
    monkeypatch.setenv("PATH", str(tmp_path / "bin"))
    return tmp_path


def sign(folder, **changes):
    (folder / "signoff.json").write_text(json.dumps({**good_content(), **changes}))


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
    manifest = read_published(manifest_path(bits), "bitstream")
    assert manifest["rtl_hash"] == RTL
    assert manifest["parameters"]["BuildId"] == f"32'h{build_id(RTL, manifest['board_hash']):08x}"
    assert manifest["figures"]["wns_ns"] == 0.25
    assert manifest["activity"] is None
    assert len(manifest["sha256"]) == len(manifest["board_hash"]) == len(manifest["signoff"]["sha256"]) == 64
    assert "wns_ns: 0.25" in capsys.readouterr().out


@pytest.mark.parametrize("rtl", [RTL, "b" * 64, None])
def test_simulated_activity_is_used_where_it_is_of_this_rtl(bench, capsys, rtl):
    make_vivado(bench / "bin", Behaviour())
    (bench / "activity.saif").write_text("(SAIFILE)")
    if rtl:
        others = dict.fromkeys(("passed", "problems", "summary", "command", "seconds"))
        (bench / "activity.json").write_text(json.dumps({**others, "rtl_hash": rtl}))
    assert run(bench) == 0
    used = any(call[0] == "read_saif" for call in calls(bench / "bin"))
    manifest = json.loads((bench / "fpga" / "nexys4ddr.json").read_text())
    assert used == (manifest["activity"] is not None) == (rtl == RTL)
    assert ("without simulated activity of this RTL" in capsys.readouterr().out) != used


def nothing_is_left(bench):
    """Return whether no bitstream is there, Vivado's own neither."""
    return not [*(bench / "fpga").rglob("*.bit"), *(bench / "fpga").glob("nexys4ddr.json")]


def test_the_gate_refuses_before_vivado_is_looked_for(bench, capsys):
    for changes, reason in (
        ({"rtl_hash": "b" * 64}, "signed off for RTL bbbbbbbbbbbb"),
        ({"parts": {}}, "no evidence"),
        (None, "no sign-off"),
    ):
        if changes is None:
            (bench / "signoff.json").unlink()
        else:
            sign(bench, **changes)
        assert run(bench) == 1
        said = capsys.readouterr().err
        assert reason in said
        assert all(line.startswith("gate: refused: ") for line in said.splitlines())
        assert not (bench / "fpga").exists()


@pytest.mark.parametrize(
    ("behaviour", "said"),
    [
        (None, "vivado: not on PATH"),
        (Behaviour(failing="place_design"), "vivado: ERROR"),
        (Behaviour(setup=-1.5), "bitstream: refused: timing: worst slack -1.5 ns"),
        ("not signed", "did not pass"),
    ],
)
def test_what_fails_leaves_no_bitstream_not_even_an_older_one(bench, capsys, behaviour, said):
    make_vivado(bench / "bin", Behaviour())
    assert run(bench) == 0
    if behaviour is None:
        (bench / "bin" / "vivado").unlink()
    elif behaviour == "not signed":
        sign(bench, passed=False)
    else:
        make_vivado(bench / "bin", behaviour)
    try:
        assert run(bench) == 1
        assert said in capsys.readouterr().err
    except InputError as error:
        assert str(error).startswith(said) and "\n" not in str(error)
    assert nothing_is_left(bench)


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


@pytest.mark.parametrize(
    ("hashed", "before", "after", "says"),
    [
        ("rtl_hash", RTL, "c" * 64, "this is cccccccccccc"),
        ("board_hash", "a" * 64, "b" * 64, "changed during the build"),
    ],
)
def test_what_changes_during_the_build_is_refused(bench, capsys, monkeypatch, hashed, before, after, says):
    make_vivado(bench / "bin", Behaviour())
    hashes = iter([before, after])
    monkeypatch.setattr(fpga, hashed, lambda: next(hashes))
    assert run(bench) == 1
    assert says in capsys.readouterr().err
    assert nothing_is_left(bench)


def test_the_build_id_and_what_a_checkout_says_change_with_rtl_and_board(tmp_path, monkeypatch):
    assert len({build_id(rtl * 64, board * 64) for rtl in "ab" for board in "ab"}) == 4
    before = checkout_id()
    script = tmp_path / BUILD_SCRIPT.name
    script.write_text(BUILD_SCRIPT.read_text() + "# changed")
    monkeypatch.setattr(bitstream_module, "VIVADO", tmp_path)
    assert checkout_id() != before


def test_sources_of_the_board(tmp_path):
    names = [path.name for path in bitstream_sources(DUT)]
    assert (names[0], names[-1]) == ("triaxis_pkg.sv", "nexys4ddr_top.sv")
    assert "CollisionDetector.sv" not in names
    copy = shutil.copytree(DUT, tmp_path / "dut")
    (copy / "mesh" / "triaxis_walk.sv").unlink()
    with pytest.raises(InputError, match=r"triaxis_walk\.sv: not there"):
        bitstream_sources(copy)
    (copy / "board" / "triaxis_board.f").unlink()
    with pytest.raises(InputError, match=r"triaxis_board\.f: cannot read the list of files: No such"):
        bitstream_sources(copy)
