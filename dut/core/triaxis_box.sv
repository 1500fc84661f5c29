// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether one coordinate axis separates A and B by more than the margin,
// min B - max A > m or min A - max B > m.
// Widths: coordinates W bits; gaps W+1 bits signed; the margin has at most W bits, so it fits
// W+1 bits signed as well.
// Latency: BoxLatency = 4: two for the extents, then gaps, then comparison.

`include "triaxis_stage.svh"

module triaxis_box
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3],
    input logic signed [W-1:0] b_i[3],
    input logic [margin_width(M)-1:0] margin_i,
    output logic separated_o
);

  typedef logic signed [diff_width(W)-1:0] gap_t;

  logic signed [W-1:0] a_low, a_high, b_low, b_high;
  gap_t a_to_b_d, a_to_b_q, b_to_a_d, b_to_a_q, margin;
  logic separated_d;

  triaxis_extent #(
      .W(W),
      .Comb(Comb)
  ) u_extent_a (
      .clk_i,
      .points_i(a_i),
      .low_o(a_low),
      .high_o(a_high)
  );

  triaxis_extent #(
      .W(W),
      .Comb(Comb)
  ) u_extent_b (
      .clk_i,
      .points_i(b_i),
      .low_o(b_low),
      .high_o(b_high)
  );

  assign a_to_b_d = gap_t'(b_low) - gap_t'(a_high);
  assign b_to_a_d = gap_t'(a_low) - gap_t'(b_high);
  `TRIAXIS_STAGE(a_to_b_q, a_to_b_d)
  `TRIAXIS_STAGE(b_to_a_q, b_to_a_d)

  triaxis_delay #(
      .T(gap_t),
      .Cycles(Comb ? 0 : BoxLatency - 1)
  ) u_margin (
      .clk_i,
      .d_i(gap_t'({1'b0, margin_i})),
      .q_o(margin)
  );

  assign separated_d = (a_to_b_q > margin) || (b_to_a_q > margin);
  `TRIAXIS_STAGE(separated_o, separated_d)

endmodule
