"""The testplan against what exists, which it must own, and against the evidence, which must meet it."""

import time
from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from triaxis.coverage.cover_model import CoverItem, Kind
from triaxis.coverage.report import ModelReport
from triaxis.coverage.testplan import TESTPLAN, Requirement, Testplan, Testpoint, read_testplan
from triaxis.coverage.testplan_lint import Inventory, lint
from triaxis.coverage.testplan_progress import PlanResults, every_run_passed, progress
from triaxis.sim.build import rtl_hash
from triaxis.sim.models import BOARD_SVA, CORE_SVA, MESH_SVA
from triaxis.sim.paths import ROOT
from triaxis.verif.core.detector_check import SEED_VECTORS
from triaxis.verif.faults.catching import signed_off_names
from triaxis.verif.formal.proof import Result
from triaxis.verif.formal.proving import proof_names
from triaxis.verif.mutation.catalogue import mutant_names
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.signoff.chain import THEOREM
from triaxis.verif.signoff.parts import Evidence, Part
from triaxis.verif.signoff.plan import plan
from triaxis.verif.testbench.assertions import assertion_names
from triaxis.verif.testbench.table import planned_tests, table

# Runs that check and are no UVM tests: the wrapper, whole meshes, the small grid in full, code coverage.
DETECTOR, SOLVERS, SCENES = "detector", "solvers", "scenes"
EXHAUSTIVE, CODE_COVERAGE = "exhaustive", "code_coverage"
CHECKS = (DETECTOR, SOLVERS, SCENES, EXHAUSTIVE, CODE_COVERAGE)


@cache
def inventory() -> Inventory:
    """Return everything that a testpoint must own."""
    goals: dict[str, frozenset[str]] = {}
    illegal: dict[str, frozenset[str]] = {}
    for model in dict.fromkeys(model_of(run.config) for run in plan(seed=1)):
        goals[model.name] = frozenset(name for item in model.items for name in _goals(item))
        illegal[model.name] = frozenset(name for item in model.items for name in _illegal(item))
    return Inventory(
        tests=frozenset(planned_tests()),
        proofs=frozenset(proof_names()),
        faults=frozenset(signed_off_names()),
        checks=frozenset(CHECKS),
        assertions=frozenset(
            name
            for folder in (CORE_SVA, MESH_SVA, BOARD_SVA)
            for path in sorted(folder.glob("*.sv"))
            for name in assertion_names(path)
        ),
        mutants=frozenset(mutant_names()),
        bins=goals,
        illegal=illegal,
    )


def _goals(item: CoverItem[Any]) -> Iterator[str]:
    return (f"{item.name}.{b.name}" for b in item.bins if b.exclusion is None)


def _illegal(item: CoverItem[Any]) -> Iterator[str]:
    return (f"{item.name}.{b.name}" for b in item.bins if b.exclusion and b.exclusion.kind is Kind.ILLEGAL)


def check_plan(path: Path = TESTPLAN) -> tuple[Testplan, list[str]]:
    """Return a testplan and what is wrong with it, a line each."""
    read = read_testplan(path)
    return read, [*lint(read, inventory()), *_other_stages(read)]


def _other_stages(plan: Testplan) -> Iterator[str]:
    """Give the tests whose class names another stage than the first in which a testpoint asks for them."""
    stages: dict[str, str] = {}
    for point in sorted(plan.testpoints, key=lambda point: point.stage):
        for test in point.tests:
            stages.setdefault(test, point.stage)
    for name, stage in stages.items():
        if name in table() and table()[name].stage != stage:
            named = table()[name].stage
            yield f"{plan.path}: test {name}: first asked for in {stage}, its class says {named}"


def testplan_part(parts: Mapping[str, Part], coverage: Sequence[ModelReport] | None) -> Evidence:
    """Return the state of each testpoint; problems: what the linter of the plan says."""
    start = time.monotonic()
    plan, found = check_plan()
    # As the report names files: from the root of the checkout.
    problems = [problem.removeprefix(f"{ROOT}/") for problem in found]
    points = [status.content() for status in progress(plan, inventory(), plan_results(parts, coverage))]
    met = sum(point["passed"] is True for point in points)
    passed = {point["name"]: point["passed"] for point in points}
    return {
        "passed": met == len(points) and not problems,
        "problems": problems,
        "summary": f"{met} of {len(points)} testpoints are met",
        "command": "triaxis coverage plan",
        "seconds": round(time.monotonic() - start, 1),
        "rtl_hash": rtl_hash(),
        "testpoints": points,
        "requirements": [_met(one, plan.serving(one), passed) for one in plan.requirements],
    }


def _met(requirement: Requirement, serving: Sequence[Testpoint], passed: Mapping[str, Any]) -> Evidence:
    """Return a requirement with the testpoints that serve it, and whether all of these have passed."""
    names = [point.name for point in serving]
    met = all(passed[name] is True for name in names)
    return {"id": requirement.id, "text": requirement.text, "testpoints": names, "passed": met}


def plan_results(parts: Mapping[str, Part], coverage: Sequence[ModelReport] | None) -> PlanResults:
    """Return what ran and how it went, as the testplan asks for it; None: a part is absent."""
    found = {name: part.evidence for name, part in parts.items()}
    simulation, mutation = found["simulation"], found["mutation"]
    proofs, faults = found["proofs"], found["faults"]
    return PlanResults(
        tests=simulation and every_run_passed((run["test"], run["passed"]) for run in simulation["runs"]),
        proofs=proofs
        and {
            proof["name"]: proof["passed"] or (proof["name"] == THEOREM and proof["result"] == Result.ABSENT)
            for proof in proofs["proofs"]
        },
        faults=faults and {fault["name"]: fault["caught"] for fault in faults["faults"]},
        checks=_checks(found),
        mutants=mutation
        and dict.fromkeys(mutation["killed"], True) | dict.fromkeys(_survivors(mutation), False),
        equivalent=frozenset(entry["id"] for entry in mutation["equivalents"]) if mutation else frozenset(),
        coverage=coverage,
    )


def _survivors(mutation: Evidence) -> list[str]:
    return [mutant["id"] for mutant in mutation["survivors"]]


def _checks(found: Mapping[str, Evidence | None]) -> dict[str, bool]:
    """Return the checks that ran."""
    checks: dict[str, bool] = {}
    if simulation := found["simulation"]:
        detector = simulation["detector"]
        right = detector["seed_vectors_clear"] == SEED_VECTORS and not detector["wrong"]
        checks[DETECTOR] = right and detector["pairs"] > 0
        solvers = simulation["solvers"]
        checks[SOLVERS] = solvers["pairs"] > 0 and not solvers["different"]
        scenes = simulation["scenes"] + (simulation["real_meshes"] or [])
        agree = all(scene["agrees"] and scene["found"] == scene["expected"] for scene in scenes)
        checks[SCENES] = bool(scenes) and agree
    for name in (EXHAUSTIVE, CODE_COVERAGE):
        if evidence := found[name]:
            checks[name] = evidence["passed"]
    return checks
