"""Older answers, and interrupts at any moment of a real process."""

import json
import os
import random
import signal
import subprocess
import time
from pathlib import Path

import pytest

from triaxis.host.tests.test_cli import TRIAXIS, meshes, refused, triaxis

__all__ = ["meshes"]

_MOMENTS = 12


def started(*words: object) -> subprocess.Popen[bytes]:
    """Start a command; return when it handles signals, before which nothing can be promised."""
    process = subprocess.Popen([TRIAXIS, *map(str, words)], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    status = Path(f"/proc/{process.pid}/status")
    while process.poll() is None:
        caught = next(line for line in status.read_text().splitlines() if line.startswith("SigCgt"))
        if int(caught.split()[1], 16) & 1 << (signal.SIGHUP - 1):
            break
    return process


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_no_moment_leaves_an_older_answer(meshes, tmp_path, seed, number):
    report = tmp_path / "report.json"
    command = ("check", *meshes, "--engine", "golden", "--clearance", "2", "--json", report)
    begun = time.monotonic()
    triaxis(*command, status=1)
    whole, chance = time.monotonic() - begun, random.Random(seed)
    for moment in range(_MOMENTS):
        # Of a run that said what this one cannot say.
        report.write_text('{"verdict": "clear"}')
        with started(*command) as process:
            time.sleep(whole * moment * chance.uniform(0.8, 1.2) / _MOMENTS)
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


def test_ignored_signals_stay_ignored(meshes):
    command = ["nohup", TRIAXIS, "check", *meshes, "--engine", "golden"]
    with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as process:
        for _ in range(10):
            time.sleep(0.02)
            process.send_signal(signal.SIGHUP)
        assert process.wait() == 0


def test_whatever_fails_leaves_no_older_answer(meshes, tmp_path):
    report, picture, out = (tmp_path / name for name in ("report.json", "path.png", "out.npy"))
    for words in (
        ("check", *meshes, "--json", report, "--no-such-option"),
        ("check", meshes[0], tmp_path / "no.stl", f"--json={report}"),
        ("path", *meshes, tmp_path / "no.nc", "--json", report, "--picture", picture),
        ("path", *meshes, tmp_path / "no.nc", "--json", report, "--picture", tmp_path / "path.gif"),
        ("board", "check", *meshes, "--port", tmp_path / "no", "--json", report),
        ("verdict", tmp_path / "no.npy", "--engine", "rtl", "--out", out),
        ("verdict", "--out", out),
    ):
        for path in (report, picture, out):
            path.write_text('{"verdict": "clear"}')
        refused(*words)
        if report in words:
            assert json.loads(report.read_text()) == {"verdict": "unknown"}
        assert (picture in words) == (not picture.exists())
        assert (out in words) == (not out.exists())


def test_outputs_that_cannot_be(meshes, tmp_path):
    for words, why in (
        (("--json", ""), "--json: names no file"),
        (("--json", os.devnull), "/dev/null: is a device"),
        (("--json", "/dev/stdout"), "/dev/stdout: is a device or a pipe"),
        (("--json", tmp_path), "is a folder"),
        (("--json", meshes[1]), "is an input file"),
        ((f"--json={tmp_path / '..' / tmp_path.name / 'a.stl'}",), "is an input file"),
    ):
        before = meshes[0].read_bytes(), meshes[1].read_bytes()
        assert why in refused("check", *meshes, *words)
        assert (meshes[0].read_bytes(), meshes[1].read_bytes()) == before
    same = tmp_path / "same.png"
    words = ("path", *meshes, tmp_path / "moves.nc", "--json", same, "--picture", same)
    assert "named for two outputs" in refused(*words)
    log = tmp_path / "log"
    with log.open("w") as file:
        command = [TRIAXIS, "check", *meshes, "--json", log]
        answer = subprocess.run(command, stdout=file, stderr=subprocess.PIPE, check=False)
    assert answer.returncode == 2
    assert b"the output of this very command goes there" in answer.stderr


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


def test_a_full_disk_leaves_nothing_half_written(small_disk, meshes):
    assert "No space left on device" in refused("scene", "examples", small_disk)
    assert list(small_disk.iterdir()) == []
    report = small_disk / "report.json"
    report.write_text('{"verdict": "clear"}')
    (small_disk / "full").write_bytes(bytes(4096))
    command = ("check", *meshes, "--engine", "golden", "--clearance", "20", "--json", report)
    assert "No space left on device" in refused(*command)
    assert json.loads(report.read_text()) == {"verdict": "unknown"}
    assert sorted(path.name for path in small_disk.iterdir()) == ["full", "report.json"]
