// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// margin * (|c0| + |c1| ..), registers included, against its specification: the sum of absolutes and
// the margin meet at the multiplier, and its product is the threshold. So the multiplier, which has a
// proof of its own, need not be seen through, and this holds at full width. Exact = 1 does.

`include "triaxis_formal.svh"

module triaxis_threshold_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned M = 16,
    parameter int unsigned Components = 3,
    parameter int unsigned CWidth = 34,
    parameter bit Exact = 1'b0
) (
    input logic clk_i,
    input logic signed [CWidth-1:0] axis_i[Components],
    input logic [M-1:0] margin_i
);

  localparam int unsigned Latency = threshold_latency(Components, CWidth, M);
  localparam int unsigned NormLatency = Latency - mul_latency(CWidth + 1, M + 1);
  typedef logic [CWidth+2:0] wide_t;
  typedef logic [CWidth+M-1:0] threshold_t;

  threshold_t threshold_o;

  triaxis_threshold #(
      .M(M),
      .Components(Components),
      .CWidth(CWidth)
  ) u_threshold (
      .*
  );

  wide_t norm;
  threshold_t whole;
  `TRIAXIS_PAST(wide_t, norm_q, norm, Latency)
  `TRIAXIS_PAST(logic [M-1:0], margin_q, margin_i, Latency)
  `TRIAXIS_FULL_AFTER(Latency)
  assign whole = threshold_t'(norm_q[Latency-1]) * threshold_t'(margin_q[Latency-1]);
  always_comb begin
    norm = '0;
    for (int k = 0; k < int'(Components); k++) begin
      norm += wide_t'((axis_i[k] < 0) ? -wide_t'(axis_i[k]) : wide_t'(axis_i[k]));
    end
    Fits : assume (norm < (wide_t'(1) << CWidth));
  end
  always_comb begin
    if (full) begin
      Norm : assert (wide_t'(u_threshold.u_mul.a_i) == norm_q[NormLatency-1]);
      Margin : assert (u_threshold.u_mul.b_i == (M + 1)'(margin_q[NormLatency-1]));
      Product : assert (threshold_o == threshold_t'(u_threshold.u_mul.product_o));
      Whole : assert (!Exact || threshold_o == whole);
      SeenLargest : cover (norm_q[NormLatency-1] == (wide_t'(1) << CWidth) - wide_t'(1));
      SeenNegative : cover (axis_i[0] < 0 && norm_q[0] != '0);
    end
  end

endmodule
