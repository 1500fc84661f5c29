// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which of the eighteen edge x box axes separate, from the areas seen along each coordinate
// axis (see triaxis_areas). Bits and thresholds are numbered as the axes are (see triaxis_pkg).
// Widths: 2D orientations 2W+1 bits signed; moved by a threshold, 2W+3.
// Latency: interval_latency(M).

module triaxis_plane_axes
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [cross_width(W)-1:0] normal_a_i[3],
    input logic signed [cross_width(W)-1:0] normal_b_i[3],
    input logic signed [cross_width(W)-1:0] a_points_i[3][3][3],  // [along][edge of A][vertex of B]
    input logic signed [cross_width(W)-1:0] b_points_i[3][3][3],  // [along][edge of B][vertex of A]
    input logic [edge_threshold_width(W, M)-1:0] threshold_i[AxisEdgeBoxA:NumAxes-1],
    output logic [NumAxes-1:AxisEdgeBoxA] separated_o
);

  localparam int unsigned Width = cross_width(W) + ((M == 0) ? 0 : 2);
  localparam int unsigned ThresholdWidth = edge_threshold_width(W, M);
  typedef logic signed [Width-1:0] value_t;

  for (genvar k = 0; k < 3; k++) begin : g_coordinate
    for (genvar i = 0; i < 3; i++) begin : g_edge
      value_t a_values[3], b_values[3];
      for (genvar v = 0; v < 3; v++) begin : g_vertex
        assign a_values[v] = value_t'(a_points_i[k][i][v]);
        assign b_values[v] = value_t'(b_points_i[k][i][v]);
      end
      triaxis_interval #(
          .Points(3),
          .Width(Width),
          .ThresholdWidth(ThresholdWidth),
          .M(M),
          .Comb(Comb)
      ) u_a (
          .clk_i,
          .own_i(value_t'(normal_a_i[k])),
          .points_i(a_values),
          .threshold_i(threshold_i[AxisEdgeBoxA+3*i+k]),
          .separated_o(separated_o[AxisEdgeBoxA+3*i+k])
      );
      triaxis_interval #(
          .Points(3),
          .Width(Width),
          .ThresholdWidth(ThresholdWidth),
          .M(M),
          .Comb(Comb)
      ) u_b (
          .clk_i,
          .own_i(value_t'(normal_b_i[k])),
          .points_i(b_values),
          .threshold_i(threshold_i[AxisEdgeBoxB+3*i+k]),
          .separated_o(separated_o[AxisEdgeBoxB+3*i+k])
      );
    end
  end

endmodule
