"""A waiver whose bin is hit, whose point is no more, or whose RTL changed is a problem, each in a line."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from triaxis.coverage.core_coverage import core_model
from triaxis.coverage.core_proofs import CATEGORIES as PROOFS
from triaxis.coverage.counts import Counts
from triaxis.coverage.cover_model import Kind
from triaxis.coverage.report import ModelReport, report
from triaxis.coverage.waiver_upkeep import (
    exclusion_records,
    other_rtl,
    waiver_problems,
    waiver_records,
)
from triaxis.coverage.waivers import CATEGORIES, WAIVERS, Waiver, confirm_waivers, module_hash, read_waivers

ROOT = Path(__file__).resolve().parents[2]
BITS = Waiver(
    1, "bounded", "because", "dut", module_hash(()), "toggle", ("leaf",), signals=("sum",), bits=("4..7",)
)
CORES = ((8, 0), (8, 8), (16, 0, False, True), (13, 4, True, False), (16, 0, True, False), (32, 32))


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
        "number": 1, "category": "bounded", "kind": "toggle", "modules": ["leaf"], "instances": ["*"],
        "models": ["*"], "where": "1", "let": {}, "what": [], "signals": ["sum"], "range": None,
        "bits": ["4..7"], "step": "1", "rests_on": [], "reason": "because", "owner": "dut",
        "reviewed": module_hash(()), "bins": 16,
    }  # fmt: skip
    assert json.loads(json.dumps(records())) == records()
    assert waiver_records([BITS], {})[0]["bins"] == 0
    assert all(record["category"] in CATEGORIES and record["owner"] for record in records())


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (lambda r: r.pop(), "waivers, measured with"),
        (lambda r: r[0].update(owner="nobody"), "waiver 1 (toggle, triaxis_core): owner changed since"),
        (lambda r: r[0].update(range=["0", "L"]), "waiver 1 (toggle, triaxis_core): range changed since"),
        (lambda r: r[0].update(where="W == 9", let={"x": "1"}), "where, let changed since"),
        (lambda r: r[0].pop("step"), "waiver 1 (toggle, triaxis_core): recorded without step"),
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


def test_an_excluded_bin_of_the_core_that_is_hit_is_a_problem() -> None:
    assert full((16, 0)).problems == [] and full((16, 0)).complete
    for item in ("answer", "flags", "sole_axis", "relation", "contact", "decision"):
        found = full((16, 0), item)
        [problem] = found.problems
        assert (
            problem.startswith(f"coverage core_w16_m0, {item}: illegal bin ") and "hit 3 times: " in problem
        )
        assert not found.complete
        assert [r["item"] for r in exclusion_records([found]) if r["hits"]] == [item]


@pytest.mark.parametrize("parameters", CORES)
def test_every_exclusion_is_illegal_proved_owned_and_of_some_bin(parameters: tuple[Any, ...]) -> None:
    for item in core_model(*parameters).items:
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
