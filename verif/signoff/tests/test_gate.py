"""The gate opens for a sign-off of this very RTL that passed, and for nothing else."""

import json

import pytest

from triaxis.coverage.stages import read_figures
from triaxis.coverage.waiver_upkeep import waiver_records
from triaxis.coverage.waivers import read_waivers
from triaxis.verif.signoff.gate import PARTS, refusals, remarks

RTL, ENVIRONMENT = "a" * 64, "e" * 64
WAIVERS = read_waivers()


def signed(**changes):
    figures = {figure.name: figure.bounds["V3"] for figure in read_figures()}
    waivers = waiver_records(WAIVERS, {waiver.number: 1 for waiver in WAIVERS})
    parts = {name: {"passed": True, "rtl_hash": RTL} for name in PARTS}
    common = {"passed": True, "problems": [], "rtl_hash": RTL, "environment_hash": ENVIRONMENT}
    common |= {"figures": figures, "waivers": waivers, "parts": parts}
    return {**common, **changes}


def refused(tmp_path, content):
    path = tmp_path / "signoff.json"
    path.write_text(content if isinstance(content, str) else json.dumps(content))
    return refusals(path, RTL, ENVIRONMENT)


def test_waivers_that_changed_since_shut_the_gate(tmp_path):
    other = signed()
    other["waivers"][0]["reason"] = "because"
    assert "reason changed" in refused(tmp_path, other)[0]
    assert "measured with 0" in refused(tmp_path, signed(waivers=None))[0]


def test_a_pass_of_this_rtl_opens(tmp_path):
    assert refused(tmp_path, signed()) == []


def test_a_sign_off_that_is_in_no_commit_is_remarked(tmp_path):
    path = tmp_path / "signoff.json"
    path.write_text(json.dumps(signed(git_clean=False)))
    assert "uncommitted changes" in remarks(path)[0]
    path.write_text(json.dumps(signed(git_clean=True)))
    assert remarks(path) == []


def test_no_sign_off_is_refused(tmp_path):
    assert "run `make signoff`" in refusals(tmp_path / "none.json", RTL, ENVIRONMENT)[0]


@pytest.mark.parametrize(
    ("content", "reason"),
    [
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
        (signed(figures={**signed()["figures"], "mutation_score": "100"}), "no figures"),
        (signed(figures={**signed()["figures"], "mutation_score": True}), "no figures"),
        (signed(figures={**signed()["figures"], "mutation_score": 99.99}), "wanted at least 100 %"),
        (signed(figures={**signed()["figures"], "proofs_passed": None}), "not measured"),
        (signed(figures={}), "measured without a bound"),
        (signed(figures={**signed()["figures"], "mutation_score": float("nan")}), "no figures"),
        (signed(parts=None), "no evidence"),
        (signed(parts={}), "mutation: no evidence"),
        (signed(parts={**signed()["parts"], "proofs": {"absent": "no tool"}}), "proofs: did not pass"),
        (signed(parts={**signed()["parts"], "faults": {"passed": True}}), "faults: is of RTL of unknown"),
    ],
)
def test_each_reason_to_refuse(tmp_path, content, reason):
    found = refused(tmp_path, content)
    assert any(reason in line for line in found), found
