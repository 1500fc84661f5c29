// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
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

  logic signed [AWidth-1:0] a_q[Latency];
  logic signed [BWidth-1:0] b_q[Latency];
  logic [3:0] clocks_q = '0;
  always_ff @(posedge clk_i) begin
    a_q[0] <= a_i;
    b_q[0] <= b_i;
    for (int i = 1; i < int'(Latency); i++) begin
      a_q[i] <= a_q[i-1];
      b_q[i] <= b_q[i-1];
    end
    if (clocks_q != 4'(Latency)) clocks_q <= clocks_q + 4'd1;
  end

  always_comb begin
    if (clocks_q == 4'(Latency)) begin
      Product : assert (product_o == product_t'(a_q[Latency-1]) * product_t'(b_q[Latency-1]));
      SeenLargest : cover (product_o == product_t'(1) <<< (AWidth + BWidth - 2));
    end
  end

endmodule
