"""The command line as its users meet it: results, exit codes, errors, no older answers, interrupts."""

import json
import os
import random
import shlex
import signal
import subprocess
import sys
import time
import tomllib
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from rich.console import Console

from triaxis.coverage.counts import read_counts
from triaxis.coverage.testplan import read_testplan
from triaxis.golden.errors import InputError
from triaxis.golden.pairs import VERDICT, read_pairs
from triaxis.host import cli, scenes
from triaxis.host.cli import commands, main
from triaxis.host.cli.commands import COMMANDS, GROUPS, remove_older_answers, withdraw_yes
from triaxis.host.cli.terminal import progress_bar
from triaxis.host.motion.gcode import read_lines
from triaxis.host.stl import read_stl
from triaxis.sim.paths import ROOT

TRIAXIS = Path(sys.executable).with_name("triaxis")
QUIET: dict[str, Any] = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
UNKNOWN = {"verdict": "unknown"}


@pytest.fixture
def refused(capsys):
    """Return a function that runs a command, which must fail with one line and exit code 2: that line."""

    def run(*words):
        assert main([*map(str, words)]) == 2
        out, error = capsys.readouterr()
        assert (out, error.count("\n")) == ("", 1), out + error
        assert error.startswith("triaxis: error: ")
        return error

    return run


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
    assert not imported & {"numpy", "matplotlib", "rich", "pyslang", "cocotb", "multiprocessing", "ctypes"}
    ours = {name for name in imported if name.startswith("triaxis.") and ".golden" not in name}
    assert ours == {"triaxis.host", "triaxis.host.cli", "triaxis.host.cli.commands"}


def test_unknown_commands_are_told_in_a_line(refused):
    known_of = (((), "check, path"), (["bench-sim"], "bench, tritest, fpga"), (["prove", "all"], "formal, "))
    for words, known in known_of:
        assert known in refused(*words)
    # An option is known by its whole name.
    assert "unrecognized arguments: --clear=1 (see triaxis check" in refused("check", "a", "b", "--clear=1")


@pytest.mark.simulator
def test_verdicts_of_all_engines_are_equal(tmp_path, rng):
    pairs = tmp_path / "pairs.npy"
    # An empty file is no error.
    for count in (1000, 0):
        np.save(pairs, rng.integers(-40, 40, (count, 2, 3, 3)).astype(np.int32))
        found = {}
        for engine in ("rtl", "bulk", "golden"):
            out = tmp_path / f"{engine}.npy"
            words = ("--engine", engine, "--width", "8", "--margin", "7", "--out", str(out))
            assert main(["verdict", str(pairs), *words]) == 0
            found[engine] = np.load(out)
            assert (found[engine].dtype, found[engine].shape) == (VERDICT, (count,))
        assert (found["rtl"] == found["golden"]).all() and (found["bulk"] == found["golden"]).all()


def test_bad_pairs_leave_no_output(tmp_path, refused):
    pairs, out = tmp_path / "pairs.npy", tmp_path / "out.npy"
    good = np.zeros((3, 2, 3, 3), np.int64)
    for content, words, why in (
        (good + 40000, (), f"{pairs}: pair 0, triangle A, vertex 0, coordinate x: 40000 is outside"),
        (good[:, 0], (), "shape (3, 3, 3): must be (N, 2, 3, 3)"),
        (good * np.nan, (), "type float64"),
        (good, ("--margin", 65536), "0..65535"),
        (good, ("--margin", -1), "must be 0.."),
        (good, ("--width", 33), "8..32"),
        (good, ("--engine", "guess"), "invalid choice"),
    ):
        np.save(pairs, content)
        assert why in refused("verdict", pairs, "--engine", "rtl", "--out", out, *words)
    assert "cannot read" in refused("verdict", tmp_path / "no.npy", "--engine", "rtl", "--out", out)
    assert [path.name for path in tmp_path.iterdir()] == ["pairs.npy"]


BAD_OPTIONS = {
    "check": [
        ("--clearance -0.5", "must not be negative"),
        ("--resolution 0.0001 --width 16", "does not fit 16 bits at resolution 0.0001"),
        ("--resolution nan", "not a finite decimal number"),
        ("--resolution 1mm", "--resolution: 1mm: not a finite decimal number"),
        ("--clearance 1e99", "--clearance: 1e99: beyond 60 digits"),
        ("--width 5", "8..32"),
        ("--clearance 99 --width 16", "width 16 allows 65535"),
        ("--rotate w 90", "--rotate w: must be x, y or z"),
        ("--rotate x inf", "--rotate x inf: not a finite decimal number"),
        ("--width 16 --move 0 0 90", "does not fit 16 bits"),
        ("--engine board", "--engine board: name its serial port with --port"),
        ("--port /dev/ttyUSB1", "--port, --any-bitstream and --skip-self-test go with --engine board"),
    ],
    "scene advise": [
        ("--clearance -1", "clearance -1: must not be negative"),
        ("--clearance 0", "band: a clearance of 0 gives none"),
        ("--clearance 1 --band 0", "band 0: must be positive"),
        ("--clearance 1 --depth 100", "depth 100: must be a power of two"),
        ("--clearance 1 --lanes 3", "lanes 3: must be a power of two"),
        ("--clearance 1 --margin-bits 40", "margin bits 40: must be 0..32"),
        ("--clearance 1 --lanes 0", "lanes 0: must be a power of two"),
        ("--clearance 1 --depth 65536", "depth 65536: the board holds at most 32768 triangles"),
        ("--clearance 1 --dsps 0", "--dsps: 0: must be at least 1"),
        ("--clearance 1 --dsps many", "--dsps: many: not an integer"),
        ("--clearance 1 --travel z 0 up", "--travel z up: not a finite decimal number"),
        ("--clearance 1 --travel w 0 1", "--travel w: must be x, y or z"),
        ("--clearance 1 --volume 0 0 0 0 1 1", "volume: X0 Y0 Z0 must be below"),
        ("--clearance 1 --volume 0 0 0 1 1 1", "a.stl: reaches from"),
    ],
    "path": [("p.nc --start 0 0 1e10", "--start: at most 1e+09 in each coordinate")],
    "watch": [
        ("p.nc --port x --speed 9 --age -1", "--age: must not be negative"),
        ("p.nc --port x --speed 9 --age 20", "--age 20: must be less than --lag 20, which holds it"),
        ("p.nc --port x --speed 9 --hold 0", "hold 0: must be 1.."),
        ("p.nc --port x --speed 9 --scale 0", "--scale: must be more than 0"),
        # Of the tests nothing comes that way.
        ("p.nc --port x --speed 9", "positions: standard input is closed: give them there, or by --pos"),
        ("p.nc --port x --speed 9 --positions /etc/passwd", "an ordinary file does not say when"),
    ],
}


@pytest.mark.parametrize("command", BAD_OPTIONS)
def test_bad_options_are_refused_in_a_line(command, meshes, refused):
    for options, why in BAD_OPTIONS[command]:
        assert why in refused(*command.split(), *meshes, *options.split())


READERS = {
    "STL": read_stl,
    "pairs": lambda path: read_pairs(path, 16),
    "G-code": lambda path: list(read_lines(path)),
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
            wanted = rf"^{path}: is a [^\n]*{kind}[^\n]*: name an ordinary file$"
            with pytest.raises(InputError, match=wanted):
                READERS[reader](path)
    finally:
        signal.alarm(0)


def started(*words: object) -> "subprocess.Popen[bytes]":
    """Start a command; return when it handles signals, before which nothing can be promised."""
    process = subprocess.Popen([TRIAXIS, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) & 1 << (signal.SIGHUP - 1):
            break
    return process


@pytest.mark.parametrize("moments", [3, pytest.param(24, marks=pytest.mark.regress)])
@pytest.mark.parametrize("numbers", [[signal.SIGINT], [signal.SIGTERM], [signal.SIGHUP, signal.SIGINT]])
def test_no_moment_leaves_an_older_answer(meshes, tmp_path, seed, numbers, moments):
    report = tmp_path / "report.json"
    command = ("check", *meshes, "--engine", "golden", "--clearance", "2", "--json", report)
    begun = time.monotonic()
    with started(*command) as process:
        assert process.wait() == 1
    whole, chance = time.monotonic() - begun, random.Random(seed)
    for moment in range(moments):
        # Of a run that said what this one cannot say.
        report.write_text('{"verdict": "clear"}')
        with started(*command) as process:
            time.sleep(whole * (moment + chance.uniform(0, 1)) / moments)
            for number in numbers:
                process.send_signal(number)
            assert process.stderr
            errors = process.stderr.read().decode()
            code = process.wait()
        verdict = json.loads(report.read_text())["verdict"]
        if code == 130:
            assert errors.endswith("triaxis: interrupted\n") and "Traceback" not in errors
            assert verdict in ("unknown", "near")
        else:
            assert (code, verdict) == (1, "near"), errors
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".")] == []


def test_what_cannot_be_told_is_no_answer(meshes, tmp_path):
    """Where output cannot be written: neither "clear" in a report, nor an exit code that says "near"."""
    report = tmp_path / "report.json"
    clear = ("check", *meshes, "--engine", "bulk", "--json", report)
    with Path("/dev/full").open("wb") as full:
        for words, files, code, said in (
            (clear, {}, 0, "clear"),
            (clear, {"stdout": full}, 2, "unknown"),
            (clear, {"stdout": full, "stderr": full}, 2, "unknown"),
            ((*clear, "--width", 40), {"stderr": full}, 2, "unknown"),
        ):
            ran = subprocess.run([TRIAXIS, *map(str, words)], **{**QUIET, **files}, check=False)
            assert (ran.returncode, json.loads(report.read_text())["verdict"]) == (code, said)
    # Nobody is told, and nothing goes wrong for it.
    for words, code, said in (((*clear, "--width", 40), 2, "unknown"), (clear, 0, "clear")):
        closed = f"exec {shlex.join(map(str, (TRIAXIS, *words)))} >&- 2>&-"
        assert subprocess.run(["sh", "-c", closed], check=False).returncode == code
        assert json.loads(report.read_text())["verdict"] == said


@pytest.mark.parametrize(
    ("verdict", "left"), [("followed", "unknown"), ("clear", "unknown"), ("near", "near")]
)
def test_a_yes_is_withdrawn_where_the_command_fails_afterwards(verdict, left, tmp_path):
    report = tmp_path / "report.json"
    report.write_text(json.dumps({"verdict": verdict}))
    withdraw_yes(["watch", "t.stl", "w.stl", "p.nc", "--json", str(report)])
    assert json.loads(report.read_text())["verdict"] == left


def test_a_yes_goes_where_nothing_can_be_written(tmp_path, monkeypatch):
    report = tmp_path / "report.json"
    report.write_text('{"verdict": "clear"}')

    def full(path, content):
        raise InputError(f"{path}: no space left on device")

    monkeypatch.setattr(commands, "write_whole", full)
    withdraw_yes(["check", "a.stl", "b.stl", "--json", str(report)])
    assert not report.exists()


def test_an_interrupt_between_the_answer_and_its_standing_withdraws_it(tmp_path):
    report = tmp_path / "report.json"
    late = (
        "import sys; from pathlib import Path; from triaxis.host import cli\n"
        "def answer(words, of_this_process):\n"
        """    Path(words[-1]).write_text('{"verdict": "clear"}')\n"""
        "    raise KeyboardInterrupt\n"
        "cli._answer = answer\n"
        "sys.exit(cli.main())"
    )
    words = (sys.executable, "-c", late, "check", "a.stl", "b.stl", "--json", report)
    ended = subprocess.run([str(word) for word in words], capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stderr) == (130, "triaxis: interrupted\n")
    assert json.loads(report.read_text())["verdict"] == "unknown"


def test_an_interrupt_that_python_swallows_comes_again():
    """In a callback of a weak reference no exception goes further."""
    lost = (
        "import os, signal, sys, time, weakref\n"
        "from triaxis.host import cli\n"
        "from triaxis.host.cli import commands\n"
        "class Thing: pass\n"
        "def run():\n"
        "    thing = Thing()\n"
        "    send = lambda _: os.kill(os.getpid(), signal.SIGINT) or [0 for _ in range(9)]\n"
        "    held = weakref.ref(thing, send)\n"
        "    del thing\n"
        "    print('swallowed', flush=True)\n"
        "    time.sleep(20)\n"
        "    return 0\n"
        "commands.runner = lambda name, words: run\n"
        "sys.exit(cli.main())"
    )
    words = (sys.executable, "-c", lost, "check", "a.stl", "b.stl")
    ended = subprocess.run(words, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout, ended.stderr) == (130, "swallowed\n", "triaxis: interrupted\n")


def test_an_interrupt_that_a_command_took_for_something_else_is_one(monkeypatch):
    monkeypatch.setattr(commands, "runner", lambda name, words: lambda: 0)
    assert main(["check", "a.stl", "b.stl"]) == 0
    monkeypatch.setattr(cli, "_interrupted", True)
    for fails in (lambda: 0, lambda: 1 / 0):
        monkeypatch.setattr(commands, "runner", lambda *_, fails=fails: fails)
        with pytest.raises(KeyboardInterrupt):
            main(["check", "a.stl", "b.stl"])


def test_no_failure_within_looks_like_an_answer(tmp_path, refused, monkeypatch, capsys):
    report = tmp_path / "report.json"
    words = ["check", "a.stl", "b.stl", "--json", str(report)]

    def fails(error):
        report.write_text('{"verdict": "clear"}')
        raise error

    for error, told in (
        (MemoryError(), "out of memory: use a smaller input"),
        (ModuleNotFoundError(name="cocotb"), "cocotb is not installed: pip install 'triaxis[signoff]'"),
        (ModuleNotFoundError("gone", name="triaxis.gone"), "internal: ModuleNotFoundError: gone"),
        (ValueError("two\nlines"), "internal: ValueError: two lines (TRIAXIS_DEBUG=1 shows where)"),
    ):
        monkeypatch.setattr(commands, "runner", lambda *_, error=error: lambda: fails(error))
        assert told in refused(*words) and json.loads(report.read_text()) == UNKNOWN
    monkeypatch.setenv("TRIAXIS_DEBUG", "1")
    assert main(words) == 2 and "Traceback" in capsys.readouterr().err
    assert json.loads(report.read_text()) == UNKNOWN


def test_examples_are_written(tmp_path, capsys):
    assert main(["scene", "examples", str(tmp_path)]) == 0
    told = {name for line in capsys.readouterr().out.splitlines() for name in line.split(": ")[0].split()}
    files = {file for file in tmp_path.rglob("*") if file.is_file()} - set(tmp_path.glob("mill/*.stl"))
    assert told == set(map(str, files)) and str(tmp_path / "mill" / "machine.toml") in told


def test_progress_is_told_in_a_log_and_seen_on_a_terminal(capsys, monkeypatch):
    monkeypatch.setattr("triaxis.host.cli.terminal._SELDOM", 0)
    for terminal, shown in ((False, "moves: 1,234 of 4,000\n"), (True, "1234/4000")):
        monkeypatch.setattr("triaxis.host.cli.terminal.Console", partial(Console, force_terminal=terminal))
        with progress_bar("moves", 4000) as progress:
            progress(1234)
        assert shown in capsys.readouterr().err


@pytest.mark.parametrize("name", ["-", "-1", "-1e3", "-5.", "-old report.json", "--json"])
def test_a_report_that_is_named_like_an_option_is_no_report(name, meshes, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    check = ["check", *map(str, meshes), "--engine", "bulk"]
    for more in ([], ["--width", "40"]):
        assert main([*check, "--json", name, *more]) == 2
        assert not Path(name).exists()
        assert "--json: names no file: give the file to write to, ./- where" in capsys.readouterr().err
    for named in (["--json", f"./{name}"], [f"--json={name}"]):
        assert main([*check, *named]) == 0
        assert main([*check, *named, "--width", "40"]) == 2
        assert json.loads(Path(name).read_text())["verdict"] == "unknown"


def test_an_input_may_have_the_name_of_an_option(meshes, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("report.json").write_text('{"verdict": "clear"}')
    remove_older_answers("check", ["--json", "report.json", "--", "-h", str(meshes[0])])
    assert json.loads(Path("report.json").read_text())["verdict"] == "unknown"


def test_ignored_signals_stay_ignored(meshes):
    command = ["nohup", TRIAXIS, "check", *meshes, "--engine", "golden"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        for _ in range(10):
            time.sleep(0.02)
            process.send_signal(signal.SIGHUP)
        assert process.wait() == 0


def test_whatever_fails_leaves_no_older_answer(meshes, tmp_path, refused):
    report, picture, out = (tmp_path / name for name in ("report.json", "path.png", "out.npy"))
    os.mkfifo(tmp_path / "pipe")
    (tmp_path / "arc.nc").write_text("G21 G0 Z50\nG2 X5 I1\n")
    for words in (
        ("check", *meshes, "--json", report, "--no-such-option"),
        ("check", meshes[0], tmp_path / "no.stl", f"--json={report}"),
        ("check", meshes[0], tmp_path / "pipe", "--json", report),
        ("path", *meshes, tmp_path / "no.nc", "--json", report, "--picture", picture),
        ("path", *meshes, tmp_path / "no.nc", "--json", report, "--picture", tmp_path / "path.gif"),
        ("path", *meshes, tmp_path / "arc.nc", "--json", report, "--picture", picture),
        ("path", *meshes, tmp_path / "arc.nc", "--json", report, "--width", 40),
        ("path", *meshes, tmp_path / "arc.nc", "--json", report, "--profile", 1),
        ("board", "check", *meshes, "--port", tmp_path / "no", "--json", report),
        ("verdict", tmp_path / "no.npy", "--engine", "rtl", "--out", out),
        ("verdict", "--out", out),
    ):
        for path in (report, picture):
            path.write_text('{"verdict": "clear"}')
        np.save(out, np.zeros(3))
        refused(*words)
        if report in words:
            assert json.loads(report.read_text()) == UNKNOWN
        assert (picture in words) == (not picture.exists())
        assert (out in words) == (not out.exists())


def test_outputs_that_cannot_be(meshes, tmp_path, refused):
    before, log = [mesh.read_bytes() for mesh in meshes], tmp_path / "log"
    for words, why in (
        (("--json", ""), "--json: names no file"),
        (("--json", os.devnull), "/dev/null: is a device"),
        (("--json", tmp_path), "is a folder"),
        (("--json", meshes[1]), "is an input file"),
        ((f"--json={tmp_path / '..' / tmp_path.name / 'a.stl'}",), "is an input file"),
    ):
        assert why in refused("check", *meshes, *words)
    for out, why in (("/dev/stdout", "is a device or a pipe"), (log, "the output of this very command")):
        command = [TRIAXIS, "check", *meshes, "--json", out]
        with log.open("w") as file:
            stdout = file if out == log else subprocess.PIPE
            answer = subprocess.run(command, stdout=stdout, stderr=subprocess.PIPE, check=False)
        assert (answer.returncode, why in answer.stderr.decode()) == (2, True)
    assert [mesh.read_bytes() for mesh in meshes] == before
    same = tmp_path / "same.png"
    words = ("path", *meshes, tmp_path / "moves.nc", "--json", same, "--picture", same)
    assert "named for two outputs" in refused(*words)
    # Of two the last alone would have an answer, and the first keep an older one.
    both = [tmp_path / name for name in ("one.json", "two.json")]
    for file in both:
        file.write_text('{"verdict": "clear"}')
    assert "--json: given twice" in refused("check", *meshes, "--json", both[0], f"--json={both[1]}")
    assert [json.loads(file.read_text())["verdict"] for file in both] == ["unknown", "unknown"]


def test_a_value_that_is_given_twice_is_refused(meshes, refused):
    """Of two, the last one would decide, and the first be lost."""
    for option, *values in (("--move", "0", "0", "-1"), ("--clearance", "5"), ("--engine", "bulk")):
        words = ("check", *meshes, option, *values, option, *values)
        assert f"{option}: given twice" in refused(*words)


@pytest.mark.parametrize(
    ("words", "kept"),
    [
        (("check", "a.stl", "b.stl", "--json"), b"{" + bytes(83)),
        (("scene", "advise", "a.stl", "b.stl", "--json"), bytes(84)),
        (("verdict", "pairs.npy", "--out"), b'{"verdict": "clear"}'),
    ],
)
def test_what_is_no_older_answer_is_kept(tmp_path, words, kept, refused):
    """Whatever else is wrong."""
    other = tmp_path / "other.stl"
    other.write_bytes(kept)
    assert "is there, and is no" in refused(*words, other)
    assert other.read_bytes() == kept


def test_names_that_a_terminal_cannot_show_cost_no_answer(meshes, tmp_path):
    name = tmp_path / "fr\u00e4ser.stl"
    meshes[0].rename(name)
    told = subprocess.run(
        [TRIAXIS, "check", name, meshes[1], "--engine", "bulk"], capture_output=True, check=False,
        env={**os.environ, "PYTHONIOENCODING": "ascii:strict"},
    )  # fmt: skip
    assert (told.returncode, told.stderr) == (0, b"") and rb"fr\xe4ser.stl" in told.stdout


@pytest.mark.parametrize(
    "words",
    [
        ("scene", "examples", ""), ("tritest", "make", ""), ("results", "--parquet", ""),
        ("fpga", "ip", "triaxis_core", "--out", ""), ("fpga", "registers", "--pyuvm", ""),
    ],
)  # fmt: skip
def test_a_folder_without_a_name_is_none(words, refused):
    assert "names no folder: give one, or . for this one" in refused(*words)


@pytest.fixture
def small_disk(tmp_path):
    """Return a folder that holds 8 KiB."""
    folder = tmp_path / "small"
    folder.mkdir()
    options = ["mount", "-t", "tmpfs", "-o", "size=8k", "none", str(folder)]
    if subprocess.run(options, capture_output=True, check=False).returncode:
        pytest.skip("needs the right to mount a file system")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def test_a_full_disk_leaves_nothing_half_written(small_disk, meshes, refused, capsys):
    assert "No space left on device" in refused("scene", "examples", small_disk)
    assert list(small_disk.iterdir()) == []
    report = small_disk / "report.json"
    report.write_text('{"verdict": "clear"}')
    (small_disk / "full").write_bytes(bytes(4096))
    command = ("check", *meshes, "--engine", "golden", "--clearance", "20", "--json", report)
    # What it needs may have to be compiled, and says so.
    main([*map(str, command[:-2])])
    capsys.readouterr()
    assert "No space left on device" in refused(*command)
    assert json.loads(report.read_text()) == UNKNOWN
    assert sorted(path.name for path in small_disk.iterdir()) == ["full", "report.json"]


def test_all_that_the_package_reads_is_package_data():
    told = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    for package, folder in told["package-dir"].items():
        root, kinds = ROOT / folder, told["package-data"].get(package, ())
        found = {path for path in root.rglob("*.*") if path.is_file() and "tests" not in path.parts}
        read = {path for path in found if path.suffix not in (".py", ".pyc", ".md")}
        assert sorted(read - {path for kind in kinds for path in root.glob(kind)}) == []


def test_every_folder_with_modules_is_a_package_of_the_wheel():
    told = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["setuptools"]
    found = {
        ".".join(("triaxis", *init.parent.relative_to(ROOT).parts))
        for folder in told["package-dir"].values()
        for init in (ROOT / folder).rglob("__init__.py")
        if "tests" not in init.parts
    }
    assert found <= set(told["packages"])
