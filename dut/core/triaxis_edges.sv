// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: margin * |edge x coordinate k|1 for the three edges of one triangle and the three
// coordinates (element 3i+k), from its vertices. Edge i runs from vertex i to the next; the axis
// edge x k has the absolutes of the edge's other two components.
// Widths: vertices W bits; edges W+1 bits signed; thresholds at most 2 L margin: W+1+M unsigned.
// Latency: 1 + threshold_latency(2, W+1, M).

`include "triaxis_stage.svh"

module triaxis_edges
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 8,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] vertex_i[3][3],
    input logic [M-1:0] margin_i,
    output logic [edge_threshold_width(W, M)-1:0] threshold_o[9]
);

  typedef logic signed [diff_width(W)-1:0] diff_t;

  diff_t edge_d[3][3], edge_q[3][3];
  logic [M-1:0] margin_q;

  for (genvar i = 0; i < 3; i++) begin : g_difference
    for (genvar k = 0; k < 3; k++) begin : g_coordinate
      assign edge_d[i][k] = diff_t'(vertex_i[(i+1)%3][k]) - diff_t'(vertex_i[i][k]);
    end
  end
  `TRIAXIS_STAGE(edge_q, edge_d)
  `TRIAXIS_STAGE(margin_q, margin_i)

  for (genvar i = 0; i < 3; i++) begin : g_edge
    for (genvar k = 0; k < 3; k++) begin : g_coordinate
      diff_t others[2];
      assign others[0] = edge_q[i][(k+1)%3];
      assign others[1] = edge_q[i][(k+2)%3];
      triaxis_threshold #(
          .M(M),
          .Components(2),
          .CWidth(diff_width(W)),
          .Comb(Comb)
      ) u_threshold (
          .clk_i,
          .axis_i(others),
          .margin_i(margin_q),
          .threshold_o(threshold_o[3*i+k])
      );
    end
  end

endmodule
