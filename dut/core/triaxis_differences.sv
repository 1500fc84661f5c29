// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the vertices relative to A1: p = A2 - A1, q = A3 - A1, r_j = B_j - A1.
// Widths: W bits in, W+1 bits signed out.
// Latency: DiffLatency = 1.

`include "triaxis_stage.svh"

module triaxis_differences
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    output logic signed [diff_width(W)-1:0] p_o[3],
    output logic signed [diff_width(W)-1:0] q_o[3],
    output logic signed [diff_width(W)-1:0] r_o[3][3]
);

  typedef logic signed [diff_width(W)-1:0] diff_t;

  diff_t p_d[3], q_d[3], r_d[3][3];

  for (genvar k = 0; k < 3; k++) begin : g_coordinate
    assign p_d[k] = diff_t'(a_i[1][k]) - diff_t'(a_i[0][k]);
    assign q_d[k] = diff_t'(a_i[2][k]) - diff_t'(a_i[0][k]);
    for (genvar j = 0; j < 3; j++) begin : g_vertex
      assign r_d[j][k] = diff_t'(b_i[j][k]) - diff_t'(a_i[0][k]);
    end
  end

  `TRIAXIS_STAGE(p_o, p_d)
  `TRIAXIS_STAGE(q_o, q_d)
  `TRIAXIS_STAGE(r_o, r_d)

endmodule
