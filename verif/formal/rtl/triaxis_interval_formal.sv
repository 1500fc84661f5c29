// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The interval tests of the core: normals (three points), edge x edge (two) and edge x box (three),
// with the widths that the data path gives them.

module triaxis_interval_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    localparam int unsigned SpaceWidth = span_width(W) + ((M == 0) ? 0 : 1),
    localparam int unsigned PlaneWidth = cross_width(W) + ((M == 0) ? 0 : 2)
) (
    input logic clk_i,
    input logic [SpaceWidth-1:0] own_i,
    input logic [3*SpaceWidth-1:0] points_i,
    input logic [axis_threshold_width(W, M)-1:0] threshold_i,
    input logic [PlaneWidth-1:0] plane_own_i,
    input logic [3*PlaneWidth-1:0] plane_points_i,
    input logic [edge_threshold_width(W, M)-1:0] plane_threshold_i
);

  triaxis_interval_check #(
      .Points(3),
      .Width(SpaceWidth),
      .ThresholdWidth(axis_threshold_width(W, M)),
      .M(M)
  ) u_normal (
      .*
  );

  triaxis_interval_check #(
      .Points(2),
      .Width(SpaceWidth),
      .ThresholdWidth(axis_threshold_width(W, M)),
      .M(M)
  ) u_edge_edge (
      .*
  );

  triaxis_interval_check #(
      .Points(3),
      .Width(PlaneWidth),
      .ThresholdWidth(edge_threshold_width(W, M)),
      .M(M)
  ) u_edge_box (
      .clk_i,
      .own_i(plane_own_i),
      .points_i(plane_points_i),
      .threshold_i(plane_threshold_i)
  );

endmodule
