"""The testplan's part of a sign-off: how far each testpoint is met by the evidence of the other parts."""

import time
from collections.abc import Mapping, Sequence

from triaxis.coverage.report import ModelReport
from triaxis.coverage.testplan_progress import PlanResults, every_run_passed, stage_progress
from triaxis.sim.paths import ROOT
from triaxis.sim.provenance import provenance
from triaxis.verif.core.detector_check import SEED_VECTORS
from triaxis.verif.signoff.parts import Evidence, Part
from triaxis.verif.signoff.plan_check import (
    CODE_COVERAGE,
    DETECTOR,
    EXHAUSTIVE,
    SCENES,
    check_plan,
    inventory,
)


def testplan_part(parts: Mapping[str, Part], coverage: Sequence[ModelReport] | None) -> Evidence:
    """Return the state of each testpoint; problems: what the linter of the plan says."""
    start = time.monotonic()
    plan, found = check_plan()
    # As the report names files: from the root of the checkout.
    problems = [problem.removeprefix(f"{ROOT}/") for problem in found]
    stages = stage_progress(plan, inventory(), plan_results(parts, coverage))
    points = [status.content() for stage in stages for status in stage.testpoints]
    met = sum(point["passed"] is True for point in points)
    return {
        "passed": met == len(points) and not problems,
        "problems": problems,
        "summary": f"{met} of {len(points)} testpoints are met",
        "command": "triaxis coverage plan",
        "seconds": round(time.monotonic() - start, 1),
        "rtl_hash": provenance().rtl_hash,
        "testpoints": points,
    }


def plan_results(parts: Mapping[str, Part], coverage: Sequence[ModelReport] | None) -> PlanResults:
    """Return what ran and how it went, as the testplan asks for it; None: a part is absent."""
    found = {name: part.evidence for name, part in parts.items()}
    simulation, mutation = found["simulation"], found["mutation"]
    proofs, faults = found["proofs"], found["faults"]
    return PlanResults(
        tests=simulation and every_run_passed((run["test"], run["passed"]) for run in simulation["runs"]),
        proofs=proofs and {proof["name"]: proof["passed"] for proof in proofs["proofs"]},
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
        scenes = simulation["scenes"] + (simulation["real_meshes"] or [])
        agree = all(scene["agrees"] and scene["found"] == scene["expected"] for scene in scenes)
        checks[SCENES] = bool(scenes) and agree
    for name in (EXHAUSTIVE, CODE_COVERAGE):
        if evidence := found[name]:
            checks[name] = evidence["passed"]
    return checks
