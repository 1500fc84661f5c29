"""The gate opens for a sign-off of this very RTL that passed, and for nothing else."""

import json

import pytest

from triaxis.coverage.stages import read_figures
from triaxis.coverage.waiver_upkeep import waiver_records
from triaxis.coverage.waivers import read_waivers
from triaxis.verif.signoff.gate import PARTS, refusals, remarks

RTL, ENVIRONMENT = "a" * 64, "e" * 64
RECORDS = waiver_records(read_waivers(), {waiver.number: 1 for waiver in read_waivers()})


def signed(**changes):
    figures = {figure.name: figure.bounds["V3"] for figure in read_figures()}
    parts = {name: {"passed": True, "rtl_hash": RTL} for name in PARTS}
    common = {"passed": True, "problems": [], "rtl_hash": RTL, "environment_hash": ENVIRONMENT}
    common |= {"figures": figures, "waivers": RECORDS, "parts": parts}
    return {**common, **changes}


def figures(**changes):
    return signed(figures={**signed()["figures"], **changes})


def parts(**changes):
    return signed(parts={**signed()["parts"], **changes})


@pytest.mark.parametrize(
    ("content", "reason"),
    [
        (None, "run `make signoff`"),
        ("", "not readable"),
        (json.dumps(signed())[:-20], "not readable"),
        ("[]", "not a sign-off"),
        (signed(rtl_hash="b" * 64), "signed off for RTL bbbbbbbbbbbb, this is aaaaaaaaaaaa"),
        (signed(rtl_hash=None), "of unknown hash"),
        (signed(environment_hash="d" * 64), "by the environment dddddddddddd, this is eeeeeeeeeeee"),
        (signed(environment_hash=None), "of unknown hash"),
        (signed(passed=False), "did not pass"),
        (signed(passed="yes"), "did not pass"),
        (signed(problems=["mutation: 1 survivor"]), "mutation: 1 survivor"),
        (signed(problems=None), "does not list its problems"),
        (signed(figures=None), "no figures"),
        (signed(figures={}), "measured without a bound"),
        (figures(mutation_score="100"), "no figures"),
        (figures(mutation_score=True), "no figures"),
        (figures(mutation_score=float("nan")), "no figures"),
        (figures(mutation_score=99.99), "wanted at least 100 %"),
        (figures(proofs_passed=None), "not measured"),
        (signed(parts=None), "no evidence"),
        (signed(parts={}), "mutation: no evidence"),
        (parts(proofs={"absent": "no tool"}), "proofs: did not pass"),
        (parts(faults={"passed": True}), "faults: is of RTL of unknown"),
        (signed(waivers=[{**waiver, "reason": "because"} for waiver in RECORDS]), "reason changed"),
        (signed(waivers=None), "measured with 0"),
    ],
)
def test_each_reason_to_refuse(tmp_path, content, reason):
    path = tmp_path / "signoff.json"
    if content is not None:
        path.write_text(content if isinstance(content, str) else json.dumps(content))
    found = refusals(path, RTL, ENVIRONMENT)
    assert any(reason in line for line in found), found


def test_a_pass_of_this_rtl_opens_and_what_is_in_no_commit_is_remarked(tmp_path):
    path = tmp_path / "signoff.json"
    for clean, said in (
        (True, []),
        (False, ["signed off from a checkout with uncommitted changes, or outside git"]),
    ):
        path.write_text(json.dumps(signed(git_clean=clean)))
        assert refusals(path, RTL, ENVIRONMENT) == []
        assert remarks(path) == said
