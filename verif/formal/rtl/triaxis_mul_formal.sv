// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The multiplier in the ways in which it is split, for multiplier ports of 4 and 3 bits instead of 25
// and 18: whole; the first operand in three pieces; both in two; the same with the operands swapped.

`include "triaxis_formal.svh"

// One multiplier, registers included, against the product of its operands.
module triaxis_mul_check
  import triaxis_pkg::*;
#(
    parameter int unsigned AWidth = 5,
    parameter int unsigned BWidth = 5
) (
    input logic clk_i,
    input logic signed [AWidth-1:0] a_i,
    input logic signed [BWidth-1:0] b_i
);

  localparam int unsigned Latency = mul_latency(AWidth, BWidth);
  typedef logic signed [AWidth+BWidth-1:0] product_t;

  product_t product_o;

  triaxis_mul #(
      .AWidth(AWidth),
      .BWidth(BWidth)
  ) u_mul (
      .*
  );

  `TRIAXIS_PAST(logic signed [AWidth-1:0], a_q, a_i, Latency)
  `TRIAXIS_PAST(logic signed [BWidth-1:0], b_q, b_i, Latency)
  `TRIAXIS_FULL_AFTER(Latency)

  always_comb begin
    if (full) begin
      Product : assert (product_o == product_t'(a_q[Latency-1]) * product_t'(b_q[Latency-1]));
      SeenLargest : cover (product_o == product_t'(1) <<< (AWidth + BWidth - 2));
    end
  end

endmodule

module triaxis_mul_formal (
    input logic clk_i,
    input logic signed [7:0] a_i,
    input logic signed [6:0] b_i
);

  triaxis_mul_check #(
      .AWidth(4),
      .BWidth(3)
  ) u_whole (
      .clk_i,
      .a_i(a_i[3:0]),
      .b_i(b_i[2:0])
  );

  triaxis_mul_check #(
      .AWidth(8),
      .BWidth(3)
  ) u_three (
      .clk_i,
      .a_i,
      .b_i(b_i[2:0])
  );

  triaxis_mul_check #(
      .AWidth(7),
      .BWidth(5)
  ) u_four (
      .clk_i,
      .a_i(a_i[6:0]),
      .b_i(b_i[4:0])
  );

  triaxis_mul_check #(
      .AWidth(5),
      .BWidth(7)
  ) u_swapped (
      .clk_i,
      .a_i(a_i[4:0]),
      .b_i
  );

endmodule
