import shutil

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim import toolchain


@pytest.fixture(autouse=True)
def fresh():
    toolchain.verilator.cache_clear()
    yield
    toolchain.verilator.cache_clear()


def stand_in(folder, answer):
    """Write an executable that answers --version."""
    path = folder / "verilator"
    path.write_text(f"#!/bin/sh\necho '{answer}'\n")
    path.chmod(0o755)
    return path


def test_package_index_by_default(monkeypatch):
    monkeypatch.delenv("VERILATOR", raising=False)
    found = toolchain.verilator()
    assert found.origin == "package index"
    assert found.version >= toolchain.OLDEST_VERILATOR
    assert shutil.which("verilator", path=found.environment()["PATH"])


def test_a_system_verilator_is_taken_and_recorded(monkeypatch, tmp_path):
    path = stand_in(tmp_path, "Verilator 5.036 2025-04-27 rev v5.036")
    monkeypatch.setenv("VERILATOR", str(path))
    assert str(toolchain.verilator()) == f"5.036 ({path})"


@pytest.mark.parametrize(
    ("answer", "message"),
    [("Verilator 5.035 2025-03-01", "5.036 or newer"), ("something else", "does not answer")],
)
def test_an_old_or_strange_one_is_refused(monkeypatch, tmp_path, answer, message):
    monkeypatch.setenv("VERILATOR", str(stand_in(tmp_path, answer)))
    with pytest.raises(InputError, match=message):
        toolchain.verilator()


def test_missing_tools_are_named(monkeypatch):
    monkeypatch.setenv("VERILATOR", "/nowhere/verilator")
    with pytest.raises(InputError, match="no such executable: install it, or unset VERILATOR"):
        toolchain.verilator()
    monkeypatch.delenv("VERILATOR")
    monkeypatch.setenv("CXX", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler: not found: install it"):
        toolchain.verilator()
