"""The figures of a sign-off, taken from its evidence: what coverage/stages.toml sets bounds for."""

from collections.abc import Mapping, Sequence

from triaxis.coverage.stages import STAGES, share
from triaxis.verif.signoff.parts import Evidence, Part

Value = float | int | None


def figures(parts: Mapping[str, Part]) -> dict[str, Value]:
    """Return every figure; None where its part is absent."""
    found: dict[str, Value] = {}
    for part, names, take in (
        ("simulation", _SIMULATION, _simulation),
        ("code_coverage", _CODE, _code_coverage),
        ("faults", ("faults_caught",), lambda e: [_share_of(e["faults"], "caught")]),
        ("mutation", ("mutation_score",), _mutation),
        ("proofs", ("proofs_passed",), _proofs),
        ("testplan", _TESTPOINTS, _testpoints),
    ):
        evidence = parts[part].evidence
        values = [None] * len(names) if evidence is None else take(evidence)
        found |= dict(zip(names, values, strict=True))
    found["open_problems"] = sum(len(p.evidence["problems"]) if p.evidence else 1 for p in parts.values())
    return found


_SIMULATION = ("runs_passed", "pairs_checked", "mismatches", "functional_coverage")
_CODE = ("line_coverage", "branch_coverage", "expression_coverage", "toggle_coverage", "waivers_void")
_TESTPOINTS = tuple(f"testpoints_{stage.lower()}" for stage in STAGES)


def _share_of(items: Sequence[Evidence], key: str) -> Value:
    return share(sum(item[key] is True for item in items), len(items))


def _simulation(evidence: Evidence) -> list[Value]:
    items = [item for model in evidence["coverage"].values() for item in model.values()]
    covered = share(sum(item["hit"] for item in items), sum(item["total"] for item in items))
    passed = _share_of(evidence["runs"], "passed")
    return [passed, evidence["pairs_checked"], evidence["mismatches"], covered]


def _code_coverage(evidence: Evidence) -> list[Value]:
    totals = [evidence["totals"].get(name.removesuffix("_coverage")) for name in _CODE[:-1]]
    shares = [None if t is None else share(t["hit"] + t["waived"], t["total"]) for t in totals]
    void = sum("waiver" in problem for problem in evidence["problems"])
    return [*shares, void]


def _mutation(evidence: Evidence) -> list[Value]:
    files = evidence["files"].values()
    dead = sum(file["killed"] + file["equivalent"] for file in files)
    return [share(dead, sum(file["mutants"] for file in files))]


def _proofs(evidence: Evidence) -> list[Value]:
    # What no tool decided is neither a proof nor a failure: then there is no share.
    return [None if evidence["undecided"] else _share_of(evidence["proofs"], "passed")]


def _testpoints(evidence: Evidence) -> list[Value]:
    return [
        _share_of([point for point in evidence["testpoints"] if point["stage"] == stage], "passed")
        for stage in STAGES
    ]
