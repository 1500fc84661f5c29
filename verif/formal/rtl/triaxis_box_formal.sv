// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The test of one box axis, registers included, against its specification: the lowest and the
// highest of each triangle are what these words say, and the gap between them, one way or the other, is
// larger than the margin.

`include "triaxis_formal.svh"

module triaxis_box_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3],
    input logic signed [W-1:0] b_i[3],
    input logic [margin_width(M)-1:0] margin_i
);

  typedef logic signed [W+1:0] wide_t;
  typedef logic signed [W-1:0] coord_t;
  typedef coord_t points_t[3];
  typedef logic [margin_width(M)-1:0] margin_t;

  logic separated_o;

  margin_t margin;
  assign margin = (M == 0) ? '0 : margin_i;

  triaxis_box #(
      .W(W),
      .M(M)
  ) u_box (
      .clk_i,
      .a_i,
      .b_i,
      .margin_i(margin),
      .separated_o
  );

  // What went in, what the extents came to, and how long ago.
  localparam int unsigned Extents = 2;
  localparam int unsigned Rest = BoxLatency - Extents;
  `TRIAXIS_PAST(points_t, a_q, a_i, Extents)
  `TRIAXIS_PAST(points_t, b_q, b_i, Extents)
  `TRIAXIS_PAST(coord_t, a_low_q, u_box.a_low, Rest)
  `TRIAXIS_PAST(coord_t, a_high_q, u_box.a_high, Rest)
  `TRIAXIS_PAST(coord_t, b_low_q, u_box.b_low, Rest)
  `TRIAXIS_PAST(coord_t, b_high_q, u_box.b_high, Rest)
  `TRIAXIS_PAST(margin_t, margin_q, margin, BoxLatency)
  `TRIAXIS_FULL_AFTER(BoxLatency)

  // One of the three, and none of them lower; likewise the highest.
  function automatic logic is_lowest(coord_t low, coord_t first, coord_t second, coord_t third);
    return (low == first || low == second || low == third) &&
        low <= first && low <= second && low <= third;
  endfunction

  function automatic logic is_highest(coord_t high, coord_t first, coord_t second, coord_t third);
    return (high == first || high == second || high == third) &&
        high >= first && high >= second && high >= third;
  endfunction

  logic a_first, b_first;
  wide_t wide_margin;
  assign wide_margin = wide_t'({1'b0, margin_q[BoxLatency-1]});
  assign a_first = wide_t'(b_low_q[1]) - wide_t'(a_high_q[1]) > wide_margin;
  assign b_first = wide_t'(a_low_q[1]) - wide_t'(b_high_q[1]) > wide_margin;

  always_comb begin
    if (full) begin
      Lowest :
      assert (is_lowest(
          u_box.a_low, a_q[1][0], a_q[1][1], a_q[1][2]
      ) && is_lowest(
          u_box.b_low, b_q[1][0], b_q[1][1], b_q[1][2]
      ));
      Highest :
      assert (is_highest(
          u_box.a_high, a_q[1][0], a_q[1][1], a_q[1][2]
      ) && is_highest(
          u_box.b_high, b_q[1][0], b_q[1][1], b_q[1][2]
      ));
      Box : assert (separated_o == (a_first || b_first));
      SeenApart : cover (a_first && (M == 0 || margin_q[BoxLatency-1][margin_width(M)-1]));
      SeenApartOtherWay : cover (b_first);
      SeenTogether : cover (!a_first && !b_first);
    end
  end

endmodule
