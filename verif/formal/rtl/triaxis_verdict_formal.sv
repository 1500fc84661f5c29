// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Claim and flags, registers included, against their specification, for free axis bits, normals and
// orientations: near exactly where no axis separates; otherwise the claim separates and none
// below it does; flags say zero normals and fifteen zero orientations, and nothing where masked.

`include "triaxis_formal.svh"

module triaxis_verdict_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned NormalWait = 9,
    parameter int unsigned DetWait = 6
) (
    input logic clk_i,
    input logic [NumAxes-1:0] separated_i,
    input logic gated_i,
    input logic signed [cross_width(W)-1:0] normal_a_i[3],
    input logic signed [cross_width(W)-1:0] normal_b_i[3],
    input logic signed [span_width(W)-1:0] flat_a_i[3],
    input logic signed [span_width(W)-1:0] flat_b_i[3],
    input logic signed [span_width(W)-1:0] flat_edges_i[3][3]
);

  localparam int unsigned Last = NormalWait + VerdictLatency;
  typedef logic signed [span_width(W)-1:0] span_t;

  logic degenerate_a_o, degenerate_b_o, coplanar_o;
  verdict_t verdict_o;

  triaxis_flags #(
      .W(W),
      .NormalWait(NormalWait),
      .DetWait(DetWait)
  ) u_flags (
      .*
  );

  triaxis_verdict u_verdict (
      .clk_i,
      .separated_i,
      .gated_i,
      .coplanar_i(coplanar_o),
      .degenerate_a_i(degenerate_a_o),
      .degenerate_b_i(degenerate_b_o),
      .verdict_o
  );

  // What went in, by how long ago. Each comes at its own clock.
  logic flat, flat_a, flat_b;
  `TRIAXIS_PAST(logic [NumAxes-1:0], separated_q, separated_i, VerdictLatency)
  `TRIAXIS_PAST(logic, gated_q, gated_i, VerdictLatency)
  `TRIAXIS_PAST(logic, flat_a_q, flat_a, Last)
  `TRIAXIS_PAST(logic, flat_b_q, flat_b, Last)
  `TRIAXIS_PAST(logic, flat_q, flat, DetWait + VerdictLatency)
  `TRIAXIS_FULL_AFTER(Last)
  assign flat_a = {normal_a_i[0], normal_a_i[1], normal_a_i[2]} == '0;
  assign flat_b = {normal_b_i[0], normal_b_i[1], normal_b_i[2]} == '0;
  always_comb begin
    flat = 1'b1;
    for (int n = 0; n < 3; n++) begin
      if (flat_a_i[n] != span_t'(0) || flat_b_i[n] != span_t'(0)) flat = 1'b0;
      for (int j = 0; j < 3; j++) if (flat_edges_i[n][j] != span_t'(0)) flat = 1'b0;
    end
  end

  logic [NumAxes-1:0] found;
  logic open;
  assign found = separated_q[VerdictLatency-1];
  assign open  = !gated_q[VerdictLatency-1];

  logic lower;
  always_comb begin
    lower = 1'b0;
    for (int n = 0; n < int'(NumAxes); n++) begin
      if (n < int'(verdict_o.axis) && found[n]) lower = 1'b1;
    end
    if (full) begin
      Near : assert (verdict_o.is_near == (found == '0));
      ClaimSeparates : assert (verdict_o.is_near || found[verdict_o.axis]);
      ClaimIsLowest : assert (!lower);
      NoClaimWhereNear : assert (!verdict_o.is_near || verdict_o.axis == axis_t'(0));
      FlagA : assert (verdict_o.degenerate_a == (open && flat_a_q[Last-1]));
      FlagB : assert (verdict_o.degenerate_b == (open && flat_b_q[Last-1]));
      FlagCoplanar : assert (verdict_o.coplanar == (open && flat_q[DetWait+VerdictLatency-1]));
      SeenLastAxis : cover (verdict_o.axis == axis_t'(NumAxes - 1));
      SeenFlags : cover (verdict_o.coplanar && verdict_o.degenerate_a && !verdict_o.degenerate_b);
      SeenMasked : cover (gated_q[VerdictLatency-1] && flat_a_q[Last-1]);
    end
  end

endmodule
