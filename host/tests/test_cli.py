"""The command line as its users meet it: results, exit codes, one-line errors."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from triaxis.coverage.counts import read_counts
from triaxis.coverage.testplan import read_testplan
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import VERDICT, read_pairs
from triaxis.host import scenes
from triaxis.host.cli import main
from triaxis.host.cli.commands import COMMANDS, GROUPS
from triaxis.host.motion.gcode import read_blocks
from triaxis.host.scenes import mesh_data
from triaxis.host.stl import read_stl

TRIAXIS = Path(sys.executable).with_name("triaxis")


def triaxis(*arguments, status=0):
    answer = subprocess.run([TRIAXIS, *map(str, arguments)], capture_output=True, text=True, check=False)
    assert answer.returncode == status, answer.stdout + answer.stderr
    return answer.stdout, answer.stderr


def refused(*arguments):
    """Return the error line of a command that must be refused with exit code 2."""
    out, error = triaxis(*arguments, status=2)
    assert out == ""
    lines = error.strip().splitlines()
    assert len(lines) == 1, error
    assert "error: " in lines[0]
    return lines[0]


@pytest.fixture
def meshes(tmp_path):
    """Return two STL files, 2 mm apart along z."""
    a, b = tmp_path / "a.stl", tmp_path / "b.stl"
    scenes.write_stl(a, scenes.box((0, 0, 0), (10, 10, 10)))
    scenes.write_stl(b, scenes.box((2, 2, 12), (8, 8, 20)))
    return a, b


@pytest.mark.parametrize("command", ["", *GROUPS, *COMMANDS])
def test_help(command, capsys):
    with pytest.raises(SystemExit, match=r"^0$"):
        main([*command.split(), "--help"])
    assert f"usage: triaxis {command}".rstrip() in capsys.readouterr().out


def test_help_imports_nothing_heavy():
    words = [sys.executable, "-X", "importtime", TRIAXIS, "--help"]
    told = subprocess.run(words, capture_output=True, text=True, check=True).stderr
    imported = {line.split("|")[-1].strip() for line in told.splitlines()}
    assert "triaxis.host.cli.commands" in imported
    assert not imported & {"numpy", "matplotlib", "rich", "pyslang", "cocotb", "multiprocessing", "ctypes"}
    ours = {name for name in imported if name.startswith("triaxis.")}
    assert {name.split(".")[1] for name in ours} == {"golden", "host"}
    assert {name for name in ours if name.startswith("triaxis.host.")} == {
        "triaxis.host.cli", "triaxis.host.cli.commands",
    }  # fmt: skip


def test_unknown_commands_are_told_in_a_line():
    for words, known in (((), "check, path"), (["bench-sim"], "bench, fpga"), (["prove", "all"], "formal, ")):
        assert known in refused(*words)
    # An option is known by its whole name.
    assert "unrecognized arguments: --clear=1 (see triaxis check" in refused("check", "a", "b", "--clear=1")


@pytest.mark.simulator
def test_verdicts_of_all_engines_are_equal(tmp_path, rng):
    pairs = tmp_path / "pairs.npy"
    # An empty file is no error.
    for count, margin in ((1000, 0), (1000, 7), (0, 0)):
        np.save(pairs, rng.integers(-40, 40, (count, 2, 3, 3)).astype(np.int32))
        found = {}
        for engine in ("rtl", "bulk", "golden"):
            out = tmp_path / f"{engine}.npy"
            options = ("--engine", engine, "--margin", str(margin), "--out", str(out))
            assert main(["verdict", str(pairs), *options]) == 0
            found[engine] = np.load(out)
            assert found[engine].dtype == VERDICT
            assert found[engine].shape == (count,)
        assert (found["rtl"] == found["golden"]).all()
        assert (found["bulk"] == found["golden"]).all()
        assert (found["rtl"]["near"] == (found["rtl"]["axis"] == -1)).all()


def test_bad_pairs_leave_no_output(tmp_path):
    pairs, out = tmp_path / "pairs.npy", tmp_path / "out.npy"
    good = np.zeros((3, 2, 3, 3), np.int64)
    common = ("verdict", pairs, "--engine", "rtl", "--out", out)
    np.save(pairs, good + 40000)
    assert f"{pairs}: pair 0, triangle A, vertex 0, coordinate x: 40000 is outside" in refused(*common)
    np.save(pairs, good[:, 0])
    assert "shape (3, 3, 3): must be (N, 2, 3, 3)" in refused(*common)
    np.save(pairs, good * np.nan)
    assert "type float64" in refused(*common)
    np.save(pairs, good)
    assert "0..65535" in refused(*common, "--margin", 65536)
    assert "must be 0.." in refused(*common, "--margin", -1)
    assert "8..32" in refused(*common, "--width", 33)
    assert "cannot read" in refused("verdict", tmp_path / "no.npy", "--engine", "rtl", "--out", out)
    assert "invalid choice" in refused("verdict", pairs, "--engine", "guess", "--out", out)
    assert [path.name for path in tmp_path.iterdir()] == ["pairs.npy"]


READERS = {
    "STL": read_stl,
    "pairs": lambda path: read_pairs(path, 16),
    "G-code": lambda path: list(read_blocks(path)),
    "counts of coverage": lambda path: read_counts(path, ()),
    "testplan": read_testplan,
}


@pytest.mark.parametrize("reader", READERS)
def test_only_ordinary_files_are_read(tmp_path, reader):
    os.mkfifo(tmp_path / "pipe")
    # A reader that waits must end as a failure.
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail("waits for a pipe"))
    signal.alarm(10)
    try:
        for path, kind in ((tmp_path / "pipe", "pipe"), (tmp_path, "folder"), (Path("/dev/null"), "device")):
            with pytest.raises(
                InputError, match=rf"^{path}: is a [^\n]*{kind}[^\n]*: name an ordinary file$"
            ):
                READERS[reader](path)
    finally:
        signal.alarm(0)


def test_commands_refuse_a_pipe(meshes, tmp_path):
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    for command in (
        ("check", pipe, meshes[0]),
        ("path", *meshes, pipe),
        ("verdict", pipe, "--engine", "bulk", "--out", tmp_path / "out.npy"),
    ):
        assert f"{pipe}: is a pipe" in refused(*command)


def test_real_meshes():
    data = mesh_data()
    if data is None:
        pytest.skip("no real meshes here: set TRIAXIS_DATA to a folder with vmc/*.stl")
    out, _ = triaxis("check", data / "vmc/carousel.stl", data / "vmc/arm.stl", "--clearance", "0", status=1)
    assert "facet pairs: 1208024" in out
    # This binary file's header begins with "solid".
    out, _ = triaxis("check", data / "parts/unit_cube.STL", data / "vmc/arm.stl")
    assert "12 facets" in out
