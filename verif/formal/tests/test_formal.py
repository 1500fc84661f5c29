"""Proofs fail where the RTL is wrong: each is run on copies of it that are broken in one place.

That they hold on the RTL itself is what `make formal` says.
"""

import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import pytest

from triaxis.golden.errors import InputError
from triaxis.sim.configuration import Configuration, parse_configuration
from triaxis.sim.evidence import read_evidence
from triaxis.sim.paths import DUT
from triaxis.sim.programs import EndedError
from triaxis.verif.formal import proving
from triaxis.verif.formal.axis_proofs import AxesProof
from triaxis.verif.formal.proof import Finding, Outcome, Proof, Result, SbyProof, require_tools
from triaxis.verif.formal.proofs import proofs


@dataclass(frozen=True)
class Broken:
    """A change of one RTL file, the proof that must fail for it, and what it must say."""

    name: str
    proof: str
    file: str
    old: str
    new: str
    message: str


STREAMS = (
    Broken(
        "accepts more than the queue holds", "streams_m0", "core/triaxis_core.sv",
        "(in_flight_q != count_t'(Depth))", "1'b1", "Occupancy",
    ),
    Broken(
        "a clock too early", "streams_m0", "core/triaxis_core.sv",
        ".push_i (valid_q[Latency-1])", ".push_i (valid_q[Latency-2])", "check",
    ),
    Broken(
        "loses results now and then", "streams_m16", "core/triaxis_core.sv",
        ".push_i (valid_q[Latency-1])", ".push_i (valid_q[Latency-1] && result.tag[6:0] != 7'd77)",
        "check",
    ),
    Broken(
        "duplicates a result", "streams_m0", "core/triaxis_fifo.sv",
        "if (pop_i) read_q", "if (pop_i && !(push_i && read_q[3:0] == 4'd9)) read_q", "check",
    ),
    Broken(
        "withdraws a waiting result", "streams_m0", "core/triaxis_fifo.sv",
        "if (pop_i) read_q", "if (pop_i || (valid_o && read_q[3:0] == 4'd9)) read_q", "check",
    ),
    Broken(
        "a result out of a reset", "streams_m0", "core/triaxis_fifo.sv",
        "write_q <= '0;", "write_q <= ptr_t'(1);", "check",
    ),
    Broken(
        "ready two clocks after reset", "streams_m0", "core/triaxis_core.sv",
        "awake_q <= 1'b1;", "awake_q <= valid_q[0] || in_flight_q == count_t'(0);\n"
        "      if (!awake_q) awake_q <= tag[0];", "check",
    ),
)  # fmt: skip

LEAVES = (
    Broken(
        "touching taken for clear", "interval_m0", "core/triaxis_interval.sv",
        "points[i] > ceiling;", "points[i] >= ceiling;", "Interval",
    ),
    Broken(
        "threshold a clock late", "interval_m16", "core/triaxis_interval.sv",
        "`TRIAXIS_STAGE(points, points_q)", "assign points = points_q;", "Interval",
    ),
    Broken(
        "one side alone", "box_m0", "core/triaxis_box.sv",
        "(a_to_b_q > margin) || (b_to_a_q > margin)", "(a_to_b_q > margin)", "Box",
    ),
    Broken(
        "margin one clock late", "box_m16", "core/triaxis_box.sv",
        ".Cycles(Comb ? 0 : BoxLatency - 1)", ".Cycles(Comb ? 0 : BoxLatency)", "Box",
    ),
    Broken(
        "a middle point taken for the lowest", "box_m0", "core/triaxis_extent.sv",
        "if (below_q[0] && !below_q[2]) low_d", "if (below_q[0]) low_d", "Lowest",
    ),
    Broken(
        "claims the last axis", "verdict_m0", "core/triaxis_verdict.sv",
        "for (int i = NumAxes - 1; i >= 0; i--)", "for (int i = 0; i < NumAxes; i++)", "ClaimIsLowest",
    ),
    Broken(
        "flags of a masked pair", "verdict_m0", "core/triaxis_verdict.sv",
        "coplanar_i && !gated_i", "coplanar_i", "FlagCoplanar",
    ),
    Broken(
        "coplanar without the last triple product", "verdict_m0", "core/triaxis_flags.sv",
        "assign det_zero_d[9] = rst_i == 0;", "assign det_zero_d[9] = 1'b1;", "FlagCoplanar",
    ),
    Broken(
        "the most negative component overflows", "threshold_space", "core/triaxis_threshold.sv",
        "-norm_t'(axis_i[k])", "norm_t'(CWidth'(-axis_i[k]))", "Norm",
    ),
    Broken(
        "margin before its components", "threshold_plane", "core/triaxis_threshold.sv",
        ".Cycles(Comb ? 0 : NormLatency)", ".Cycles(Comb ? 0 : NormLatency - 1)", "Margin",
    ),
    Broken(
        "threshold a bit too low", "threshold_small", "core/triaxis_threshold.sv",
        "product[CWidth+M-1:0]", "product[CWidth+M:1]", "Product",
    ),
    Broken(
        "low piece with a sign", "multiply_small", "core/triaxis_mul.sv",
        "assign x_piece[i] = {1'b0, x[i*XStep+:XStep]};",
        "assign x_piece[i] = {x[i*XStep+XStep-1], x[i*XStep+:XStep]};", "Product",
    ),
    Broken(
        "low pieces of the second operand with a sign", "multiply_wide", "core/triaxis_mul.sv",
        "assign y_piece[j] = {1'b0, y[j*YStep+:YStep]};",
        "assign y_piece[j] = {y[j*YStep+YStep-1], y[j*YStep+:YStep]};", "not the operand",
    ),
    Broken(
        "a piece at the wrong place", "multiply_wide", "core/triaxis_mul.sv",
        "<<< (i * XStep + j * YStep)", "<<< (i * XStep + j * XStep)", "do not add up",
    ),
    Broken(
        "a piece's product one bit too narrow", "multiply_wide", "core/triaxis_mul.sv",
        "logic signed [XBits+YBits-1:0] piece_d, piece_q;",
        "logic signed [XBits+YBits-3:0] piece_d, piece_q;",
        "does not fit",
    ),
    Broken(
        "cross product one bit too narrow", "cross_w2", "core/triaxis_cross.sv",
        "assign cross_d[k] = CrossWidth'(plus - minus);",
        "assign cross_d[k] = CrossWidth'($signed(plus[CrossWidth-2:0] - minus[CrossWidth-2:0]));",
        "CrossProduct",
    ),
    Broken(
        "determinants one bit too narrow", "widths", "core/triaxis_pkg.sv",
        "return 3 * w + 2;", "return 3 * w + 1;", "too few at W = 8",
    ),
    Broken(
        "operands one bit wider than needed", "widths", "core/triaxis_pkg.sv",
        "return w + 1;", "return w + 2;", "more than needed",
    ),
)  # fmt: skip

ENGINE = (
    Broken(
        "the margin counts once on both sides", "engine_skip", "mesh/triaxis_run_control.sv",
        "shift_o[0][k] <= grown_t'(move_o[k]) - grown_t'({1'b0, margin_o});",
        "shift_o[0][k] <= grown_t'(move_o[k]);", "SumsAreExact",
    ),
    Broken(
        "touching boxes are skipped", "engine_skip", "mesh/triaxis_overlap.sv",
        "> grown_i[1][k]", ">= grown_i[1][k]", "ComparisonIsExact",
    ),
    Broken(
        "boxes of A stay where they were loaded", "engine_skip_small", "mesh/triaxis_grow.sv",
        "grown_t'(box_i[c][k]) + shift_i[c][k]", "grown_t'(box_i[c][k])", "SumsAreExact",
    ),
    Broken(
        "one LSB beyond the range is let in", "engine_skip", "mesh/triaxis_run_control.sv",
        "grown_t'(move_o[k]) > Highest", "grown_t'(move_o[k]) > Highest + grown_t'(1)", "OverflowIsExact",
    ),
    Broken(
        "a group's box forgets what was before", "engine_boxes", "mesh/triaxis_mesh_store.sv",
        "if (!first_in_group && group_q[0][k] < box[0][k]) group_d[0][k] = group_q[0][k];", "", "HoldsGroup",
    ),
    Broken(
        "a group's box goes on from the one before", "engine_boxes", "mesh/triaxis_mesh_store.sv",
        "(index & index_t'(Group - 1)) == '0", "(index & index_t'(Depth - 1)) == '0", "Smallest",
    ),
    Broken(
        "a queue that is never full", "engine_queue", "mesh/triaxis_stream_fifo.sv",
        "held_d != count_t'(Depth)", "1'b1", "ReadyIfRoom",
    ),
    Broken(
        "the highest lane first", "engine_pick", "mesh/triaxis_pick.sv",
        "lane_o = lane_t'(Lanes - 1);\n    for (int l = int'(Lanes) - 2; l >= 0; l--) begin",
        "lane_o = lane_t'(0);\n    for (int l = 1; l < int'(Lanes); l++) begin", "LowestFirst",
    ),
    Broken(
        "what was aborted is complete", "engine_control", "mesh/triaxis_run_control.sv",
        "first_i ? StatusFirst : StatusAborted", "first_i ? StatusFirst : StatusComplete",
        "NeverCompleteIfCut",
    ),
    Broken(
        "cycles start again from 0", "engine_control", "mesh/triaxis_run_control.sv",
        " && cycles_o != '1)", ")", "Cycles",
    ),
    Broken(
        "a near pair takes the place of one that waits", "engine_near", "mesh/triaxis_near_pairs.sv",
        "!verdict_near_i || !m_axis_near_tvalid_o || m_axis_near_tready_i", "1'b1", "check",
    ),
)  # fmt: skip

# The proof of this group is the algebra of the core in the configuration named.
AXES = (
    Broken(
        "wrong edge in one axis", "w16_m0", "core/triaxis_projections.sv",
        "assign far_d[2][j] = qf_3[j] - q_normal_3;", "assign far_d[2][j] = qf_3[j] - p_normal_3;",
        "not the projections on its axis",
    ),
    Broken(
        "projection one register short", "w16_m0", "core/triaxis_projections.sv",
        "`TRIAXIS_STAGE(p_normal_3, p_normal_2)", "assign p_normal_3 = p_normal_2;", "several clocks",
    ),
    Broken(
        "a component of an edge with the wrong sign", "w16_m0", "core/triaxis_planar.sv",
        "cross_t'(axis_comp_t'(f_1[j]) + edge2_1[j])", "cross_t'(axis_comp_t'(f_1[j]) - edge2_1[j])",
        "too few",
    ),
    Broken(
        "differences one bit too narrow", "w16_m0", "core/triaxis_pkg.sv",
        "return w + 1;", "return w;", "too few",
    ),
    Broken(
        "axis from the wrong vertex", "w16_m0", "core/triaxis_differences.sv",
        "diff_t'(a_i[2][k]) - diff_t'(a_i[0][k])", "diff_t'(a_i[2][k]) - diff_t'(a_i[1][k])", "",
    ),
    Broken(
        "the thresholds of two axes swapped", "w8_m8", "core/triaxis_thresholds.sv",
        "assign axes[AxisNormalA][k] = axis_comp_t'(normal_a_i[k]);",
        "assign axes[AxisNormalA][k] = axis_comp_t'(normal_b_i[k]);", "not the components of the axis",
    ),
    Broken(
        "interval tests that ignore their thresholds", "w8_m8", "core/triaxis_plane_axes.sv",
        "          .M(M),\n          .Comb(Comb)\n      ) u_b (",
        "          .M(0),\n          .Comb(Comb)\n      ) u_b (",
        "its M is not the core's",
    ),
    Broken(
        "operands move for decided pairs", "w16_m0", "core/triaxis_boxes.sv",
        "valid && (!Gating || separated == '0)", "valid", "gate",
    ),
    Broken(
        "a decision of the boxes one clock early", "w16_m0", "core/triaxis_datapath.sv",
        ".Cycles(TimeDecision * Stage)", ".Cycles((TimeDecision - 1) * Stage)", "several clocks",
    ),
    Broken(
        "the tag of the pair before", "w16_m0", "core/triaxis_core.sv",
        "      .T(tag_t),\n      .Cycles(Latency)\n", "      .T(tag_t),\n      .Cycles(Latency + 1)\n",
        "the tag of another pair",
    ),
    Broken(
        "two coordinates swapped at the input", "w16_m0", "core/triaxis_core.sv",
        "assign b[v][k] = s_axis_tdata_i[(9+3*v+k)*W+:W];",
        "assign b[v][k] = s_axis_tdata_i[(9+3*v+(k+1)%3)*W+:W];", "not the coordinates of its axis",
    ),
    Broken(
        "an axis at the wrong bit", "w16_m0", "core/triaxis_space_axes.sv",
        ".separated_o(separated_o[AxisEdgeEdge+3*i+j])", ".separated_o(separated_o[AxisEdgeEdge+3*j+i])",
        "axis",
    ),
    Broken(
        "a swapped port of the wrapper", "detector", "core/CollisionDetector.sv",
        "'{B1_x, B1_y, B1_z}", "'{B1_x, B1_z, B1_y}", "",
    ),
)  # fmt: skip


def _break(broken: Broken, folder: Path) -> Path:
    """Return a copy of the RTL with one change."""
    copy = folder / "dut"
    shutil.copytree(DUT, copy)
    path = copy / broken.file
    text = path.read_text()
    assert text.count(broken.old) == 1, "the RTL has changed: adapt the fault"
    path.write_text(text.replace(broken.old, broken.new))
    return copy


def _check_fails(proof: Proof, broken: Broken, folder: Path) -> None:
    # A proof must fail because it sees the fault, not because the tool does not come to an end.
    finding = proof.prove(_break(broken, folder), folder / "proof")
    assert finding.result is Result.FAILED, finding
    assert any(broken.message in problem for problem in finding.problems), finding.problems


def _named(name: str) -> Proof:
    return next(proof for proof in proofs() if proof.name == name)


@pytest.mark.prover
@pytest.mark.parametrize("broken", STREAMS + LEAVES + ENGINE, ids=lambda broken: broken.name)
def test_proof_fails(tmp_path, broken):
    _check_fails(_named(broken.proof), broken, tmp_path)


@pytest.mark.prover
@pytest.mark.parametrize("broken", AXES, ids=lambda broken: broken.name)
def test_algebra_fails(tmp_path, broken):
    if broken.proof == "detector":
        proof = AxesProof("axes", (), detectors=(16,))
    else:
        proof = AxesProof("axes", (parse_configuration(broken.proof),))
    _check_fails(proof, broken, tmp_path)


def test_every_proof_is_seen_to_fail():
    seen = {broken.proof for broken in STREAMS + LEAVES + ENGINE}
    assert {proof.name for proof in proofs() if not isinstance(proof, AxesProof)} <= seen


@pytest.mark.prover
def test_algebra_holds(tmp_path):
    configurations = (Configuration(8, 8), Configuration(16, 0, edge_box=False))
    assert not AxesProof("axes", configurations, detectors=(8,)).prove(DUT, tmp_path).problems


@pytest.mark.prover
def test_what_is_not_covered_fails(tmp_path):
    verdict = _named("verdict_m0")
    assert isinstance(verdict, SbyProof)
    problems = replace(verdict, cover_depth=2).prove(DUT, tmp_path / "unreached").problems
    assert any("cover: FAIL: " in problem and "SeenLastAxis" in problem for problem in problems), problems


@pytest.mark.prover
def test_what_does_not_compile_is_not_decided(tmp_path):
    broken = Broken("", "cross_w2", "core/triaxis_dot.sv", "endmodule", "endmodul", "ERROR")
    finding = _named("cross_w2").prove(_break(broken, tmp_path), tmp_path / "proof")
    assert finding.result is Result.UNDECIDED
    assert any("ERROR" in reason for reason in finding.undecided)
    broken = replace(broken, file="core/triaxis_sum.sv")
    finding = AxesProof("axes", (Configuration(),)).prove(
        _break(broken, tmp_path / "again"), tmp_path / "again" / "proof"
    )
    assert finding.result is Result.UNDECIDED
    assert any("yosys: " in reason for reason in finding.undecided)


def _ends_silently(_: object, log: Path, *__: object) -> int:
    log.touch()
    return 0


def _is_ended(*_: object) -> int:
    raise EndedError("sby: still running")


@pytest.mark.prover
@pytest.mark.parametrize("prover", [_ends_silently, _is_ended])
def test_a_prover_that_comes_to_no_end_decides_nothing(tmp_path, monkeypatch, prover):
    for module in ("verif.formal.proof", "sim.programs"):
        monkeypatch.setattr(f"triaxis.{module}.run_limited", prover)
    names = ("streams_m0", "verdict_m0", "axes_other", "multiply_wide")
    monkeypatch.setattr(proving, "proofs", lambda: tuple(_named(name) for name in names))
    result = proving.prove_all(lambda step: None, folder=tmp_path)
    assert [outcome.finding.result for outcome in result.outcomes] == [Result.UNDECIDED] * len(names)
    assert not result.passed
    assert all(problem.startswith("not decided: ") for problem in result.problems)
    assert f"{len(names)} not decided" in result.summary


def test_names():
    names = proving.proof_names()
    assert len(set(names)) == len(names) > 0
    assert all(len(proof.claim) > 40 and proof.method for proof in proofs())


@dataclass(frozen=True)
class _Given:
    """A proof whose result is given."""

    name: str
    problems: tuple[str, ...] = ()
    claim: str = "a claim"
    method: str = "given"
    assumptions: tuple[str, ...] = ()

    @property
    def parameters(self) -> Mapping[str, int | str]:
        return {}

    def prove(self, dut: Path, folder: Path) -> Finding:
        return Finding(self.problems)


@pytest.mark.prover
def test_one_failure_fails_all(tmp_path, monkeypatch):
    monkeypatch.setattr(proving, "proofs", lambda: (_Given("good"), _Given("bad", ("bad: not so",))))
    result = proving.prove_all(lambda step: None, folder=tmp_path)
    assert result.complete
    assert not result.passed
    assert result.problems == ["bad: not so"]
    evidence = read_evidence(proving.write_result(result, "formal", tmp_path / "formal.json"))
    assert evidence is not None
    assert not evidence["passed"]
    assert (evidence["total"], evidence["proved"]) == (2, 1)

    part = proving.prove_all(lambda step: None, only="g*", folder=tmp_path)
    assert part.passed
    assert not part.complete
    with pytest.raises(ValueError, match="no evidence"):
        proving.write_result(part, "formal", tmp_path / "part.json")
    with pytest.raises(InputError, match="no such proof"):
        proving.prove_all(lambda step: None, only="none", folder=tmp_path)


def test_nothing_proved_is_not_passed():
    assert not proving.FormalResult((), True, 0.0).passed
    outcome = Outcome(_Given("good"), Finding(()), 0.0)
    assert proving.FormalResult((outcome,), True, 0.0).passed
    assert not proving.FormalResult((outcome,), True, 0.0, rtl_changed=True).passed


def test_missing_tool(monkeypatch, tmp_path):
    monkeypatch.setattr("sys.executable", str(tmp_path / "python"))
    with pytest.raises(InputError, match="run `make formal`"):
        require_tools()
