import subprocess
import sys

import pytest

from triaxis.golden import native
from triaxis.golden.errors import InputError
from triaxis.golden.native import native_library

ANSWER = '#include "answer.h"\nextern "C" int answer() { return ANSWER; }\n'


@pytest.fixture(autouse=True)
def build(monkeypatch, tmp_path):
    """Return a build folder of the test's own."""
    monkeypatch.setattr(native, "BUILD", tmp_path / "build" / "native")
    return native.BUILD


@pytest.fixture
def sources(tmp_path):
    source, header = tmp_path / "answer.cpp", tmp_path / "answer.h"
    source.write_text(ANSWER)
    header.write_text("#define ANSWER 42\n")
    return source, header


def answer_of(sources):
    return native_library("answer", sources[:1], sources[1:]).answer()


def test_compiles_once_and_again_after_a_change(build, sources):
    assert answer_of(sources) == 42
    (first,) = build.iterdir()
    written = first.stat().st_mtime_ns
    assert answer_of(sources) == 42
    assert first.stat().st_mtime_ns == written
    sources[1].write_text("#define ANSWER 43\n")
    assert answer_of(sources) == 43
    assert len(list(build.iterdir())) == 2


def test_errors_are_one_line_and_leave_no_library(build, sources, monkeypatch):
    sources[0].write_text("int f() { return undeclared; }\n")
    with pytest.raises(InputError, match=r"^answer: [^\n]* fails: [^\n]*undeclared[^\n]* \(log: [^\n]*$"):
        answer_of(sources)
    (log,) = build.iterdir()
    assert "undeclared" in log.read_text()
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler: not found: install it"):
        answer_of(sources)


def test_what_is_saved_while_it_is_compiled_leaves_no_library(build, sources, monkeypatch):
    run = subprocess.run

    def saved_meanwhile(*arguments, **options):
        sources[1].write_text("#define ANSWER 43\n")
        return run(*arguments, **options)

    monkeypatch.setattr(native.subprocess, "run", saved_meanwhile)
    with pytest.raises(InputError, match=r"^answer: its sources changed while it was compiled: run again$"):
        answer_of(sources)
    assert not list(build.iterdir())


def test_processes_at_the_same_time(build, sources):
    code = (
        "import sys; from pathlib import Path; from triaxis.golden import native\n"
        "native.BUILD, source, header = map(Path, sys.argv[1:])\n"
        "assert native.native_library('answer', [source], [header]).answer() == 42\n"
    )
    command = [sys.executable, "-c", code, str(build), *map(str, sources)]
    processes = [subprocess.Popen(command) for _ in range(3)]
    assert [process.wait() for process in processes] == [0, 0, 0]
    assert [path.suffix for path in build.iterdir()] == [".so"]
