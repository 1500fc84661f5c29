"""What is handed over: the archive, and the script that verifies it without the project."""

import hashlib
import json
import shutil
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.sim.validity import git
from triaxis.verif.signoff import archive
from triaxis.verif.signoff.tests.signoff_evidence import good_content, signed


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """Return an archive of a sign-off in which all is well, of this commit; the checkout may have changes."""
    folder = tmp_path_factory.mktemp("evidence")
    assert main(["tritest", "make", str(folder / "set"), "--pairs", "2"]) == 0
    (folder / "signoff").mkdir()
    result = folder / "signoff" / "signoff.json"
    result.write_text(json.dumps(good_content()))
    (folder / "signoff" / "index.html").write_text("page")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(archive, "git", lambda *words: "" if words[0] == "status" else git(*words))
        outs = [archive.pack(folder / f"{name}.tar.gz", folder / "set", result) for name in "ab"]
    assert outs[0].read_bytes() == outs[1].read_bytes()
    return outs[0]


@pytest.fixture
def unpacked(packed, tmp_path):
    with tarfile.open(packed) as file:
        file.extractall(tmp_path, filter="data")
    folder = tmp_path / "triaxis-evidence"
    return folder, json.loads((folder / "signoff/signoff.json").read_text())


def verified(folder):
    ran = subprocess.run(
        [sys.executable, "-I", "-S", str(folder / "verify.py")], capture_output=True, text=True, check=False
    )
    return ran.returncode, ran.stdout


def summed(folder, *names):
    """Have SHA256SUMS agree with files that were changed."""
    path = folder / "SHA256SUMS"
    parts = (line.partition("  ") for line in path.read_text().splitlines())
    lines = {name: digest for digest, _, name in parts}
    for name in names:
        lines[name] = hashlib.sha256((folder / name).read_bytes()).hexdigest()
    path.write_text("".join(f"{digest}  {name}\n" for name, digest in lines.items()))


def test_it_verifies_with_python_alone(unpacked):
    folder, _ = unpacked
    code, said = verified(folder)
    assert code == 0, said
    assert "PASSED: 62 pairs proven, 0 not" in said and said.endswith("PASSED: 0 things do not hold\n")
    assert len((folder / "verify.py").read_text().splitlines()) < 200


CHANGES = [
    (lambda c: c["parts"]["simulation"].update(mismatches=1), "mismatches: 1 by what was counted, 0"),
    (lambda c: c["figures"].update(mutation_score=99.0), "mutation_score: 100"),
    (lambda c: c["figures"].update(registers_proved=12.0), "registers_proved: 12.0: wanted at least 88"),
    (lambda c: c["parts"]["proofs"]["proofs"][0].update(passed=False), "proofs_passed: 0"),
    (lambda c: c["parts"]["faults"].update(passed=False), "faults: did not pass"),
    (lambda c: c["parts"].pop("lint"), "KeyError"),
    (lambda c: c.update(problems=["x"]), "signoff.json: did not pass"),
    (lambda c: c.update(rtl_hash="0" * 64), "signed off was 000000000000"),
]


@pytest.mark.parametrize(("change", "said"), CHANGES)
def test_a_verdict_that_does_not_follow_is_noticed(unpacked, change, said):
    folder, content = unpacked
    change(content)
    (folder / "signoff/signoff.json").write_text(json.dumps(content))
    summed(folder, "signoff/signoff.json")
    code, told = verified(folder)
    assert code == 1 and said in told and "about another sign-off" in told, told


def test_every_file_counts(unpacked):
    folder, _ = unpacked
    core = folder / "source/dut/core/triaxis_core.sv"
    core.write_text(core.read_text() + "\n")
    (folder / "more").write_text("")
    (folder / "README.txt").unlink()
    code, said = verified(folder)
    assert code == 1
    for line in (
        "source/dut/core/triaxis_core.sv: is not the file that was packed", "more: is not listed",
        "README.txt: is missing", "about another RTL",
    ):  # fmt: skip
        assert line in said
    shutil.rmtree(folder / "witnesses")
    assert "witnesses: FAILED" in verified(folder)[1]
    (folder / "SHA256SUMS").unlink()
    assert verified(folder)[0] == 2


def test_a_package_that_no_bill_names_is_noticed(unpacked):
    folder, _ = unpacked
    lock = folder / "source/requirements.lock"
    lock.write_text(lock.read_text() + "other==1.0\n")
    bill = json.loads((folder / "sbom.cdx.json").read_text())
    assert all(one["externalReferences"][0]["hashes"] for one in bill["components"])
    assert "other 1.0 of requirements.lock is not in it" in verified(folder)[1]


def test_no_evidence_without_a_sign_off_a_commit_and_witnesses(tmp_path, monkeypatch):
    result = tmp_path / "signoff.json"
    out, witnesses = tmp_path / "out", tmp_path / "set"
    with pytest.raises(InputError, match="no sign-off"):
        archive.pack(out, witnesses, result)
    content = signed().content()
    result.write_text(json.dumps({**content, "passed": False}))
    with pytest.raises(InputError, match="did not pass"):
        archive.pack(out, witnesses, result)
    result.write_text(json.dumps(content))
    monkeypatch.setattr(archive, "git", lambda *_: " M README.md")
    with pytest.raises(InputError, match="uncommitted"):
        archive.pack(out, witnesses, result)
    monkeypatch.setattr(archive, "git", lambda *_: "")
    with pytest.raises(InputError, match="no TriTest set"):
        archive.pack(out, witnesses, result)
    assert not Path(out).exists()
