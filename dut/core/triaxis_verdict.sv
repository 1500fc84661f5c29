// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the verdict from the 32 axis bits. Near where no axis separates; otherwise the claim is
// the lowest-numbered separating axis. Flags count only where the multipliers saw the pair: gated_i
// says that its boxes decided it and older operands stayed in place.
// Widths: see verdict_t. Latency: VerdictLatency = 2: axis bits, then claim.

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

  logic [NumAxes-1:0] separated_q;
  verdict_t flags_d, flags_q, verdict_d;

  always_comb begin
    flags_d = '0;
    flags_d.coplanar = coplanar_i && !gated_i;
    flags_d.degenerate_a = degenerate_a_i && !gated_i;
    flags_d.degenerate_b = degenerate_b_i && !gated_i;
  end

  `TRIAXIS_STAGE(separated_q, separated_i)
  `TRIAXIS_STAGE(flags_q, flags_d)

  always_comb begin
    verdict_d = flags_q;
    verdict_d.is_near = separated_q == '0;
    for (int i = NumAxes - 1; i >= 0; i--) begin
      if (separated_q[i]) verdict_d.axis = axis_t'(i);
    end
  end

  `TRIAXIS_STAGE(verdict_o, verdict_d)

endmodule
