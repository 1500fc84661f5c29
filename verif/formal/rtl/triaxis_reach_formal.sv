// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// margin * (|x| + |y| + |z|), registers included, against its specification: the sum of absolutes and the
// margin meet at the multiplier, and its product is the reach. So the multiplier, which has a proof of its
// own, need not be seen through, and this holds at full width. Exact = 1 does.

`include "triaxis_formal.svh"

module triaxis_reach_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter bit Exact = 1'b0
) (
    input logic clk_i,
    input logic signed [axis_width(W)-1:0] axis_i[3],
    input logic [M-1:0] margin_i
);

  localparam int unsigned Size = axis_width(W);
  localparam int unsigned Latency = reach_latency(W, M);
  localparam int unsigned NormLatency = Latency - mul_latency(Size + 1, M + 1);
  // Holds the absolutes of any three components.
  typedef logic [Size+1:0] wide_t;
  typedef logic [Size+M-1:0] reach_t;
  localparam logic signed [Size-1:0] Lowest = {1'b1, {(Size - 1) {1'b0}}};

  reach_t reach_o;

  triaxis_reach #(
      .W(W),
      .M(M)
  ) u_reach (
      .*
  );

  wide_t  norm;
  reach_t whole;
  `TRIAXIS_PAST(wide_t, norm_q, norm, Latency)
  `TRIAXIS_PAST(logic [M-1:0], margin_q, margin_i, Latency)
  `TRIAXIS_FULL_AFTER(Latency)
  assign whole = reach_t'(norm_q[Latency-1]) * reach_t'(margin_q[Latency-1]);
  always_comb begin
    norm = '0;
    for (int k = 0; k < 3; k++) begin
      norm += wide_t'((axis_i[k] < 0) ? -wide_t'(axis_i[k]) : wide_t'(axis_i[k]));
    end
    Fits : assume (norm < (wide_t'(1) << Size));
    NotLowest : assume (axis_i[0] != Lowest && axis_i[1] != Lowest && axis_i[2] != Lowest);
  end
  always_comb begin
    if (full) begin
      Norm : assert (wide_t'(u_reach.u_mul.a_i) == norm_q[NormLatency-1]);
      Margin : assert (u_reach.u_mul.b_i == (M + 1)'(margin_q[NormLatency-1]));
      Product : assert (reach_o == reach_t'(u_reach.u_mul.product_o));
      Whole : assert (!Exact || reach_o == whole);
      SeenLargest : cover (norm_q[NormLatency-1] == (wide_t'(1) << Size) - wide_t'(1));
      SeenLowest : cover (axis_i[0] == Lowest + 1 && norm_q[0] != '0);
    end
  end

endmodule
