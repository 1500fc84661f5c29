// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether the points lie beyond the interval spanned by 0 and own_i, all on the same
// side, by more than the threshold. Strictly, so a zero axis separates nothing.
// Widths: Width bits signed for everything; own_i +- threshold must fit (see triaxis_pkg).
// Latency: interval_latency(M): margin (only where M > 0), comparison. The threshold is due with the
// points.

`include "triaxis_stage.svh"

module triaxis_interval #(
    parameter int unsigned Points = 3,
    parameter int unsigned Width = 52,
    parameter int unsigned ThresholdWidth = 1,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [Width-1:0] own_i,
    input logic signed [Width-1:0] points_i[Points],
    input logic [ThresholdWidth-1:0] threshold_i,
    output logic separated_o
);

  typedef logic signed [Width-1:0] value_t;

  logic [Points-1:0] below_d, below_q, above_d, above_q;

  if (M == 0) begin : g_no_margin
    logic unused_threshold;
    assign unused_threshold = ^threshold_i;
    for (genvar i = 0; i < Points; i++) begin : g_side
      assign below_d[i] = points_i[i] < 0 && points_i[i] < own_i;
      assign above_d[i] = points_i[i] > 0 && points_i[i] > own_i;
    end
  end else begin : g_margin
    value_t floor_d, floor, ceiling_d, ceiling, points[Points];
    assign floor_d   = ((own_i < 0) ? own_i : '0) - value_t'({1'b0, threshold_i});
    assign ceiling_d = ((own_i < 0) ? '0 : own_i) + value_t'({1'b0, threshold_i});
    `TRIAXIS_STAGE(floor, floor_d)
    `TRIAXIS_STAGE(ceiling, ceiling_d)
    `TRIAXIS_STAGE(points, points_i)
    for (genvar i = 0; i < Points; i++) begin : g_side
      assign below_d[i] = points[i] < floor;
      assign above_d[i] = points[i] > ceiling;
    end
  end

  `TRIAXIS_STAGE(below_q, below_d)
  `TRIAXIS_STAGE(above_q, above_d)

  assign separated_o = (&below_q) || (&above_q);

endmodule
