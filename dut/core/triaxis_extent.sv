// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the smallest and the largest of three coordinates.
// Widths: W bits signed in and out.
// Latency: 2: order (pairwise comparisons), then selection.

`include "triaxis_stage.svh"

module triaxis_extent #(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] points_i[3],
    output logic signed [W-1:0] low_o,
    output logic signed [W-1:0] high_o
);

  typedef logic signed [W-1:0] coord_t;

  // Bit i: point i lies below point i+1, cyclically.
  logic [2:0] below_d, below_q;
  coord_t points_q[3];
  // Which point is the lowest, which the highest: one bit each.
  logic [2:0] low, high;
  coord_t low_d, high_d;

  for (genvar i = 0; i < 3; i++) begin : g_below
    assign below_d[i] = points_i[i] < points_i[(i+1)%3];
  end

  `TRIAXIS_STAGE(below_q, below_d)
  `TRIAXIS_STAGE(points_q, points_i)

  // Point i is a lowest one where it lies below its successor and its predecessor does not lie
  // below it; a highest one the other way round. Where neither of the first two qualifies, the
  // third does: with all three equal, any will do.
  assign low[0] = below_q[0] && !below_q[2];
  assign low[1] = below_q[1] && !below_q[0];
  assign low[2] = !low[0] && !low[1];
  assign high[0] = !below_q[0] && below_q[2];
  assign high[1] = !below_q[1] && below_q[0];
  assign high[2] = !high[0] && !high[1];

  assign low_d = ({W{low[0]}} & points_q[0]) | ({W{low[1]}} & points_q[1]) |
      ({W{low[2]}} & points_q[2]);
  assign high_d = ({W{high[0]}} & points_q[0]) | ({W{high[1]}} & points_q[1]) |
      ({W{high[2]}} & points_q[2]);

  `TRIAXIS_STAGE(low_o, low_d)
  `TRIAXIS_STAGE(high_o, high_d)

endmodule
