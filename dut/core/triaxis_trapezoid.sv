// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: (x + x') (y' - y), twice the signed area between the way from point (x, y) to point
// (x', y') and the y axis. The other way round it is its negative, and along the sides of a triangle
// it adds up to twice that triangle's area (docs/theory.md, section 4).
// Widths: x + x' lies in -2^W .. 2^W - 2 and y' - y in -L .. L: W+1 bits signed; their product, at
// most 2^W L < 2^(2W), in axis_width(W).
// Latency: trapezoid_latency(W): sum and difference, then the product.

`include "triaxis_stage.svh"

module triaxis_trapezoid
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] from_i[2],
    input logic signed [W-1:0] to_i[2],
    output logic signed [axis_width(W)-1:0] area_o
);

  typedef logic signed [diff_width(W)-1:0] diff_t;

  diff_t sum_d, sum_q, rise_d, rise_q;

  assign sum_d  = diff_t'(from_i[0]) + diff_t'(to_i[0]);
  assign rise_d = diff_t'(to_i[1]) - diff_t'(from_i[1]);
  `TRIAXIS_STAGE(sum_q, sum_d)
  `TRIAXIS_STAGE(rise_q, rise_d)

  triaxis_mul #(
      .AWidth(diff_width(W)),
      .BWidth(diff_width(W)),
      .Comb  (Comb)
  ) u_mul (
      .clk_i,
      .a_i(sum_q),
      .b_i(rise_q),
      .product_o(area_o)
  );

endmodule
