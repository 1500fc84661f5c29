"""Results are valid for all that decides them, and for nothing else."""

import json
import shutil
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim import validity
from triaxis.sim.paths import DUT, ROOT
from triaxis.sim.validity import Sources, standing
from triaxis.verif.code_coverage import run as code_coverage
from triaxis.verif.faults import catching
from triaxis.verif.formal import proving
from triaxis.verif.formal.proof import Finding, Proof
from triaxis.verif.mutation.killers import OUTCOMES
from triaxis.verif.regress.one_job import SOURCES
from triaxis.verif.signoff import gate
from triaxis.verif.testbench.settings import block_of
from triaxis.verif.testbench.table import names_of
from triaxis.verif.upsets import campaign


def names(sources: Sources) -> set[str]:
    return {str(path.relative_to(ROOT)) for path in sources.files()}


def test_all_that_a_simulation_loads_counts_and_no_more() -> None:
    code = (
        "import json, os, sys; from triaxis.verif.testbench.settings import RunSettings; "
        "os.environ.update(RunSettings('MixedTest', 1, 'w16_m0', 1, '.').to_environment()); "
        "import triaxis.verif.core.uvm_tests, triaxis.verif.mesh.uvm_tests; "
        "import triaxis.verif.testbench.simulation; "
        "files = [getattr(m, '__file__', None) for n, m in sys.modules.items() if n.startswith('triaxis.')]; "
        "print(json.dumps([f for f in files if f]))"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    loaded = {str(Path(name).resolve().relative_to(ROOT)) for name in json.loads(answer.stdout)}
    found = names(SOURCES)
    assert len(loaded) > 40 and loaded <= found
    assert {"sim/core_player.cpp", "verif/core/sva/triaxis_core_sva.sv", "golden/bulk.cpp"} <= found
    assert not any(name.startswith(("host/cli", "bench", "docs")) or "/tests/" in name for name in found)
    # Nor does a page or a command void a sign-off.
    found = names(gate.SOURCES)
    assert {"coverage/waivers.toml", "verif/faults/patches/F2.patch", "verif/core/uvm_tests.py"} <= found
    assert not any(name.startswith(("host/cli", "verif/signoff/page.py")) for name in found)


@pytest.mark.parametrize("config", ["w8_m8", "mesh_w8_m8_d64_g8_l2", "board_w8_m0_d16_g4_l2"])
def test_what_plays_a_blocks_mutants_loads_nothing_that_their_record_does_not_know(config) -> None:
    test = names_of(block_of(config))[0]
    code = (
        "import os, sys; from triaxis.verif.testbench.settings import RunSettings; "
        f"os.environ.update(RunSettings({test!r}, 1, {config!r}, 1, '.').to_environment()); "
        "import triaxis.verif.testbench.entry; "
        "print(*(n for n in sys.modules if n.startswith('triaxis.')))"
    )
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    known = names(OUTCOMES[config.partition("_")[0] if "_d" in config else "core"])
    loaded = {name.removeprefix("triaxis.").replace(".", "/") for name in answer.stdout.split()}
    assert len(loaded) > 30
    assert {f"{name}.py" for name in loaded if (ROOT / f"{name}.py").exists()} <= known


def test_a_checkout_is_clean_where_each_file_is_that_of_the_commit(tmp_path, monkeypatch) -> None:
    """Whatever the index, ignored names or variables of git say."""
    rtl, data, late = tmp_path / "core.sv", tmp_path / "data.toml", tmp_path / "late.toml"
    for file in (rtl, data):
        file.write_text("right")
    monkeypatch.setattr(validity, "ROOT", tmp_path)
    monkeypatch.setattr(validity, "rtl_files", lambda *_: [rtl])
    sources = Sources((), ("*.toml",))
    assert validity._is_clean(sources) is None
    identity = ("-c", "user.name=a", "-c", "user.email=a@example.org")
    for arguments in (("init", "-q"), ("add", "."), (*identity, "commit", "-q", "-m", "all")):
        assert validity.git(*arguments) is not None
    monkeypatch.setenv("GIT_DIR", str(ROOT / ".git"))
    assert validity._is_clean(sources)
    late.write_text("ignored")
    (tmp_path / ".git" / "info" / "exclude").write_text("late.toml")
    assert validity._is_clean(sources) is False
    late.unlink()
    assert validity._is_clean(sources)
    validity.git("config", "status.showUntrackedFiles", "no")
    (tmp_path / "new").touch()
    assert validity._is_clean(sources) is False
    (tmp_path / "new").unlink()
    for way in ("--assume-unchanged", "--skip-worktree"):
        validity.git("update-index", way, "core.sv")
        rtl.write_text("wrong")
        assert validity._is_clean(sources) is False, way
        rtl.write_text("right")
        assert validity._is_clean(sources), way


def test_whatever_is_imported_anywhere_in_a_module_changes_the_hash(tmp_path, monkeypatch) -> None:
    monkeypatch.setattr(validity, "ROOT", tmp_path)
    for folder, text in (("a", "def f():\n    from triaxis.b import part\n"), ("b", ""), ("c", "")):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "__init__.py").touch()
        (tmp_path / folder / "part.py").write_text(text)
    sources = Sources(("triaxis.a.part",))
    validity._imported.cache_clear()
    before = sources.hash()
    for changed, voids in (("b/part.py", 1), ("b/__init__.py", 1), ("c/part.py", 0), ("b/x.sv", 1)):
        (tmp_path / changed).write_text("# changed")
        after = sources.hash()
        assert (after != before) == bool(voids), changed
        before = after
    validity._imported.cache_clear()
    with pytest.raises(ValueError, match=r"triaxis\.gone: no such module"):
        Sources(("triaxis.gone",)).files()


def test_an_edit_that_is_taken_back_is_seen(tmp_path):
    dut = tmp_path / "dut"
    shutil.copytree(DUT, dut)
    sources = Sources(("triaxis.sim.validity",))
    file = dut / "core" / "triaxis_core.sv"
    before, text = standing(sources, dut), file.read_text()
    assert before.stands
    file.write_text("another")
    assert not before.stands
    # What is said is of the RTL that was named.
    assert standing(sources, dut).valid_for.rtl_hash != before.valid_for.rtl_hash
    file.write_text(text)
    with pytest.raises(InputError, match="was written to during the run"):
        before.check()
    again = standing(sources, dut)
    (dut / "core" / "new.sv").write_text("")
    assert not again.stands


class Given(Proof):
    """One that holds."""

    def attempt(self, dut, folder):
        return Finding()


@pytest.mark.parametrize("method", [code_coverage, catching, campaign, proving])
def test_what_is_written_to_while_a_method_waits_for_another_run_is_seen(tmp_path, monkeypatch, method):
    file = tmp_path / "a.sv"
    file.write_text("module a; endmodule\n")
    monkeypatch.setattr("triaxis.sim.validity.rtl_files", lambda _: [file])
    monkeypatch.setattr("triaxis.sim.validity._is_clean", lambda _: True)
    monkeypatch.setattr(method, "make_folder", lambda _: None)

    class Lock(nullcontext):
        def __enter__(self):
            # Time stamps of files may be some milliseconds late.
            time.sleep(0.05)
            file.write_text(file.read_text())

    monkeypatch.setattr(method, "FileLock", Lock)
    if method is code_coverage:
        monkeypatch.setattr(method, "_run_all", lambda *_: ([], []))
        assert method.measure(1).changed
    elif method is catching:
        assert method.catch_all(lambda _: None, faults=()).changed
    elif method is proving:
        given = [Given(name, "a claim", "given", {}, ()) for name in "ab"]
        monkeypatch.setattr(method, "proofs", lambda: given)
        monkeypatch.setattr(method, "require_tools", lambda: None)
        assert method.prove_all(lambda _: None, only="a").changed
    else:
        stood: list[bool] = []
        monkeypatch.setattr(method, "_upset_board", lambda *given: stood.append(given[-1].stands))
        method.upset_board(lambda _: None)
        assert stood == [False]
