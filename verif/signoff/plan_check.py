"""What exists and must be owned by the testplan, gathered where it is defined; and the check of the plan."""

from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from triaxis.coverage.cover_model import CoverItem, Kind
from triaxis.coverage.testplan import TESTPLAN, Testplan, read_testplan
from triaxis.coverage.testplan_inventory import Inventory
from triaxis.coverage.testplan_lint import lint
from triaxis.verif.faults.catching import signed_off_names
from triaxis.verif.formal.proving import proof_names
from triaxis.verif.mutation.catalogue import mutant_names
from triaxis.verif.regress.coverage_models import model_of
from triaxis.verif.signoff.mesh_plan import mesh_plan
from triaxis.verif.signoff.plan import plan
from triaxis.verif.testbench.assertions import CORE_SVA, MESH_SVA, assertion_names
from triaxis.verif.testbench.testnames import MESH_TESTS, REPLAY, TESTS

# Runs that check and are no UVM tests: the wrapper, whole meshes, the small grid in full, code coverage.
DETECTOR, SCENES, EXHAUSTIVE, CODE_COVERAGE = "detector", "scenes", "exhaustive", "code_coverage"
CHECKS = (DETECTOR, SCENES, EXHAUSTIVE, CODE_COVERAGE)


@cache
def inventory() -> Inventory:
    """Return everything that a testpoint must own."""
    goals: dict[str, frozenset[str]] = {}
    illegal: dict[str, frozenset[str]] = {}
    for model in dict.fromkeys(model_of(run.config) for run in (*plan(seed=1), *mesh_plan(seed=1))):
        goals[model.name] = frozenset(name for item in model.items for name in _goals(item))
        illegal[model.name] = frozenset(name for item in model.items for name in _illegal(item))
    return Inventory(
        # A replay repeats pairs that failed elsewhere: it verifies nothing of its own.
        tests=frozenset((*TESTS, *MESH_TESTS)) - {REPLAY},
        proofs=frozenset(proof_names()),
        faults=frozenset(signed_off_names()),
        checks=frozenset(CHECKS),
        assertions=frozenset(
            name
            for folder in (CORE_SVA, MESH_SVA)
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
    return read, lint(read, inventory())
