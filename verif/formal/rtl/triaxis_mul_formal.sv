// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The multiplier in the ways in which it is split, for multiplier ports of 4 and 3 bits instead of 25
// and 18: whole; the first operand in three pieces; both in two; the same with the operands swapped.

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
