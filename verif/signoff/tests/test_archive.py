"""What is handed over: the archive, and the script that verifies it without the project."""

import hashlib
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.host.cli import main
from triaxis.host.tests.published import read_published
from triaxis.sim.build import rtl_files
from triaxis.sim.paths import ROOT
from triaxis.sim.validity import git
from triaxis.verif.signoff import archive, page
from triaxis.verif.signoff.gate import SOURCES
from triaxis.verif.signoff.tests.signoff_evidence import signed


def held():
    """Return what is signed off as the checkout has it."""
    return {str(path.relative_to(ROOT)): path.read_bytes() for path in (*rtl_files(), *SOURCES.files())}


@pytest.fixture(scope="module")
def packed(tmp_path_factory):
    """Return an archive of a sign-off in which all is well, of this commit; the checkout may have changes."""
    folder = tmp_path_factory.mktemp("evidence")
    assert main(["tritest", "make", str(folder / "set"), "--pairs", "2"]) == 0
    (folder / "signoff").mkdir()
    result = folder / "signoff" / "signoff.json"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(page, "RESULT", result)
        patch.setattr(page, "PAGE", result.with_name("index.html"))
        page.write(signed())
        patch.setattr(archive, "git", lambda *words: "" if words[0] == "status" else git(*words))
        commit = archive._source
        patch.setattr(archive, "_source", lambda: commit() | held())
        outs = [archive.pack(folder / f"{name}.tar.gz", folder / "set", result) for name in "ab"]
    assert outs[0].read_bytes() == outs[1].read_bytes()
    return outs[0]


@pytest.fixture
def unpacked(packed, tmp_path):
    subprocess.run(["tar", "xf", packed, "-C", tmp_path], check=True)
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
    read_published(folder / "signoff/signoff.json", "signoff")
    families = json.loads((folder / "witnesses/set.json").read_text())["families"]
    code, said = verified(folder)
    assert code == 0, said
    assert f"PASSED: {2 * len(families)} pairs proven, 0 not" in said and said.splitlines()[-1].startswith(
        "PASSED: SHA256SUMS "
    )
    assert len((folder / "verify.py").read_text().splitlines()) < 200


def part(name, **changes):
    return lambda content: content["parts"][name].update(changes)


def first(name, items, **changes):
    return lambda content: content["parts"][name][items][0].update(changes)


def mutants(**changes):
    return lambda content: content["parts"]["mutation"]["files"]["a.sv"].update(changes)


def figure(**changes):
    return lambda content: content["figures"].update(changes)


CHANGES = [
    (first("simulation", "runs", passed=False), "runs_passed: 0"),
    (lambda c: c["parts"]["simulation"]["runs"][0]["counts"].update(failed=1), "mismatches: 1 by what was"),
    (lambda c: c["parts"]["simulation"]["runs"][0]["counts"].update(checked=5), "pairs_checked: 5 by"),
    (part("simulation", pairs_checked=5), "pairs_checked: 5 by"),
    (first("simulation", "scenes", agrees=False), "agrees: False"),
    (first("simulation", "scenes", found="clear"), "scene tool: clear"),
    (part("simulation", scenes=[]), "scenes: []"),
    (lambda c: c["parts"]["simulation"]["detector"].update(pairs=0), "pairs: 0"),
    (lambda c: c["parts"]["simulation"]["solvers"].update(pairs=0), "pairs: 0"),
    (lambda c: c["parts"]["exhaustive"]["counts"].update(mismatches=1), "mismatches: 1"),
    (part("code_coverage", uncovered=["a.sv:1"]), "uncovered: ["),
    (part("code_coverage", runs=[]), "runs: []"),
    (first("code_coverage", "runs", wrong=1), "wrong: 1"),
    (first("code_coverage", "runs", checked=0), "checked: 0"),
    (part("lint", linters={}), "linters: {}"),
    (lambda c: c["parts"]["faults"]["control"].update(passed=False), "control.passed: False"),
    (first("testplan", "requirements", passed=False), "requirements.0.passed: False"),
    (part("testplan", requirements=[]), "requirements: []"),
    (lambda c: c["checklist"][0].update(answer="open"), "checklist.0.answer: open"),
    (lambda c: c["chain"][0].update(state="failed"), "chain.0.state: failed"),
    (lambda c: c["beside"].update(netlist={"absent": "run it"}), "and that is not said"),
    (part("code_coverage", totals={}), "KeyError"),
    (part("code_coverage", waivers_void=5), "waivers_void: 5 by"),
    (figure(mutation_score=99.0), "mutation_score: 100"),
    (figure(registers_proved=float("nan")), "nan in signoff.json"),
    (figure(more=1), "more: None by"),
    (mutants(killed=20), "ValueError: 22 of 12"),
    (mutants(surviving=1), "surviving: 1"),
    (part("mutation", killed=["one"]), "killed: not as many"),
    (lambda c: (c.update(whole=True), c["parts"]["mutation"].update(recorded=1)), "and that is not said"),
    (lambda c: (c.update(whole=True), c["parts"]["mutation"].update(sample=1)), "and that is not said"),
    (part("mutation", recorded=1), "and that is not said"),
    (part("mutation", entries_recorded=1), "and that is not said"),
    (
        lambda c: (
            c["parts"]["mutation"].update(recorded=1, entries_recorded=1),
            c.update(exceptions=["mutants: 1 as recorded of"]),
        ),
        "and that is not said",
    ),
    (
        lambda c: (c.update(whole=True), c["parts"]["mutation"].update(entries_recorded=1)),
        "and that is not said",
    ),
    (part("mutation", survivors=[{}]), "survivors: not as many"),
    (
        lambda c: c["parts"]["proofs"]["registers"]["modules"]["triaxis_fifo"].update(covered=9),
        "registers_proved: 9",
    ),
    (first("proofs", "proofs", passed=False), "proofs_passed: 0"),
    (first("proofs", "proofs", result="not measured"), "proofs: order: not measured"),
    (
        lambda c: c["parts"]["proofs"]["proofs"].append(
            {
                **c["parts"]["proofs"]["proofs"][0],
                "name": "theorem",
                "passed": False,
                "result": "not measured",
            }
        ),
        "and that is not said",
    ),
    (first("testplan", "testpoints", passed=False), "testpoints_v1: 0"),
    (part("testplan", testpoints=[]), "testpoints_v1: None by"),
    (part("faults", passed=False), "faults: did not pass"),
    (part("faults", problems=["x"]), "open_problems: 1"),
    (lambda c: c["parts"].pop("lint"), "has other parts"),
    (lambda c: (c["parts"]["lint"].pop("passed"), c["beside"].update(lint={})), "lint: did not pass"),
    (lambda c: c.update(whole=True, beside={}), "has other parts"),
    (lambda c: (c.update(whole=True), c["beside"].update(netlist={"absent": "x"})), "netlist: did not pass"),
    (lambda c: c.update(problems=None), "signoff.json: did not pass"),
    (lambda c: c.update(stage="V1"), "signoff.json: did not pass"),
    (lambda c: c.update(rtl_hash="0" * 64), "signed off was 000000000000"),
]


@pytest.mark.long
@pytest.mark.parametrize(("change", "said"), CHANGES)
def test_a_verdict_that_does_not_follow_is_noticed(unpacked, change, said):
    folder, content = unpacked
    change(content)
    (folder / "signoff/signoff.json").write_text(json.dumps(content))
    summed(folder, "signoff/signoff.json")
    code, told = verified(folder)
    # The sums are others than those that were attested; and nothing of such an archive is run.
    assert code == 1 and said in told and "is not about these files" in told, told
    assert "pairs proven" not in told


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
        "README.txt: is missing", "is not about these files",
    ):  # fmt: skip
        assert line in said
    os.mkfifo(folder / "source" / "pipe")
    assert "source/pipe: is not listed in SHA256SUMS" in verified(folder)[1]
    (folder / "source" / "pipe").unlink()
    (folder / "source" / "evil").symlink_to("/etc")
    assert "source/evil: is a link" in verified(folder)[1]
    (folder / "SHA256SUMS").unlink()
    assert verified(folder)[0] == 2


def test_witnesses_are_proven_again_and_bounds_are_needed(unpacked):
    folder, content = unpacked
    for name, text, said in (
        ("witnesses/set.json", "{}", "KeyError"), ("source/coverage/stages.toml", "", "mismatches: 0 by"),
        ("source/coverage/stages.toml", "[mismatches]\nat_most = { V3 = nan }", "mismatches: 0 by"),
        ("source/coverage/stages.toml", "[x]\nat_most = { V3 = 1 }\nat_least = { V3 = 0 }", "x: None by"),
    ):  # fmt: skip
        before = (folder / name).read_text()
        (folder / name).write_text(text)
        again(folder, name, content)
        code, told = verified(folder)
        assert code == 1 and said in told, told
        (folder / name).write_text(before)
        again(folder, name, content)
    # A wrong one, in a set that says so of itself.
    family = json.loads((folder / "witnesses/set.json").read_text())["families"][0]["name"]
    path = folder / f"witnesses/{family}.txt.gz"
    path.write_bytes(path.read_bytes() + b"\n")
    again(folder, f"witnesses/{path.name}", content)
    assert "exit code 2" in verified(folder)[1]


def again(folder, name, content):
    """Have sums and statement agree with a file that was changed."""
    summed(folder, name)
    statement = archive._attestation(content, (folder / "SHA256SUMS").read_bytes())
    (folder / "attestation.json").write_bytes(archive._json(statement))


def test_nothing_beside_the_script_is_run(unpacked):
    folder, _ = unpacked
    (folder / "tomllib.py").write_text("raise SystemExit(0)")
    assert verified(folder)[0] == 1


def test_a_package_that_no_bill_names_is_noticed(unpacked):
    folder, _ = unpacked
    lock = folder / "source/requirements.lock"
    lock.write_text(lock.read_text() + "other==1.0\n")
    bill = json.loads((folder / "sbom.cdx.json").read_text())
    assert all(one["externalReferences"][0]["hashes"] for one in bill["components"])
    assert "other packages than those of the lock files" in verified(folder)[1]


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
    monkeypatch.setattr(archive, "git", lambda *words: "" if words[0] == "status" else git(*words))
    with pytest.raises(InputError, match="no TriTest set"):
        archive.pack(out, witnesses, result)
    witnesses.mkdir()
    (witnesses / "set.json").write_text("{}")
    source = archive._source
    monkeypatch.setattr(archive, "_source", lambda: source() | {"dut/core/triaxis_core.sv": b""})
    with pytest.raises(InputError, match=r"triaxis_core\.sv: is not what the commit holds"):
        archive.pack(out, witnesses, result)
    monkeypatch.setattr(archive, "_source", lambda: source() | held())
    result.with_name("index.html").write_text("page")
    with pytest.raises(InputError, match="make it anew"):
        archive.pack(out, witnesses, result)
    # Killed, it says nothing.
    monkeypatch.setattr(archive.sys, "executable", "false")
    with pytest.raises(InputError, match=r"set: exit code 1: make it anew"):
        archive.pack(out, witnesses, result)
    assert not Path(out).exists()


def test_what_is_packed_is_of_this_checkout_whatever_git_is_told(tmp_path, monkeypatch):
    for words in (("init", "-q"), ("commit", "-q", "--allow-empty", "-m", "Another")):
        named = ("-c", "user.name=a", "-c", "user.email=a@b")
        subprocess.run(["git", *named, "-C", str(tmp_path), *words], check=True)
    monkeypatch.setenv("GIT_DIR", str(tmp_path / ".git"))
    assert "README.md" in archive._source()
    monkeypatch.setattr(archive, "git", lambda *_: None)
    with pytest.raises(InputError, match="git cannot pack the commit"):
        archive._source()
