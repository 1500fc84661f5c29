// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether all of three projections lie beyond all of three others by more than the reach, on
// either side, strictly. The first of A is the origin: it is 0.
// Widths: a projection from the origin, and the difference of two, is one of a difference of vertices: at
// most 4 L^3, 3W+3 bits signed. The reach is at most 4 L^2 (2^M - 1) <= 4 L^3.
// Latency: ApartLatency = 4: who is larger, ends, gaps, comparison. The reach comes with the gaps, three
// clocks after the projections.

`include "triaxis_stage.svh"

module triaxis_apart
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [span_width(W)-1:0] a_i[2],
    input logic signed [span_width(W)-1:0] b_i[3],
    input logic [axis_threshold_width(W, M)-1:0] reach_i,
    output logic apart_o
);

  typedef logic signed [span_width(W)-1:0] span_t;

  span_t a_q[2], b_q[3], high_a, low_a, high_b, low_b;
  logic [span_width(W)-2:0] top_a_d, top_a_q;
  span_t end_a_d, end_a_q, top_b_d, top_b_q, end_b_d, end_b_q;
  span_t above_d, above_q, below_d, below_q;
  logic a_larger_d, a_larger_q, b_larger_d, b_larger_q, apart_d;

  assign a_larger_d = a_i[0] > a_i[1];
  assign b_larger_d = b_i[0] > b_i[1];
  `TRIAXIS_STAGE(a_q, a_i)
  `TRIAXIS_STAGE(b_q, b_i)
  `TRIAXIS_STAGE(a_larger_q, a_larger_d)
  `TRIAXIS_STAGE(b_larger_q, b_larger_d)

  assign high_a  = a_larger_q ? a_q[0] : a_q[1];
  assign low_a   = a_larger_q ? a_q[1] : a_q[0];
  assign high_b  = b_larger_q ? b_q[0] : b_q[1];
  assign low_b   = b_larger_q ? b_q[1] : b_q[0];
  assign top_a_d = (high_a < 0) ? '0 : high_a[span_width(W)-2:0];
  assign end_a_d = (low_a < 0) ? low_a : '0;
  assign top_b_d = (high_b < b_q[2]) ? b_q[2] : high_b;
  assign end_b_d = (low_b < b_q[2]) ? low_b : b_q[2];
  `TRIAXIS_STAGE(top_a_q, top_a_d)
  `TRIAXIS_STAGE(end_a_q, end_a_d)
  `TRIAXIS_STAGE(top_b_q, top_b_d)
  `TRIAXIS_STAGE(end_b_q, end_b_d)

  assign above_d = end_b_q - span_t'({1'b0, top_a_q});
  assign below_d = end_a_q - top_b_q;
  `TRIAXIS_STAGE(above_q, above_d)
  `TRIAXIS_STAGE(below_q, below_d)

  assign apart_d = above_q > span_t'({1'b0, reach_i}) || below_q > span_t'({1'b0, reach_i});
  `TRIAXIS_STAGE(apart_o, apart_d)

endmodule
