"""Verify an archive of Triaxis' evidence: with Python's own library alone, trusting nobody.

    python3 verify.py [FOLDER]          (the folder of this file)

What is looked at, in the unpacked archive:

- every file is the one that SHA256SUMS has the hash of, and there are no others;
- the RTL in source/dut/ is that which was signed off, by a hash computed anew;
- the verdict follows from what was counted: figures are computed again from the parts of the sign-off, and
  all compared with the bounds of the last stage in source/coverage/stages.toml; no part failed or is of
  another RTL, and no problem was listed;
- each witness, a pair with its distance, is proven again by source/bench/tritest/recheck.py;
- attestation.json is about these very files, and sbom.cdx.json has every package of the lock files.

It does not run the sign-off again: `make signoff` in source/ does. Exit codes: 0 all of it holds; 1 something
does not; 2 there is no archive.
"""

import hashlib
import json
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

STAGE = "V3"
RTL = (".sv", ".svh", ".v", ".vh", ".f")
PARTS = ("testplan", "lint", "simulation", "exhaustive", "code_coverage", "faults", "mutation", "proofs")
ABSENT = "not measured"
KINDS = ("line", "branch", "expression", "toggle", "fsm", "antecedent")


def sha256(path: Path) -> str:
    """Return the hash of a file."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def files(folder: Path) -> Iterator[str]:
    """Return what is not as SHA256SUMS has it."""
    lines = (line.partition("  ") for line in (folder / "SHA256SUMS").read_text().splitlines())
    listed = {name: digest for digest, _, name in lines}
    there = {str(path.relative_to(folder)): path for path in folder.rglob("*") if not path.is_dir()}
    for name in sorted(listed.keys() | there.keys() - {"SHA256SUMS"}):
        if name not in there:
            yield f"{name}: is missing"
        elif name not in listed:
            yield f"{name}: is not listed in SHA256SUMS"
        elif there[name].is_symlink() or sha256(there[name]) != listed[name]:
            yield f"{name}: is not the file that was packed"


def rtl_hash(dut: Path) -> str:
    """Return the hash of all that elaborates, as sign-offs name it: of names and contents, in order."""
    digest = hashlib.sha256()
    for path in sorted(path for path in dut.rglob("*") if path.suffix in RTL and path.is_file()):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


def share(part: int, whole: int) -> float | None:
    """Return a share in percent, rounded down to two decimals."""
    return part * 10_000 // whole / 100 if whole else None


def figures(parts: dict[str, Any]) -> dict[str, float | None]:
    """Return what was counted, computed from the parts."""

    def passed(items: list[Any], key: str = "passed") -> float | None:
        return share(sum(item[key] is True for item in items), len(items))

    simulation, mutation, proofs = parts["simulation"], parts["mutation"], parts["proofs"]
    bins = [item for model in simulation["coverage"].values() for item in model.values()]
    mutants = mutation["files"].values()
    covered = {kind: total for kind, total in parts["code_coverage"]["totals"].items() if kind in KINDS}
    return {
        "lint_findings": parts["lint"]["findings"],
        "runs_passed": passed(simulation["runs"]),
        "mismatches": simulation["mismatches"],
        "pairs_checked": simulation["pairs_checked"],
        "functional_coverage": share(sum(b["hit"] for b in bins), sum(b["total"] for b in bins)),
        **{
            f"{kind}_coverage": share(total["hit"] + total["waived"], total["total"])
            for kind, total in covered.items()
        },
        "faults_caught": passed(parts["faults"]["faults"], "caught"),
        "mutation_score": share(
            sum(m["killed"] + m["equivalent"] for m in mutants), sum(m["mutants"] for m in mutants)
        ),
        "proofs_passed": None
        if proofs["undecided"]
        else passed([proof for proof in proofs["proofs"] if proof["result"] != ABSENT]),
    }


def verdict(folder: Path) -> Iterator[str]:
    """Return why the sign-off's verdict does not follow from what it counted."""
    signoff = json.loads((folder / "signoff/signoff.json").read_text())
    rtl = rtl_hash(folder / "source/dut")
    if signoff["rtl_hash"] != rtl:
        yield f"source/dut: RTL {rtl[:12]}: signed off was {signoff['rtl_hash'][:12]}"
    if signoff["passed"] is not True or signoff["problems"]:
        yield f"signoff.json: did not pass: {signoff['problems'][:1]}"
    parts, stored = signoff["parts"], signoff["figures"]
    for name in (*PARTS, *sorted(signoff["beside"])):
        part = parts.get(name) or signoff["beside"].get(name) or {}
        if name in signoff["beside"] and part.get("passed") is None and not signoff["whole"]:
            continue
        if part.get("passed") is not True or part.get("rtl_hash") != rtl:
            yield f"{name}: did not pass, or is of another RTL"
    for name, value in figures(parts).items():
        if stored.get(name) != value:
            yield f"{name}: {value} by what was counted, {stored.get(name)} in signoff.json"
    bounds = tomllib.loads((folder / "source/coverage/stages.toml").read_text())
    for name, bound in bounds.items():
        value = stored.get(name)
        least, most = bound.get("at_least", {}).get(STAGE), bound.get("at_most", {}).get(STAGE)
        if value is None or (least is not None and value < least) or (most is not None and value > most):
            yield f"{name}: {value}: wanted {'at least' if least is not None else 'at most'} {least or most}"


def witnesses(folder: Path) -> Iterator[str]:
    """Prove the pairs again; return what the checker says where one is not proven."""
    checker = [sys.executable, "-I", "-S", str(folder / "source/bench/tritest/recheck.py")]
    ran = subprocess.run([*checker, str(folder / "witnesses")], capture_output=True, text=True, check=False)
    print((ran.stdout.splitlines() or [""])[-1])
    if ran.returncode:
        yield f"witnesses: {(ran.stdout + ran.stderr).splitlines()[0]}"


def statements(folder: Path) -> Iterator[str]:
    """Return what the attestation and the bill of materials say that is not so."""
    attestation = json.loads((folder / "attestation.json").read_text())
    subjects = {subject["name"]: subject["digest"]["sha256"] for subject in attestation["subject"]}
    if subjects.get("rtl") != rtl_hash(folder / "source/dut"):
        yield "attestation.json: is about another RTL"
    if subjects.get("signoff.json") != sha256(folder / "signoff/signoff.json"):
        yield "attestation.json: is about another sign-off"
    if attestation["predicate"]["result"] != "PASSED":
        yield "attestation.json: does not say that it passed"
    bill = json.loads((folder / "sbom.cdx.json").read_text())
    named = {(one["name"], one["version"]) for one in bill["components"]}
    for lock in sorted((folder / "source").glob("requirements*.lock")):
        for name, version in re.findall(r"^([A-Za-z0-9._-]+)==(\S+)", lock.read_text(), re.MULTILINE):
            if (name, version) not in named:
                yield f"sbom.cdx.json: {name} {version} of {lock.name} is not in it"


def main() -> int:
    """Verify the archive; print what does not hold."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    if not (folder / "SHA256SUMS").is_file():
        print(f"verify: error: {folder}: no archive of evidence here", file=sys.stderr)
        return 2
    wrong = 0
    for check in (files, verdict, witnesses, statements):
        try:
            found = list(check(folder))
        # Of what is no file, or has another shape, nothing follows.
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            found = [f"{type(error).__name__}: {error}"]
        print(f"{check.__name__}: {'FAILED' if found else 'passed'}")
        print("".join(f"  {line}\n" for line in found), end="")
        wrong += len(found)
    print(f"{'FAILED' if wrong else 'PASSED'}: {wrong} things do not hold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
