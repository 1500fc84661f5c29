// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: degenerate A and B (a zero normal: the triangle is a segment or a point) and coplanar
// (all six vertices in one plane: exactly where all fifteen orientations of four of them vanish).
// Widths: one bit each.
// Latency: to interval_latency(M) after the projections, with the axis bits: the normals arrive
// NormalWait clocks before, the orientations DetWait clocks before.

module triaxis_flags
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned NormalWait = 1,
    parameter int unsigned DetWait = 1
) (
    input logic clk_i,
    input logic signed [cross_width(W)-1:0] normal_a_i[3],
    input logic signed [cross_width(W)-1:0] normal_b_i[3],
    input logic signed [span_width(W)-1:0] flat_a_i[3],
    input logic signed [span_width(W)-1:0] flat_b_i[3],
    input logic signed [span_width(W)-1:0] flat_edges_i[3][3],
    output logic degenerate_a_o,
    output logic degenerate_b_o,
    output logic coplanar_o
);

  typedef logic [2:0] zeros_t;
  typedef logic [14:0] det_zeros_t;

  zeros_t a_zero_d, a_zero_q, b_zero_d, b_zero_q;
  det_zeros_t det_zero_d, det_zero_q;

  for (genvar k = 0; k < 3; k++) begin : g_zero
    assign a_zero_d[k] = normal_a_i[k] == 0;
    assign b_zero_d[k] = normal_b_i[k] == 0;
    assign det_zero_d[k] = flat_a_i[k] == 0;
    assign det_zero_d[3+k] = flat_b_i[k] == 0;
    for (genvar j = 0; j < 3; j++) begin : g_edges
      assign det_zero_d[6+3*k+j] = flat_edges_i[k][j] == 0;
    end
  end

  triaxis_delay #(
      .T(zeros_t),
      .Cycles(NormalWait)
  ) u_a_zero (
      .clk_i,
      .d_i(a_zero_d),
      .q_o(a_zero_q)
  );
  triaxis_delay #(
      .T(zeros_t),
      .Cycles(NormalWait)
  ) u_b_zero (
      .clk_i,
      .d_i(b_zero_d),
      .q_o(b_zero_q)
  );
  triaxis_delay #(
      .T(det_zeros_t),
      .Cycles(DetWait)
  ) u_det_zero (
      .clk_i,
      .d_i(det_zero_d),
      .q_o(det_zero_q)
  );

  assign degenerate_a_o = &a_zero_q;
  assign degenerate_b_o = &b_zero_q;
  assign coplanar_o = &det_zero_q;

endmodule
