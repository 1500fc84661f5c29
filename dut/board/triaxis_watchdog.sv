// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether the last kick was within the last Clocks clocks. Not alive from reset.
// Widths: the counter holds 0 .. Clocks.
// Latency: 1 clock from a kick to alive_o.

module triaxis_watchdog #(
    parameter int unsigned Clocks = 10_000_000
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic kick_i,
    input  logic forget_i,  // clears expired_o
    output logic alive_o,
    output logic expired_o  // it has run out since the last forget_i
);

  typedef logic [$clog2(Clocks+1)-1:0] count_t;
  count_t left_q;

  assign alive_o = left_q != '0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      left_q <= '0;
      expired_o <= 1'b0;
    end else begin
      if (forget_i) expired_o <= 1'b0;
      if (kick_i) begin
        left_q <= count_t'(Clocks);
      end else if (alive_o) begin
        left_q <= left_q - count_t'(1);
        if (left_q == count_t'(1)) expired_o <= 1'b1;
      end
    end
  end

endmodule
