// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes, from the prisms: which of the eleven three-dimensional axes separate, the normals and
// edge x edge, with bits and thresholds numbered as the axes are (see triaxis_pkg); and the fifteen
// orientations of four vertices, which are all 0 where all six lie in one plane.
// Widths: projections 3W+3 bits signed; moved by a threshold, 3W+4.
// Latency: ProjectionLatency + interval_latency(M); FlatLatency for the orientations. Thresholds are due at
// ProjectionLatency.

module triaxis_space_axes
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [span_width(W)-1:0] a_i,
    input logic signed [span_width(W)-1:0] b_i,
    input logic signed [span_width(W)-1:0] aab_i[3][3],
    input logic signed [span_width(W)-1:0] abb_i[3][3],
    input logic [axis_threshold_width(W, M)-1:0] threshold_i[AxisNormalA:AxisEdgeBoxA-1],
    output logic signed [span_width(W)-1:0] flat_a_o[3],
    output logic signed [span_width(W)-1:0] flat_b_o[3],
    output logic signed [span_width(W)-1:0] flat_edges_o[3][3],
    output logic [AxisEdgeBoxA-1:AxisNormalA] separated_o
);

  localparam int unsigned Width = span_width(W) + ((M == 0) ? 0 : 1);
  localparam int unsigned ThresholdWidth = axis_threshold_width(W, M);
  typedef logic signed [Width-1:0] value_t;
  typedef logic signed [span_width(W)-1:0] span_t;

  span_t normal_a[3], normal_b[3], own[3], points[3][3][2];
  value_t normal_a_points[3], normal_b_points[3];

  triaxis_projections #(
      .W(W),
      .Comb(Comb)
  ) u_projections (
      .clk_i,
      .a_i,
      .b_i,
      .aab_i,
      .abb_i,
      .flat_a_o,
      .flat_b_o,
      .flat_edges_o,
      .normal_a_o(normal_a),
      .normal_b_o(normal_b),
      .own_o(own),
      .points_o(points)
  );

  for (genvar v = 0; v < 3; v++) begin : g_normal_points
    assign normal_a_points[v] = value_t'(normal_a[v]);
    assign normal_b_points[v] = value_t'(normal_b[v]);
  end

  triaxis_interval #(
      .Points(3),
      .Width(Width),
      .ThresholdWidth(ThresholdWidth),
      .M(M),
      .Comb(Comb)
  ) u_normal_a (
      .clk_i,
      .own_i('0),
      .points_i(normal_a_points),
      .threshold_i(threshold_i[AxisNormalA]),
      .separated_o(separated_o[AxisNormalA])
  );

  triaxis_interval #(
      .Points(3),
      .Width(Width),
      .ThresholdWidth(ThresholdWidth),
      .M(M),
      .Comb(Comb)
  ) u_normal_b (
      .clk_i,
      .own_i('0),
      .points_i(normal_b_points),
      .threshold_i(threshold_i[AxisNormalB]),
      .separated_o(separated_o[AxisNormalB])
  );

  for (genvar i = 0; i < 3; i++) begin : g_edge_a
    for (genvar j = 0; j < 3; j++) begin : g_edge_b
      value_t edge_points[2];
      assign edge_points[0] = value_t'(points[i][j][0]);
      assign edge_points[1] = value_t'(points[i][j][1]);
      triaxis_interval #(
          .Points(2),
          .Width(Width),
          .ThresholdWidth(ThresholdWidth),
          .M(M),
          .Comb(Comb)
      ) u_edge_edge (
          .clk_i,
          .own_i(value_t'(own[j])),
          .points_i(edge_points),
          .threshold_i(threshold_i[AxisEdgeEdge+3*i+j]),
          .separated_o(separated_o[AxisEdgeEdge+3*i+j])
      );
    end
  end

endmodule
