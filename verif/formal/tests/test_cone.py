"""A register counts as looked at where an assertion depends on it, and only there."""

import shutil
from dataclasses import replace

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.paths import DUT
from triaxis.verif.formal import proof as proof_module
from triaxis.verif.formal.cone import Covered, Register, all_registers, by_modules, hierarchy, read_unproved
from triaxis.verif.formal.proof import Result
from triaxis.verif.formal.proofs import proofs

A, B = Register("unit", "a_q"), Register("unit", "b_q.field")


def proved(name, folder):
    finding = next(proof for proof in proofs() if proof.name == name).prove(DUT, folder)
    assert finding.result is Result.PROVED, finding
    return finding.registers


@pytest.mark.prover
def test_without_an_assertion_its_registers_are_in_no_cone(tmp_path, monkeypatch):
    whole = proved("engine_near", tmp_path / "whole")
    names = {"first_o", "in_flight_q", "m_axis_near_tdata_o", "m_axis_near_tvalid_o", "near_o", "tested_o"}
    names |= {"again_pair_o", "again_valid_o", "zones_o"}
    assert by_modules(whole) == {"triaxis_near_pairs": sorted(names)}

    rtl = shutil.copytree(proof_module.RTL, tmp_path / "rtl")
    harness = rtl / "triaxis_near_pairs_formal.sv"
    text = harness.read_text()
    counted = "Counted : assert (tested_o == tested_q && near_o == near_q);"
    assert counted in text
    harness.write_text(text.replace(counted, ""))
    monkeypatch.setattr(proof_module, "RTL", rtl)
    lost = whole - proved("engine_near", tmp_path / "less")
    assert Register("triaxis_near_pairs", "tested_o") in lost and len(lost) < len(whole)


@pytest.mark.prover
def test_all_registers_are_those_of_every_module_that_has_some(tmp_path):
    every = all_registers(DUT, tmp_path)
    having = {
        path.stem
        for path in DUT.glob("*/*.sv")
        if any(word in path.read_text() for word in ("always_ff", "`TRIAXIS_STAGE("))
    }
    assert {one.module for one in every} == having
    assert set(read_unproved()) <= every
    # Memories, members of structures, what lies in a block, and what a macro declares.
    assert {
        Register("triaxis_fifo", "memory_q"),
        Register("triaxis_request", "request_q.session"),
        Register("triaxis_delay", "g_regs.g_stage.stage_q"),
        Register("triaxis_verdict", "flags_2"),
    } <= every


def test_a_parameter_may_choose_the_module_of_an_instance(tmp_path):
    path = tmp_path / "unit.sv"
    path.write_text("""
module outer; if (1) begin : g inner u (); end else begin : g other u (); end endmodule
module other; logic same_q, own_q; if (1) begin : g_own logic deep_q; end endmodule
module inner; logic same_q; other u (); endmodule
""")
    known = hierarchy([path])
    assert known.register("outer", "g.u.own_q[3].member") == Register("other", "own_q.member")
    assert known.register("outer", "g.u.g_own.deep_q") == Register("other", "g_own.deep_q")
    assert known.register("outer", "g.u.u.same_q") == Register("other", "same_q")
    assert known.register("outer", "g.u.same_q", "inner.sv") == Register("inner", "same_q")
    with pytest.raises(InputError, match="in several modules"):
        known.register("outer", "g.u.same_q")
    # What no file has is not there.
    less = tmp_path / "less.sv"
    less.write_text(path.read_text().replace("module other", "module another"))
    assert hierarchy([less]).register("outer", "g.u.same_q") == Register("inner", "same_q")


def test_a_reason_that_no_longer_applies_is_a_problem():
    every = frozenset({A, B, Register("unit", "c_q")})
    # A proof has the structure as a plain word.
    covered = Covered(every, frozenset({Register("unit", "b_q")}), {A: "for people"})
    assert covered.unexplained == [Register("unit", "c_q")] and covered.problems == []
    assert covered.content["modules"] == {"unit": {"total": 3, "covered": 1}}
    assert covered.summary.startswith("1 of 3 registers")

    stale = replace(covered, reasons={B: "for people", Register("unit", "gone_q"): "for people"}).problems
    assert [line.split(": ", 2)[2] for line in stale] == [
        "b_q.field: is in the cone of a proof: take it out",
        "gone_q: there is no such register: take it out",
    ]
    (odd,) = replace(covered, proved=frozenset({Register("unit", "only_q")})).problems
    assert "only_q: only proofs have this register" in odd


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[unproved]]\nregisters = { unit = ['a_q'] }", "reason"),
        ("[[unproved]]\nreason = 'x'\nregisters = { unit = ['a_q', 'a_q'] }", "twice"),
        ("a = 1", "unproved"),
        ("a = ", "cannot be read"),
    ],
)
def test_a_wrong_list_is_refused(tmp_path, text, message):
    path = tmp_path / "unproved.toml"
    path.write_text(text)
    with pytest.raises(InputError, match=message):
        read_unproved(path)
