"""Evidence of a sign-off in which all is well, for tests that break it."""

from dataclasses import asdict
from functools import cache

from triaxis.coverage.stages import STAGES
from triaxis.coverage.waiver_upkeep import waiver_records
from triaxis.coverage.waivers import KINDS, read_waivers
from triaxis.sim.evidence import Span
from triaxis.sim.validity import provenance
from triaxis.verif.signoff.gate import SOURCES
from triaxis.verif.signoff.parts import Part
from triaxis.verif.signoff.result import Signoff

HERE = provenance(SOURCES)
WAIVERS = waiver_records(read_waivers(), {waiver.number: 1 for waiver in read_waivers()})


def evidence(**content):
    common = {"passed": True, "problems": [], "summary": "all well", "command": "triaxis x", "seconds": 1.0}
    return {**common, "rtl_hash": HERE.rtl_hash, **content}


def _simulation():
    counts = {"checked": 100_000_000, "judged_by_golden_model": 7, "clear_claims_rechecked": 9, "failed": 0}
    run = {
        "test": "VolumeTest", "config": "w16_m0", "agent": "burst", "seed": 1, "passed": True, "seconds": 2.0,
        "counts": counts, "explanation": None, "replay": "triaxis sim VolumeTest", "log": "build/x.log",
    }  # fmt: skip
    scene = {
        "name": "tool", "expected": "near", "found": "near", "agrees": True, "pairs": 3, "skipped": 1,
        "tested": 2, "near": 1,
    }  # fmt: skip
    return evidence(
        pairs_checked=100_000_000, mismatches=0, runs=[run], scenes=[scene], real_meshes=None,
        detector={"seed_vectors_clear": 15, "pairs": 3000, "wrong": 0},
        solvers={"pairs": 4000, "different": 0},
        coverage={"core_w16_m0": {"claim": {"hit": 33, "total": 33, "meaning": "the claim"}}},
    )  # fmt: skip


def _code_coverage():
    totals = {k: {"hit": 9, "waived": 1, "total": 10} for k in KINDS}
    run = {"model": "w16_m16", "test": "MixedTest", "checked": 9, "wrong": 0, "seconds": 1.0}
    return evidence(
        totals=totals,
        files={"triaxis_core.sv": totals},
        waivers=WAIVERS,
        waivers_void=0,
        uncovered=[],
        runs=[run],
    )


def _faults():
    fault = {
        "name": "F1", "title": "sign", "test": "RandomTest", "config": "w16_m0", "pairs": 3, "caught": True,
        "message": "core says clear", "seconds": 1.0, "clocks": None,
        "counterexample": {"after": "margin 0, [[[0, 0, 0]]]", "meaning": "clear where near"},
    }  # fmt: skip
    return evidence(
        control={"passed": True, "problems": []},
        faults=[fault, {**fault, "name": "F9", "counterexample": None, "pairs": None, "clocks": 7}],
    )


def _mutation():
    counts = {"mutants": 12, "killed": 10, "equivalent": 2, "surviving": 0}
    entry = {"place": "a.sv:1", "reason": "same sum", "evidence": "proved"}
    equivalents = [{"id": f"triaxis_sum/x/{number}", **entry} for number in (1, 2)]
    return evidence(
        files={"a.sv": counts}, operators={"add": counts}, survivors=[], equivalents=equivalents,
        killed=[f"triaxis_sum/y/{number}" for number in range(10)], seconds=None,
        recorded=0, sampled=0, sample=None, entries=1, entries_recorded=0,
        stages=[asdict(Span("w8_m8: 24 built", 90.0, 700.0, 1234.0))],
    )  # fmt: skip


def _proofs():
    proof = {
        "name": "order", "claim": "results come in order", "method": "k-induction", "parameters": {"W": 16},
        "assumptions": ["The driver holds its pair."], "passed": True, "result": "proved", "seconds": 1.0,
        "registers": {"triaxis_fifo": ["memory_q"]},
    }  # fmt: skip
    why = {"module": "triaxis_display", "name": "digit_q", "reason": "it is for people to read"}
    modules = {"triaxis_fifo": {"total": 99, "covered": 99}, "triaxis_display": {"total": 1, "covered": 0}}
    registers = {
        "total": 100, "covered": 99, "unexplained": 0, "summary": "99 of 100 registers are in a cone",
        "modules": modules,
        "outside": [why],
    }  # fmt: skip
    return evidence(proofs=[proof], undecided=0, exceptions=[], registers=registers)


def _testplan():
    point = {
        "name": "general", "goal": "general pairs", "passed": True, "tests": [1, 1], "bins": [3, 3],
        "mutants": [10, 10], "assertions": None, "others": [1, 1],
    }  # fmt: skip
    promised = {"id": "CORE-1", "text": "It is right.", "testpoints": ["general"], "passed": True}
    return evidence(testpoints=[{**point, "stage": stage} for stage in STAGES], requirements=[promised])


def _lint():
    return evidence(findings=0, linters={"verilator -Wall triaxis_core w16_m0": [], "verible lint": []})


def good_parts():
    return {
        "lint": Part(_lint()),
        "simulation": Part(_simulation()),
        "exhaustive": Part(evidence(counts={"mismatches": 0, "ordered": [729, 729]}, ordered_pairs=729)),
        "code_coverage": Part(_code_coverage()),
        "faults": Part(_faults()),
        "mutation": Part(_mutation()),
        "proofs": Part(_proofs()),
        "testplan": Part(_testplan()),
    }


def good_beside():
    return {name: Part(evidence(summary="0 differences")) for name in ("four_state", "netlist")}


def signed(parts=None, beside=None, whole=False):
    spans = Span("simulation", 0.0, 600.0, 1111.0), Span("mutation", 600.0, 3600.0, 5555.0)
    return Signoff(parts or good_parts(), beside or good_beside(), HERE, 1, 100_000_000, 1.0, spans, whole)


@cache
def good_content():
    """Return the file's content of a sign-off in which all is well."""
    return signed().content()
