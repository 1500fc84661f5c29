// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
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
    input logic [Width-1:0] own_i,
    input logic [3*Width-1:0] points_i,
    input logic [ThresholdWidth-1:0] threshold_i
);

  localparam int unsigned Latency = interval_latency(M);
  // Two bits more than anything that is compared.
  typedef logic signed [Width+1:0] wide_t;
  typedef logic signed [Width-1:0] value_t;

  value_t points[Points];
  logic separated_o;

  for (genvar i = 0; i < Points; i++) begin : g_point
    assign points[i] = value_t'(points_i[i*Width+:Width]);
  end

  triaxis_interval #(
      .Points(Points),
      .Width(Width),
      .ThresholdWidth(ThresholdWidth),
      .M(M)
  ) u_interval (
      .clk_i,
      .own_i(value_t'(own_i)),
      .points_i(points),
      .threshold_i,
      .separated_o
  );

  // What went in, and how long ago.
  value_t own_q[Latency], points_q[Latency][Points];
  logic [ThresholdWidth-1:0] threshold_q[Latency-1];
  logic [2:0] clocks_q = '0;
  always_ff @(posedge clk_i) begin
    own_q[0] <= value_t'(own_i);
    threshold_q[0] <= threshold_i;
    for (int i = 1; i < int'(Latency); i++) own_q[i] <= own_q[i-1];
    for (int i = 1; i < int'(Latency) - 1; i++) threshold_q[i] <= threshold_q[i-1];
    for (int p = 0; p < int'(Points); p++) begin
      points_q[0][p] <= points[p];
      for (int i = 1; i < int'(Latency); i++) points_q[i][p] <= points_q[i-1][p];
    end
    if (clocks_q != 3'(Latency)) clocks_q <= clocks_q + 3'd1;
  end

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
    if (clocks_q == 3'(Latency)) begin
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
