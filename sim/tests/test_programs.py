"""Programs of others that do not start are one error, and what a limit ends has decided nothing."""

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim import programs


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
