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
  // What is to be said of an input, and what it shows.
  typedef struct packed {
    logic above;
    logic below;
    logic on_the_high_side;
    logic on_the_low_side;
    logic touching;
  } specified_t;

  logic separated_o;

  triaxis_interval #(
      .Points(Points),
      .Width(Width),
      .ThresholdWidth(ThresholdWidth),
      .M(M)
  ) u_interval (
      .*
  );

  wide_t own, margin, point;
  specified_t specified;
  always_comb begin
    own = wide_t'(own_i);
    margin = (M == 0) ? '0 : wide_t'({2'b00, threshold_i});
    point = '0;
    specified = '{above: 1'b1, below: 1'b1, touching: 1'b0, default: '0};
    for (int p = 0; p < int'(Points); p++) begin
      point = wide_t'(points_i[p]);
      specified.above &= point > own + margin && point > margin;
      specified.below &= point < own - margin && point < -margin;
      specified.touching |= point == own + margin;
    end
    specified.on_the_high_side = own > 0 && (M == 0 || margin > 0);
    specified.on_the_low_side  = own < 0 && (M == 0 || margin > 0);
    Fits :
    assume (margin < wide_t'(1) <<< (Width - 1) &&
            own + margin < wide_t'(1) <<< (Width - 1) &&
            own - margin >= -(wide_t'(1) <<< (Width - 1)));
  end

  // Of what went in, and how long ago.
  `TRIAXIS_PAST(specified_t, specified_q, specified, Latency)
  `TRIAXIS_FULL_AFTER(Latency)

  specified_t due;
  assign due = specified_q[Latency-1];
  always_comb begin
    if (full) begin
      Interval : assert (separated_o == (due.above || due.below));
      SeenAbove : cover (due.above && due.on_the_high_side);
      SeenBelow : cover (due.below && due.on_the_low_side);
      SeenTouching : cover (due.touching && due.on_the_high_side && !due.above);
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
