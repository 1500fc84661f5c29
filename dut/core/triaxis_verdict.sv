// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the verdict from the 32 axis bits. Near where no axis separates; otherwise the claim is
// the lowest-numbered separating axis. Flags count only where the multipliers saw the pair: gated_i
// says that its boxes decided it and older operands stayed in place, unknown ones where no pair has
// reached the multipliers since power-up. So claims of the boxes are made of their axes alone.
// Widths: see verdict_t. Latency: VerdictLatency = 3: axis bits; the lowest of them alone; the claim, of
// each bit of its number whether it is among the axes that have it.

`include "triaxis_stage.svh"

module triaxis_verdict
  import triaxis_pkg::*;
#(
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic [NumAxes-1:0] separated_i,
    input logic gated_i,
    input logic coplanar_i,
    input logic degenerate_a_i,
    input logic degenerate_b_i,
    output verdict_t verdict_o
);

  typedef logic [NumAxes-1:0] axes_t;

  axes_t separated_q, lowest_d, lowest_q;
  axis_t claim;
  verdict_t verdict_d;
  // Coplanar, degenerate A, degenerate B: as they stand in a verdict.
  logic [2:0] flags_d, flags_1, flags_2;

  assign flags_d[0] = coplanar_i && !gated_i;
  assign flags_d[1] = degenerate_a_i && !gated_i;
  assign flags_d[2] = degenerate_b_i && !gated_i;

  `TRIAXIS_STAGE(separated_q, separated_i)
  `TRIAXIS_STAGE(flags_1, flags_d)

  // The box axes, below AxisNormalA, by themselves.
  assign lowest_d[AxisNormalA-1:0] = separated_q[AxisNormalA-1:0] & -separated_q[AxisNormalA-1:0];
  assign lowest_d[NumAxes-1:AxisNormalA] = (separated_q[AxisNormalA-1:0] != '0) ? '0 :
      separated_q[NumAxes-1:AxisNormalA] & -separated_q[NumAxes-1:AxisNormalA];
  `TRIAXIS_STAGE(lowest_q, lowest_d)
  `TRIAXIS_STAGE(flags_2, flags_1)

  for (genvar b = 0; b < $bits(axis_t); b++) begin : g_claim
    // The axes whose numbers have bit b.
    localparam axes_t Having = {NumAxes / (2 << b) {{(1 << b) {1'b1}}, {(1 << b) {1'b0}}}};
    assign claim[b] = (lowest_q & Having) != '0;
  end

  assign verdict_d = {claim, flags_2, lowest_q == '0};

  `TRIAXIS_STAGE(verdict_o, verdict_d)

endmodule
