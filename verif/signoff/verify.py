"""Verify an archive of Triaxis' evidence: with Python's own library alone.

    python3 -I verify.py [FOLDER]       (that of this file; -I: nothing else in it is run)

- Every file is the one that SHA256SUMS has the hash of; there are no others, and no links.
- The RTL in source/dut/ is that which was signed off. The verdict follows from what was counted: each figure
  is computed again, and held against its bound in source/coverage/stages.toml; nothing is open.
- Each witness, a pair with its distance, is proven again by source/bench/tritest/recheck.py.
- attestation.json is about these, and sbom.cdx.json has the packages of the lock files.

Who can change everything can change all of it alike: take verify.py from the project, and compare the hash
that it prints with a signed one. Exit codes: 0 all holds; 1 something does not; 2 there is no archive.
"""

import hashlib
import json
import math
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

STAGES, RTL = ("V1", "V2", "V3"), (".sv", ".svh", ".v", ".vh", ".f")
PARTS = ("testplan", "lint", "simulation", "exhaustive", "code_coverage", "faults", "mutation", "proofs")
BESIDE, UNLISTED = ("four_state", "netlist"), ("SHA256SUMS", "attestation.json")
KINDS = ("line", "branch", "expression", "toggle", "fsm", "antecedent")
PROVED, ABSENT, MAY_BE = "proved", "not measured", ("theorem", "not measured")  # where it is no whole one
TAKEN = (("recorded", "mutants"), ("entries_recorded", "proofs of equivalence"))  # from the record; as what
NONE = ("mismatches", "wrong", "different", "uncovered", "surviving")  # what must be none, true, or some
YES, SOME = ("passed", "agrees", "caught"), ("linters", "runs", "scenes", "pairs", "checked", "requirements")


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _files(folder: Path) -> Iterator[str]:
    lines = [line.partition("  ") for line in (folder / "SHA256SUMS").read_text().splitlines()]
    listed = {name: digest for digest, _, name in lines}
    every = {path.relative_to(folder).as_posix(): path for path in folder.rglob("*")}
    yield from (f"{name}: is a link" for name, path in every.items() if path.is_symlink())
    there = {name: path for name, path in every.items() if not path.is_dir()}
    yield from ["SHA256SUMS: names a file twice"] * (len(listed) != len(lines))
    yield from (f"{name}: is missing" for name in sorted({*listed, *UNLISTED} - there.keys()))
    for name, path in sorted(there.items()):
        if name not in UNLISTED and (not path.is_file() or _sha256(path) != listed.get(name)):
            yield f"{name}: is not {'the file that was packed' if name in listed else 'listed in SHA256SUMS'}"


def _rtl_hash(dut: Path) -> str:
    rtl = sorted(path for path in dut.rglob("*") if path.suffix in RTL and path.is_file())
    return hashlib.sha256(b"".join(x.name.encode() + b"\0" + x.read_bytes() + b"\0" for x in rtl)).hexdigest()


def _share(part: int, whole: int) -> float | None:
    if type(part) is not int or type(whole) is not int or not 0 <= part <= whole:
        raise ValueError(f"{part} of {whole}: no count")
    return part * 10_000 // whole / 100 if whole else None


def _sum(rows: Iterable[Any], *keys: str) -> int:
    return sum(row[key] for row in rows for key in keys)


def _passed(items: list[Any], key: str = "passed") -> float | None:
    return _share(sum(item[key] is True for item in items), len(items))


def figures(parts: dict[str, Any]) -> dict[str, Any]:
    """Return each figure as it follows from what the parts counted."""
    simulation, mutation, proofs = parts["simulation"], parts["mutation"], parts["proofs"]
    bins, runs = [x for model in simulation["coverage"].values() for x in model.values()], simulation["runs"]
    mutants, registers = mutation["files"].values(), proofs["registers"]["modules"].values()
    totals, points = parts["code_coverage"]["totals"], parts["testplan"]["testpoints"]
    return {
        "lint_findings": sum(map(len, parts["lint"]["linters"].values())),
        "runs_passed": _passed(runs),
        "mismatches": sum(run["counts"]["failed"] for run in runs),
        "pairs_checked": min(simulation["pairs_checked"], _sum([r["counts"] for r in runs], "checked")),
        "functional_coverage": _share(_sum(bins, "hit"), _sum(bins, "total")),
        **{f"{k}_coverage": _share(_sum([totals[k]], "hit", "waived"), totals[k]["total"]) for k in KINDS},
        "waivers_void": parts["code_coverage"]["waivers_void"],
        "faults_caught": _passed(parts["faults"]["faults"], "caught"),
        "mutation_score": _share(_sum(mutants, "killed", "equivalent"), _sum(mutants, "mutants")),
        "proofs_passed": _passed([proof for proof in proofs["proofs"] if proof["result"] != ABSENT]),
        "registers_proved": _share(_sum(registers, "covered"), _sum(registers, "total")),
        "registers_unexplained": proofs["registers"]["unexplained"],
        **{f"testpoints_{s.lower()}": _passed([p for p in points if p["stage"] == s]) for s in STAGES},
        "open_problems": sum(len(part["problems"]) for part in parts.values()),
    }


def left_open(value: Any, where: str) -> Iterator[str]:
    """Yield what is open, failed, or there where nothing may be, anywhere below a place."""
    of: Any = dict(enumerate(value)) if isinstance(value, list) else value if isinstance(value, dict) else {}
    for key, held in of.items():
        bad = held in ("open", "failed") or (key in NONE and held) or (key in SOME and held in (0, [], {}))
        if bad or (key in YES and held is not True and of.get("result") != ABSENT):
            yield f"{where}.{key}: {held}"
        yield from left_open(held, f"{where}.{key}")


def contradictions(parts: dict[str, Any], whole: bool) -> Iterator[str]:
    """Yield where parts do not add up."""
    simulation, mutation = parts["simulation"], parts["mutation"]
    for name, row in mutation["files"].items():
        if row["killed"] + row["equivalent"] != row["mutants"]:
            yield f"mutation: {name}: {row}: a mutant survives, or they do not add up"
    for listed, counted in (("killed",) * 2, ("equivalents", "equivalent"), ("survivors", "surviving")):
        if len(mutation[listed]) != _sum(mutation["files"].values(), counted):
            yield f"mutation: {listed}: not as many as are counted"
    items = [item for model in simulation["coverage"].values() for item in model.items()]
    yield from (f"coverage: {name}: {item}" for name, item in items if not 0 <= item["hit"] <= item["total"])
    scenes = simulation["scenes"] + (simulation["real_meshes"] or [])
    yield from (f"scene {x['name']}: {x['found']}" for x in scenes if x["found"] != x["expected"])
    unproved = [(x["name"], x["result"]) for x in parts["proofs"]["proofs"] if x["result"] != PROVED]
    yield from (f"proofs: {name}: {what}" for name, what in unproved if whole or (name, what) != MAY_BE)


def _verdict(folder: Path) -> Iterator[str]:
    signoff, rtl = json.loads((folder / "signoff/signoff.json").read_text()), _rtl_hash(folder / "source/dut")
    if signoff["rtl_hash"] != rtl:
        yield f"source/dut: RTL {rtl[:12]}: signed off was {signoff['rtl_hash'][:12]}"
    if (signoff["passed"], signoff["problems"], signoff["stage"]) != (True, [], STAGES[-1]):
        yield f"signoff.json: did not pass: {signoff['problems']}"
    parts, beside, whole = signoff["parts"], signoff["beside"], signoff["whole"]
    if set(parts) != set(PARTS) or set(beside) != set(BESIDE) or type(whole) is not bool:
        yield "signoff.json: has other parts"
    needed = {name: part for name, part in beside.items() if whole or set(part) != {"absent"}}
    for name, part in [*parts.items(), *needed.items()]:
        if part.get("passed") is not True or part.get("rtl_hash") != rtl or part.get("problems") != []:
            yield f"{name}: did not pass, or is of another RTL"
    yield from left_open(signoff, "signoff")
    yield from contradictions(parts, whole)
    run, told = parts["mutation"], {line.partition(":")[0] for line in signoff["exceptions"]}
    taken = {said for key, said in TAKEN if run[key]} | {x.replace("_", " ") for x in beside.keys() - needed}
    taken |= {proof["name"] for proof in parts["proofs"]["proofs"] if proof["result"] == ABSENT}
    if taken - told or (whole and (taken or run["sample"] is not None)):
        yield "mutation, proofs, beside: not all was played, or something is absent, and that is not said"
    stored, found = signoff["figures"], figures(parts)
    bounds = tomllib.loads((folder / "source/coverage/stages.toml").read_text())
    for name in sorted(stored.keys() | found.keys() | bounds.keys()):
        value, bound = found.get(name), bounds.get(name, {})
        least, most = (bound.get(key, {}).get(STAGES[-1]) for key in ("at_least", "at_most"))
        numbers = [x for x in (value, least, most) if isinstance(x, int | float) and math.isfinite(x)]
        low, high = least or 0, math.inf if most is None else most
        bad = value is None or len(numbers) != 2 or bool in map(type, numbers) or not low <= value <= high
        if bad or stored.get(name) != value:
            yield f"{name}: {value} by what was counted, {stored.get(name)} in signoff.json: {low} to {high}"


def _witnesses(folder: Path) -> Iterator[str]:
    if len(json.loads((folder / "witnesses/set.json").read_text())["families"]) < 10:
        yield "of fewer than ten families"
    command = [sys.executable, "-I", "-S", folder / "source/bench/tritest/recheck.py", folder / "witnesses"]
    ran = subprocess.run(command, capture_output=True, text=True, check=False)
    print(ran.stdout, end="")
    yield from [f"exit code {ran.returncode}: {ran.stderr.strip()}"] * bool(ran.returncode)


def _statements(folder: Path) -> Iterator[str]:
    attestation = json.loads((folder / "attestation.json").read_text())
    about = {"rtl": _rtl_hash(folder / "source/dut"), "SHA256SUMS": _sha256(folder / "SHA256SUMS")}
    subject = [{"name": name, "digest": {"sha256": x}} for name, x in about.items()]
    if (attestation["subject"], attestation["predicate"]["result"]) != (subject, "PASSED"):
        yield "attestation.json: is not about these files, or does not say that they passed"
    bill = json.loads((folder / "sbom.cdx.json").read_text())["components"]
    named = {(one["name"], one["version"]) for one in bill}
    locked = "".join(lock.read_text() for lock in (folder / "source").glob("requirements*.lock"))
    if not named or named != set(re.findall(r"^([A-Za-z0-9._-]+)==([^\s;]+)", locked, re.MULTILINE)):
        yield "sbom.cdx.json: other packages than those of the lock files"


def main() -> int:
    """Verify the archive; print what does not hold."""
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    if not (folder / "SHA256SUMS").is_file():
        print(f"verify: error: {folder}: no archive of evidence here", file=sys.stderr)
        return 2
    wrong = 0
    for check in (_files, _verdict, _statements, _witnesses):
        if wrong and check is _witnesses:
            break
        found: list[str] = []
        try:
            found.extend(check(folder))
        except (OSError, ValueError, LookupError, TypeError, AttributeError, RecursionError) as error:
            found.append(f"{type(error).__name__}: {error}")
        print(f"{check.__name__[1:]}: {'FAILED' if found else 'passed'}", *found, sep="\n  ")
        wrong += len(found)
    print(f"{'FAILED' if wrong else 'PASSED'}: SHA256SUMS {_sha256(folder / 'SHA256SUMS')}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
