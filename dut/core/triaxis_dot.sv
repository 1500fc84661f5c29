// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the triple product cross_i . diff_i, where cross_i is a cross product of two
// differences and diff_i a third one, all three from the same vertex.
// Widths: six times the volume of a tetrahedron inside a cube of side L = 2^W - 1, so
// |.| <= 2 L^3: 3W+2 bits signed.
// Latency: dot_latency(W): products, then the sum of three.

module triaxis_dot
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [cross_width(W)-1:0] cross_i[3],
    input logic signed [diff_width(W)-1:0] diff_i[3],
    output logic signed [det_width(W)-1:0] dot_o
);

  localparam int unsigned DetWidth = det_width(W);

  // One product is at most L^2 * L: it fits 3W+1 bits, and cross + diff widths are 3W+2.
  logic signed [DetWidth-1:0] product[3];

  for (genvar k = 0; k < 3; k++) begin : g_component
    triaxis_mul #(
        .AWidth(cross_width(W)),
        .BWidth(diff_width(W)),
        .Comb  (Comb)
    ) u_mul (
        .clk_i,
        .a_i(cross_i[k]),
        .b_i(diff_i[k]),
        .product_o(product[k])
    );
  end

  triaxis_sum #(
      .Terms(3),
      .Width(DetWidth),
      .Comb (Comb)
  ) u_sum (
      .clk_i,
      .terms_i(product),
      .sum_o  (dot_o)
  );

endmodule
