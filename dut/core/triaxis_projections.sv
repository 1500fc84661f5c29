// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: every inner product that the eleven three-dimensional axes need, from ten triple
// products (docs/theory.md, section 4), named as in triaxis_products. An axis serves with
// either sign, so the sign that needs no negation is taken:
//   normal of A      A at 0, B at normal_a_o
//   normal of B      B at 0, A at normal_b_o
//   edge i x edge j  A at 0 and own_o[i][j], B at points_o[i][j]
// Edge 0 of A is p (with the axis taken as f x p), edge 1 is q - p, edge 2 is -q.
// Widths: orientations of four vertices 3W+2 bits; differences of projections 3W+3 bits.
// Latency: ProjectionLatency = 4, one addition each. A suffix _n marks the value after n stages.

`include "triaxis_stage.svh"

module triaxis_projections
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [det_width(W)-1:0] pqr_i[3],
    input logic signed [det_width(W)-1:0] pf_i[3],
    input logic signed [det_width(W)-1:0] qf_i[3],
    input logic signed [det_width(W)-1:0] rst_i,
    output logic signed [span_width(W)-1:0] normal_a_o[3],
    output logic signed [span_width(W)-1:0] normal_b_o[3],
    output logic signed [span_width(W)-1:0] own_o[3][3],
    output logic signed [span_width(W)-1:0] points_o[3][3][2]
);

  typedef logic signed [span_width(W)-1:0] span_t;

  span_t pqr_0[3], pqr_1[3], pqr_2[3], pqr_3[3], pqr_4[3];
  span_t pf_0[3], pf_1[3], pf_2[3], pf_3[3], pf_4[3];
  span_t qf_0[3], qf_1[3], qf_2[3], qf_3[3], qf_4[3];
  span_t rst_0, rst_1, rst_2;
  span_t along_d[3], along_1[3], along_2[3], along_3[3], along_4[3];  // N_A . (edge j of B)
  span_t against_d[3], against_1[3], against_2[3], against_3[3], against_4[3];  // its negative
  span_t pf_less_qf_d[3], pf_less_qf_1[3];
  span_t pf01_d, pf01_1, qf01_d, qf01_1;
  span_t p_normal_d, p_normal_2, p_normal_3;  // p . N_B
  span_t q_normal_d, q_normal_2, q_normal_3;  // q . N_B
  span_t middle_d[3], middle_2[3], middle_3[3], middle_4[3];  // orientations with edge 1 of A
  span_t normal_b_d[3], normal_b_3[3];  // N_B . (B1 - A_i)
  span_t edge1_normal_d, edge1_normal_3;  // N_B . (edge 1 of A)
  span_t far_d[3][3], far_4[3][3];  // third vertex of B, on edge i x edge j

  assign rst_0 = span_t'(rst_i);
  for (genvar j = 0; j < 3; j++) begin : g_extend
    assign pqr_0[j] = span_t'(pqr_i[j]);
    assign pf_0[j]  = span_t'(pf_i[j]);
    assign qf_0[j]  = span_t'(qf_i[j]);
  end

  for (genvar j = 0; j < 3; j++) begin : g_stage1
    assign along_d[j] = pqr_0[(j+1)%3] - pqr_0[j];
    assign against_d[j] = pqr_0[j] - pqr_0[(j+1)%3];
    assign pf_less_qf_d[j] = pf_0[j] - qf_0[j];
  end
  assign pf01_d = pf_0[0] + pf_0[1];
  assign qf01_d = qf_0[0] + qf_0[1];
  `TRIAXIS_STAGE(pqr_1, pqr_0)
  `TRIAXIS_STAGE(pf_1, pf_0)
  `TRIAXIS_STAGE(qf_1, qf_0)
  `TRIAXIS_STAGE(rst_1, rst_0)
  `TRIAXIS_STAGE(along_1, along_d)
  `TRIAXIS_STAGE(against_1, against_d)
  `TRIAXIS_STAGE(pf_less_qf_1, pf_less_qf_d)
  `TRIAXIS_STAGE(pf01_1, pf01_d)
  `TRIAXIS_STAGE(qf01_1, qf01_d)

  for (genvar j = 0; j < 3; j++) begin : g_stage2
    assign middle_d[j] = pf_less_qf_1[j] - along_1[j];
  end
  assign p_normal_d = pf01_1 + pf_1[2];
  assign q_normal_d = qf01_1 + qf_1[2];
  `TRIAXIS_STAGE(pqr_2, pqr_1)
  `TRIAXIS_STAGE(pf_2, pf_1)
  `TRIAXIS_STAGE(qf_2, qf_1)
  `TRIAXIS_STAGE(rst_2, rst_1)
  `TRIAXIS_STAGE(along_2, along_1)
  `TRIAXIS_STAGE(against_2, against_1)
  `TRIAXIS_STAGE(middle_2, middle_d)
  `TRIAXIS_STAGE(p_normal_2, p_normal_d)
  `TRIAXIS_STAGE(q_normal_2, q_normal_d)

  assign normal_b_d[0]  = rst_2;
  assign normal_b_d[1]  = rst_2 - p_normal_2;
  assign normal_b_d[2]  = rst_2 - q_normal_2;
  assign edge1_normal_d = q_normal_2 - p_normal_2;
  `TRIAXIS_STAGE(pqr_3, pqr_2)
  `TRIAXIS_STAGE(pf_3, pf_2)
  `TRIAXIS_STAGE(qf_3, qf_2)
  `TRIAXIS_STAGE(along_3, along_2)
  `TRIAXIS_STAGE(against_3, against_2)
  `TRIAXIS_STAGE(middle_3, middle_2)
  `TRIAXIS_STAGE(p_normal_3, p_normal_2)
  `TRIAXIS_STAGE(q_normal_3, q_normal_2)
  `TRIAXIS_STAGE(normal_b_3, normal_b_d)
  `TRIAXIS_STAGE(edge1_normal_3, edge1_normal_d)

  for (genvar j = 0; j < 3; j++) begin : g_stage4
    assign far_d[0][j] = pf_3[j] - p_normal_3;
    assign far_d[1][j] = middle_3[j] + edge1_normal_3;
    assign far_d[2][j] = qf_3[j] - q_normal_3;
  end
  `TRIAXIS_STAGE(pqr_4, pqr_3)
  `TRIAXIS_STAGE(pf_4, pf_3)
  `TRIAXIS_STAGE(qf_4, qf_3)
  `TRIAXIS_STAGE(along_4, along_3)
  `TRIAXIS_STAGE(against_4, against_3)
  `TRIAXIS_STAGE(middle_4, middle_3)
  `TRIAXIS_STAGE(normal_b_o, normal_b_3)
  `TRIAXIS_STAGE(far_4, far_d)

  assign normal_a_o = pqr_4;
  for (genvar j = 0; j < 3; j++) begin : g_out
    assign own_o[0][j] = along_4[j];
    assign own_o[1][j] = against_4[j];
    assign own_o[2][j] = against_4[j];
    assign points_o[0][j][0] = pf_4[j];
    assign points_o[1][j][0] = middle_4[j];
    assign points_o[2][j][0] = qf_4[j];
    for (genvar i = 0; i < 3; i++) begin : g_far
      assign points_o[i][j][1] = far_4[i][j];
    end
  end

endmodule
