// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The multiplier of narrow pieces, registers included, against the product of its operands, for every
// number of rows.

`include "triaxis_formal.svh"

module triaxis_narrow_mul_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned Wide = 6
) (
    input logic clk_i,
    input logic signed [Wide-1:0] wide_i,
    input logic signed [NarrowBits-1:0] narrow_i
);

  localparam int unsigned Latency = 2;

  `TRIAXIS_PAST(logic signed [Wide-1:0], wide_q, wide_i, Latency)
  `TRIAXIS_PAST(logic signed [NarrowBits-1:0], narrow_q, narrow_i, Latency)
  `TRIAXIS_FULL_AFTER(Latency)

  for (genvar n = 1; n <= NarrowBits; n++) begin : g_rows
    typedef logic signed [Wide+n-1:0] product_t;
    product_t product;

    triaxis_narrow_mul #(
        .WideWidth  (Wide),
        .NarrowWidth(n)
    ) u_mul (
        .clk_i,
        .wide_i,
        .narrow_i (narrow_i[n-1:0]),
        .product_o(product)
    );

    always_comb begin
      if (full) begin
        Product :
        assert (product ==
            product_t'(wide_q[Latency-1]) * product_t'(signed'(narrow_q[Latency-1][n-1:0])));
        SeenLargest : cover (product == product_t'(1) <<< (Wide + n - 2));
      end
    end
  end

endmodule
