// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the cross product a_i x b_i of two differences from a common vertex.
// Widths: differences W+1 bits; each component is twice the area of a triangle inside a square of
// side L = 2^W - 1, so |.| <= L^2: 2W+1 bits signed.
// Latency: cross_latency(W): products, then one subtraction.

`include "triaxis_stage.svh"

module triaxis_cross
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [diff_width(W)-1:0] a_i[3],
    input logic signed [diff_width(W)-1:0] b_i[3],
    output logic signed [cross_width(W)-1:0] cross_o[3]
);

  localparam int unsigned DiffWidth = diff_width(W);
  localparam int unsigned CrossWidth = cross_width(W);

  logic signed [CrossWidth-1:0] cross_d[3];

  for (genvar k = 0; k < 3; k++) begin : g_component
    localparam int unsigned K1 = (k + 1) % 3;
    localparam int unsigned K2 = (k + 2) % 3;
    logic signed [2*DiffWidth-1:0] plus, minus;
    triaxis_mul #(
        .AWidth(DiffWidth),
        .BWidth(DiffWidth),
        .Comb  (Comb)
    ) u_plus (
        .clk_i,
        .a_i(a_i[K1]),
        .b_i(b_i[K2]),
        .product_o(plus)
    );
    triaxis_mul #(
        .AWidth(DiffWidth),
        .BWidth(DiffWidth),
        .Comb  (Comb)
    ) u_minus (
        .clk_i,
        .a_i(a_i[K2]),
        .b_i(b_i[K1]),
        .product_o(minus)
    );
    assign cross_d[k] = CrossWidth'(plus - minus);
  end

  `TRIAXIS_STAGE(cross_o, cross_d)

endmodule
