"""A waiver whose bin is hit, whose point is no more, or whose RTL changed is a problem, each in a line."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.code_counters import FALL, RISE, Counters
from triaxis.coverage.code_coverage import Assessment, ModelCoverage, assess_model, conclude
from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.core_proofs import CATEGORIES as PROOFS
from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import CoverItem, Kind
from triaxis.coverage.elaboration import Instance, Signal
from triaxis.coverage.report import ModelReport, report
from triaxis.coverage.waiver_upkeep import (
    exclusion_records,
    other_rtl,
    waiver_problems,
    waiver_records,
)
from triaxis.coverage.waivers import CATEGORIES, WAIVERS, Waiver, confirm_waivers, module_hash, read_waivers

ROOT = Path(__file__).resolve().parents[2]
TOP, U_A, U_B = "TOP.top", "TOP.top.u_a", "TOP.top.u_b"
BITS = Waiver(
    1, "bounded", "because", "dut", module_hash(()), "toggle", ("leaf",), signals=("sum",), bits=("4..7",)
)
CORES = ((8, 0), (8, 8), (16, 0, False, True), (13, 4, True, False), (16, 0, True, False), (32, 32))


def assessed(
    hit_bits: dict[str, set[int]], hit_ways: set[tuple[str, str]], waivers: list[Waiver]
) -> Assessment:
    """Assess two instances of a leaf with a signal of 8 bits and a conditional operator."""
    counters = Counters()
    instances = {TOP: Instance(TOP, "top", {"W": 8}, (), frozenset(), frozenset())}
    for path in (U_A, U_B):
        signal = Signal(path, "sum", range(8))
        instances[path] = Instance(path, "leaf", {}, (signal,), frozenset(), frozenset())
        for bit in range(8):
            for edge in (RISE, FALL):
                counters.count_toggle(path, f"sum[{bit}]", "leaf.sv", 3, edge, int(bit in hit_bits[path]))
        for column, what in enumerate(("cond_then", "cond_else")):
            counters.count_point(("leaf.sv", 9, column, "branch", what, path), int((path, what) in hit_ways))
    return conclude(assess_model(ModelCoverage("w8_m0", counters, instances), waivers), [], waivers)


def records() -> list[dict[str, Any]]:
    """What a measurement with the waivers of the core records."""
    waivers = read_waivers()
    return waiver_records(waivers, {waiver.number: 1 for waiver in waivers})


def test_those_of_the_core_hold_until_their_modules_change(tmp_path: Path) -> None:
    assert waiver_problems(records()) == waiver_problems(None) == []
    path, source = tmp_path / "waivers.toml", tmp_path / "triaxis_core.sv"
    text = WAIVERS.read_text()
    path.write_text(text)
    source.write_text("module triaxis_core; endmodule\n")
    own = [waiver for waiver in read_waivers() if waiver.modules == ("triaxis_core",)]
    assert own and all(other_rtl(waiver, tmp_path) for waiver in own)
    # Read again, which is written down; a comment voids nothing, code does.
    assert confirm_waivers(path, tmp_path) == len(read_waivers())
    [first, *_] = [waiver for waiver in read_waivers(path) if waiver.modules == ("triaxis_core",)]
    source.write_text("// A comment.\nmodule triaxis_core;\nendmodule\n")
    assert other_rtl(first, tmp_path) is None
    source.write_text("module triaxis_core; wire a; endmodule\n")
    assert "--confirm-waivers" in (other_rtl(first, tmp_path) or "")


def test_what_is_recorded_of_a_waiver() -> None:
    [record] = waiver_records([BITS], {1: 16})
    assert record == {
        "number": 1,
        "category": "bounded",
        "kind": "toggle",
        "modules": ["leaf"],
        "instances": ["*"],
        "models": ["*"],
        "where": "1",
        "let": {},
        "what": [],
        "signals": ["sum"],
        "range": None,
        "bits": ["4..7"],
        "step": "1",
        "rests_on": [],
        "reason": "because",
        "owner": "dut",
        "reviewed": module_hash(()),
        "bins": 16,
    }
    assert json.loads(json.dumps(records())) == records()
    assert waiver_records([BITS], {})[0]["bins"] == 0
    assert all(record["category"] in CATEGORIES and record["owner"] for record in records())


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda r: r.pop(), "waivers, measured with"),
        (lambda r: r[0].update(owner="nobody"), "waiver 1 (toggle, triaxis_core): owner changed since"),
        (
            lambda r: r[0].update(reviewed="0", reason="x"),
            "reason, reviewed changed since it was measured",
        ),
        (lambda r: r[0].update(signals=["*"]), "waiver 1 (toggle, triaxis_core): signals changed since"),
        (lambda r: r[0].update(range=["0", "L"]), "waiver 1 (toggle, triaxis_core): range changed since"),
        (lambda r: r[0].update(where="W == 9", let={"x": "1"}), "where, let changed since"),
        (lambda r: r[0].pop("step"), "waiver 1 (toggle, triaxis_core): recorded without step"),
        (lambda r: r[0].clear(), "waiver 1 (toggle, triaxis_core): recorded without number, category"),
        (lambda r: r.__setitem__(0, 7), "waiver 1 (toggle, triaxis_core): recorded without number"),
        (lambda r: r[1].update(bins=0), "waiver 2 (toggle, triaxis_mesh): covers no bin"),
    ],
)
def test_waivers_that_are_not_those_measured_are_a_problem(
    spoil: Callable[[list[dict[str, Any]]], None], said: str
) -> None:
    changed = records()
    spoil(changed)
    [problem] = waiver_problems(changed)
    assert said in problem


def full(parameters: tuple[Any, ...], spoilt: str = "") -> ModelReport:
    """Report a build all of whose goals are met; one excluded bin of an item is hit as well."""
    model = core_model(*parameters)
    hits = {item.name: item.goals.copy() for item in model.items}
    if spoilt:
        [item] = [item for item in model.items if item.name == spoilt]
        hits[spoilt][np.flatnonzero(item.illegal)[0]] = 3
    return report(model, Counts(model.name, model.hash, hits))


@pytest.mark.parametrize("item", ["answer", "flags", "sole_axis", "relation", "contact", "decision"])
def test_an_excluded_bin_of_the_core_that_is_hit_is_a_problem(item: str) -> None:
    assert full((16, 0)).problems == [] and full((16, 0)).complete
    found = full((16, 0), item)
    [problem] = found.problems
    assert problem.startswith(f"coverage core_w16_m0, {item}: illegal bin ") and "hit 3 times: " in problem
    assert not found.complete
    assert [r["item"] for r in exclusion_records([found]) if r["hits"]] == [item]


def excluding(parameters: tuple[Any, ...]) -> list[CoverItem[Any]]:
    return [item for item in core_model(*parameters).items if item.exclusions]


@pytest.mark.parametrize("parameters", CORES)
def test_every_exclusion_is_illegal_proved_owned_and_of_some_bin(parameters: tuple[Any, ...]) -> None:
    for item in excluding(parameters):
        used = {id(one.exclusion) for one in item.bins}
        for exclusion in item.exclusions:
            assert exclusion.kind is Kind.ILLEGAL
            assert exclusion.category in PROOFS and exclusion.owner and len(exclusion.reason) > 30
            assert id(exclusion) in used, f"{item.name}: excludes no bin: {exclusion.reason}"
            file, _, test = exclusion.test.partition("::")
            assert f"def {test}(" in (ROOT / file).read_text()


def test_exclusions_are_recorded_with_all_that_a_signature_needs() -> None:
    found = exclusion_records([full((16, 0)), full((8, 8))])
    assert {record["model"] for record in found} == {"core_w16_m0", "core_w8_m8"}
    assert {record["kind"] for record in found} == {"illegal"}
    assert {record["category"] for record in found} <= set(PROOFS)
    assert all(record["bins"] > 0 and record["hits"] == 0 for record in found)
    assert all(record["owner"] == "verif" for record in found)
