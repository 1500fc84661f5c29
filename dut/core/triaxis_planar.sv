// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes, for one coordinate k, what the edge x box axes and the margins need; names as in
// triaxis_products:
//   edge_edge_o[i][j]  component k of (edge i of A) x (edge j of B), up to sign
//   a_points_o[i][j]   vertex j of B against edge i of A, seen along k; A's third vertex lies at
//                      component k of N_A
//   b_points_o[j][i]   vertex i of A against edge j of B, seen along k; B's third vertex lies at
//                      component k of N_B
// Widths: edge x edge 2W+2 bits signed; 2D orientations of three vertices are at most L^2, 2W+1.
// Latency: AxisLatency = 2, one addition each. A suffix _n marks the value after n stages.

`include "triaxis_stage.svh"

module triaxis_planar
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [cross_width(W)-1:0] normal_a_i,
    input logic signed [cross_width(W)-1:0] pr_i[3],
    input logic signed [cross_width(W)-1:0] rq_i[3],
    input logic signed [cross_width(W)-1:0] f_i[3],
    output logic signed [axis_width(W)-1:0] edge_edge_o[3][3],
    output logic signed [cross_width(W)-1:0] a_points_o[3][3],
    output logic signed [cross_width(W)-1:0] b_points_o[3][3]
);

  typedef logic signed [cross_width(W)-1:0] cross_t;
  typedef logic signed [axis_width(W)-1:0] axis_comp_t;

  cross_t normal_a_1, pr_1[3], rq_1[3], f_1[3];
  axis_comp_t edge0_d[3], edge0_1[3];  // (edge 0 of A) x (edge j of B)
  axis_comp_t edge2_d[3], edge2_1[3];  // (edge 2 of A) x (edge j of B)
  axis_comp_t pr_plus_rq_d[3], pr_plus_rq_1[3];
  axis_comp_t edge_edge_d[3][3];
  cross_t a_points_d[3][3], b_points_d[3][3];

  for (genvar j = 0; j < 3; j++) begin : g_stage1
    assign edge0_d[j] = axis_comp_t'(pr_i[(j+1)%3]) - axis_comp_t'(pr_i[j]);
    assign edge2_d[j] = axis_comp_t'(rq_i[(j+1)%3]) - axis_comp_t'(rq_i[j]);
    assign pr_plus_rq_d[j] = axis_comp_t'(pr_i[j]) + axis_comp_t'(rq_i[j]);
  end
  `TRIAXIS_STAGE(normal_a_1, normal_a_i)
  `TRIAXIS_STAGE(pr_1, pr_i)
  `TRIAXIS_STAGE(rq_1, rq_i)
  `TRIAXIS_STAGE(f_1, f_i)
  `TRIAXIS_STAGE(edge0_1, edge0_d)
  `TRIAXIS_STAGE(edge2_1, edge2_d)
  `TRIAXIS_STAGE(pr_plus_rq_1, pr_plus_rq_d)

  // The edges of A sum to zero, so edge 1 gives the negative of the other two together.
  for (genvar j = 0; j < 3; j++) begin : g_stage2
    assign edge_edge_d[0][j] = edge0_1[j];
    assign edge_edge_d[1][j] = edge0_1[j] + edge2_1[j];
    assign edge_edge_d[2][j] = edge2_1[j];
    assign a_points_d[0][j]  = pr_1[j];
    assign a_points_d[1][j]  = cross_t'(axis_comp_t'(normal_a_1) - pr_plus_rq_1[j]);
    assign a_points_d[2][j]  = rq_1[j];
    assign b_points_d[j][0]  = f_1[j];
    assign b_points_d[j][1]  = cross_t'(axis_comp_t'(f_1[j]) - edge0_1[j]);
    assign b_points_d[j][2]  = cross_t'(axis_comp_t'(f_1[j]) + edge2_1[j]);
  end
  `TRIAXIS_STAGE(edge_edge_o, edge_edge_d)
  `TRIAXIS_STAGE(a_points_o, a_points_d)
  `TRIAXIS_STAGE(b_points_o, b_points_d)

endmodule
