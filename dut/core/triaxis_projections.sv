// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: every inner product that the eleven three-dimensional axes need, from the prisms under
// twenty triangles (docs/theory.md, section 4). An axis serves with either sign, so the sign that
// needs no negation is taken:
//   normal of A      A at 0, vertex j of B at normal_a_o[j]
//   normal of B      B at 0, vertex i of A at normal_b_o[i]
//   edge i x edge j  A at 0 and own_o[j], B at points_o[i][j]
// and flat_a_o, flat_b_o, flat_edges_o, the orientations of four vertices among these, at FlatLatency.
// Widths: orientations of four vertices 3W+2 bits; differences of projections 3W+3 bits. Sums wrap on
// the way.
// Latency: ProjectionLatency = 4, one addition each. A suffix _n marks the value after n stages.

`include "triaxis_stage.svh"

module triaxis_projections
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [span_width(W)-1:0] a_i,
    input logic signed [span_width(W)-1:0] b_i,
    input logic signed [span_width(W)-1:0] aab_i[3][3],
    input logic signed [span_width(W)-1:0] abb_i[3][3],
    output logic signed [span_width(W)-1:0] flat_a_o[3],
    output logic signed [span_width(W)-1:0] flat_b_o[3],
    output logic signed [span_width(W)-1:0] flat_edges_o[3][3],
    output logic signed [span_width(W)-1:0] normal_a_o[3],
    output logic signed [span_width(W)-1:0] normal_b_o[3],
    output logic signed [span_width(W)-1:0] own_o[3],
    output logic signed [span_width(W)-1:0] points_o[3][3][2]
);

  typedef logic signed [span_width(W)-1:0] span_t;

  span_t first_a_d[3], first_a_1[3], last_a_d[3], last_a_1[3];  // two and two of four faces
  span_t first_b_d[3], first_b_1[3], last_b_d[3], last_b_1[3];
  span_t on_a_d[3][3], on_a_1[3][3], on_b_d[3][3], on_b_1[3][3];
  span_t normal_a_d[3], normal_a_2[3], normal_a_3[3];  // A with vertex j of B
  span_t normal_b_d[3], normal_b_2[3], normal_b_3[3];  // B with vertex i of A
  span_t edges_d[3][3], edges_2[3][3], edges_3[3][3], edges_4[3][3];  // edge i with edge j
  span_t along_d[3], along_3[3];  // N_A . (edge j of B)
  span_t across_d[3], across_3[3];  // N_B . (edge i of A), negative
  span_t far_d[3][3], far_4[3][3];  // third vertex of B, on edge i x edge j

  for (genvar j = 0; j < 3; j++) begin : g_vertex
    assign first_a_d[j]  = aab_i[0][j] + aab_i[1][j];
    assign last_a_d[j]   = aab_i[2][j] - a_i;
    assign first_b_d[j]  = b_i - abb_i[j][0];
    assign last_b_d[j]   = abb_i[j][1] + abb_i[j][2];
    assign normal_a_d[j] = first_a_1[j] + last_a_1[j];
    assign normal_b_d[j] = first_b_1[j] - last_b_1[j];
    assign along_d[j]    = normal_a_2[(j+1)%3] - normal_a_2[j];
    assign across_d[j]   = normal_b_2[(j+1)%3] - normal_b_2[j];
  end
  for (genvar i = 0; i < 3; i++) begin : g_edge_a
    for (genvar j = 0; j < 3; j++) begin : g_edge_b
      assign on_a_d[i][j]  = aab_i[i][(j+1)%3] - aab_i[i][j];
      assign on_b_d[i][j]  = abb_i[(i+1)%3][j] - abb_i[i][j];
      assign edges_d[i][j] = on_a_1[i][j] + on_b_1[i][j];
      assign far_d[i][j]   = edges_3[i][j] + across_3[i];
    end
  end

  `TRIAXIS_STAGE(first_a_1, first_a_d)
  `TRIAXIS_STAGE(last_a_1, last_a_d)
  `TRIAXIS_STAGE(first_b_1, first_b_d)
  `TRIAXIS_STAGE(last_b_1, last_b_d)
  `TRIAXIS_STAGE(on_a_1, on_a_d)
  `TRIAXIS_STAGE(on_b_1, on_b_d)

  `TRIAXIS_STAGE(normal_a_2, normal_a_d)
  `TRIAXIS_STAGE(normal_b_2, normal_b_d)
  `TRIAXIS_STAGE(edges_2, edges_d)

  `TRIAXIS_STAGE(normal_a_3, normal_a_2)
  `TRIAXIS_STAGE(normal_b_3, normal_b_2)
  `TRIAXIS_STAGE(edges_3, edges_2)
  `TRIAXIS_STAGE(along_3, along_d)
  `TRIAXIS_STAGE(across_3, across_d)

  `TRIAXIS_STAGE(normal_a_o, normal_a_3)
  `TRIAXIS_STAGE(normal_b_o, normal_b_3)
  `TRIAXIS_STAGE(own_o, along_3)
  `TRIAXIS_STAGE(edges_4, edges_3)
  `TRIAXIS_STAGE(far_4, far_d)

  for (genvar i = 0; i < 3; i++) begin : g_out
    for (genvar j = 0; j < 3; j++) begin : g_points
      assign points_o[i][j][0] = edges_4[i][j];
      assign points_o[i][j][1] = far_4[i][j];
    end
  end
  assign flat_a_o = normal_a_2;
  assign flat_b_o = normal_b_2;
  assign flat_edges_o = edges_2;

endmodule
