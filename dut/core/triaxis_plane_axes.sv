// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which of the eighteen edge x box axes separate, and the edge x edge axes that the
// margins need. Bits and thresholds are numbered as the axes are (see triaxis_pkg).
// Widths: 2D orientations 2W+1 bits signed; moved by a threshold, 2W+3.
// Latency: AxisLatency for edge_edge_o; AxisLatency + interval_latency(M) for separated_o. The
// normals and the thresholds are due at AxisLatency.

module triaxis_plane_axes
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [cross_width(W)-1:0] normal_a_early_i[3],
    input logic signed [cross_width(W)-1:0] pr_i[3][3],
    input logic signed [cross_width(W)-1:0] rq_i[3][3],
    input logic signed [cross_width(W)-1:0] f_i[3][3],
    input logic signed [cross_width(W)-1:0] normal_a_i[3],
    input logic signed [cross_width(W)-1:0] normal_b_i[3],
    input logic [edge_threshold_width(W, M)-1:0] threshold_i[AxisEdgeBoxA:NumAxes-1],
    output logic signed [axis_width(W)-1:0] edge_edge_o[3][3][3],  // [edge of A][edge of B][k]
    output logic [NumAxes-1:AxisEdgeBoxA] separated_o
);

  localparam int unsigned Width = cross_width(W) + ((M == 0) ? 0 : 2);
  localparam int unsigned ThresholdWidth = edge_threshold_width(W, M);
  typedef logic signed [Width-1:0] value_t;
  typedef logic signed [cross_width(W)-1:0] cross_t;
  typedef logic signed [axis_width(W)-1:0] axis_comp_t;

  for (genvar k = 0; k < 3; k++) begin : g_coordinate
    cross_t pr[3], rq[3], f[3], a_points[3][3], b_points[3][3];
    axis_comp_t edge_edge[3][3];

    for (genvar j = 0; j < 3; j++) begin : g_select
      assign pr[j] = pr_i[j][k];
      assign rq[j] = rq_i[j][k];
      assign f[j]  = f_i[j][k];
      for (genvar i = 0; i < 3; i++) begin : g_edge_edge
        assign edge_edge_o[i][j][k] = edge_edge[i][j];
      end
    end

    triaxis_planar #(
        .W(W),
        .Comb(Comb)
    ) u_planar (
        .clk_i,
        .normal_a_i(normal_a_early_i[k]),
        .pr_i(pr),
        .rq_i(rq),
        .f_i(f),
        .edge_edge_o(edge_edge),
        .a_points_o(a_points),
        .b_points_o(b_points)
    );

    for (genvar i = 0; i < 3; i++) begin : g_edge
      value_t a_values[3], b_values[3];
      for (genvar v = 0; v < 3; v++) begin : g_vertex
        assign a_values[v] = value_t'(a_points[i][v]);
        assign b_values[v] = value_t'(b_points[i][v]);
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
