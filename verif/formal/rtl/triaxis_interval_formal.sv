// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The interval tests of the core: normals (three points), edge x edge (two) and edge x box (three),
// with the widths that the data path gives them.

`include "triaxis_formal.svh"

// One interval test, registers included, against its specification: every point lies above both 0
// and own_i by more than the threshold, or every point below both. Its inputs are free, but for the
// promise that own_i +- the threshold fits.
module triaxis_interval_check
  import triaxis_pkg::*;
#(
    parameter int unsigned Points = 3,
    parameter int unsigned Width = 52,
    parameter int unsigned ThresholdWidth = 1,
    parameter int unsigned M = 0
) (
    input logic clk_i,
    input logic signed [Width-1:0] own_i,
    input logic signed [Width-1:0] points_i[Points],
    input logic [ThresholdWidth-1:0] threshold_i
);

  localparam int unsigned Latency = interval_latency(M);
  // Two bits more than anything that is compared.
  typedef logic signed [Width+1:0] wide_t;
  typedef logic signed [Width-1:0] value_t;
  typedef value_t points_t[Points];

  logic separated_o;

  triaxis_interval #(
      .Points(Points),
      .Width(Width),
      .ThresholdWidth(ThresholdWidth),
      .M(M)
  ) u_interval (
      .*
  );

  // What went in, and how long ago.
  `TRIAXIS_PAST(value_t, own_q, own_i, Latency)
  `TRIAXIS_PAST(points_t, points_q, points_i, Latency)
  `TRIAXIS_PAST(logic [ThresholdWidth-1:0], threshold_q, threshold_i, Latency - 1)
  `TRIAXIS_FULL_AFTER(Latency)

  wide_t own, margin, point;
  logic above, below, touching;
  always_comb begin
    own = wide_t'(own_q[Latency-1]);
    margin = (M == 0) ? '0 : wide_t'({2'b00, threshold_q[Latency-2]});
    point = '0;
    above = 1'b1;
    below = 1'b1;
    touching = 1'b0;
    for (int p = 0; p < int'(Points); p++) begin
      point = wide_t'(points_q[Latency-1][p]);
      above &= point > own + margin && point > margin;
      below &= point < own - margin && point < -margin;
      touching |= point == own + margin;
    end
    if (full) begin
      Fits :
      assume (margin < wide_t'(1) <<< (Width - 1) &&
              own + margin < wide_t'(1) <<< (Width - 1) &&
              own - margin >= -(wide_t'(1) <<< (Width - 1)));
      Interval : assert (separated_o == (above || below));
      SeenAbove : cover (above && own > 0 && (M == 0 || margin > 0));
      SeenBelow : cover (below && own < 0 && (M == 0 || margin > 0));
      SeenTouching : cover (touching && own > 0 && (M == 0 || margin > 0) && !above);
    end
  end

endmodule

module triaxis_interval_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    localparam int unsigned SpaceWidth = span_width(W) + ((M == 0) ? 0 : 1),
    localparam int unsigned PlaneWidth = cross_width(W) + ((M == 0) ? 0 : 2)
) (
    input logic clk_i,
    input logic signed [SpaceWidth-1:0] own_i,
    input logic signed [SpaceWidth-1:0] points_i[3],
    input logic [axis_threshold_width(W, M)-1:0] threshold_i,
    input logic signed [PlaneWidth-1:0] plane_own_i,
    input logic signed [PlaneWidth-1:0] plane_points_i[3],
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
      .points_i(points_i[0:1]),
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
