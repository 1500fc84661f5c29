// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: margin * (|x| + |y| + |z|) of an axis: by how much its projections must lie apart. For the
// certifier, which shares nothing but the multiplier and rows of registers with what it checks.
// Widths: each component is at most 2 L^2 < 2^(2W+1), all absolutes together at most 4 L^2 < 2^(2W+2): 2W+2
// bits unsigned, one more signed; times a margin of M bits, 2W+2+M bits.
// Latency: reach_latency(W, M): absolutes, the sum of two, of three, product.

`include "triaxis_stage.svh"

module triaxis_reach
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 8,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [axis_width(W)-1:0] axis_i[3],
    input logic [M-1:0] margin_i,
    output logic [axis_width(W)+M-1:0] reach_o
);

  localparam int unsigned AbsWidth = axis_width(W) - 1;
  typedef logic [AbsWidth-1:0] abs_t;
  typedef logic [axis_width(W)-1:0] norm_t;
  typedef logic [M-1:0] margin_t;

  abs_t abs_d[3], abs_q[3], last_d, last_q;
  norm_t two_d, two_q, norm_d, norm_q;
  margin_t margin;
  logic signed [axis_width(W)+M+1:0] product;

  for (genvar k = 0; k < 3; k++) begin : g_component
    assign abs_d[k] = (axis_i[k] < 0) ? -axis_i[k][AbsWidth-1:0] : axis_i[k][AbsWidth-1:0];
  end
  `TRIAXIS_STAGE(abs_q, abs_d)

  assign two_d  = norm_t'(abs_q[0]) + norm_t'(abs_q[1]);
  assign last_d = abs_q[2];
  `TRIAXIS_STAGE(two_q, two_d)
  `TRIAXIS_STAGE(last_q, last_d)

  assign norm_d = two_q + norm_t'(last_q);
  `TRIAXIS_STAGE(norm_q, norm_d)

  triaxis_delay #(
      .T(margin_t),
      .Cycles(Comb ? 0 : 3)
  ) u_margin (
      .clk_i,
      .d_i(margin_i),
      .q_o(margin)
  );

  triaxis_mul #(
      .AWidth(axis_width(W) + 1),
      .BWidth(M + 1),
      .Comb  (Comb)
  ) u_mul (
      .clk_i,
      .a_i({1'b0, norm_q}),
      .b_i({1'b0, margin}),
      .product_o(product)
  );

  logic unused_sign;
  assign unused_sign = ^product[axis_width(W)+M+1:axis_width(W)+M];
  assign reach_o = product[axis_width(W)+M-1:0];

endmodule
