// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a number below 10,000 as four decimal digits, over and over.
// Widths: 9,999 needs 14 bits.
// Latency: at most 32 clocks, from whatever state: it needs no reset.

module triaxis_decimal (
    input logic clk_i,
    input logic [13:0] number_i,
    output logic [3:0][3:0] digits_o
);

  localparam logic [3:0] Last = 4'd14;

  logic [3:0] step_q;
  logic [13:0] number_q;
  logic [3:0][3:0] digits_q;
  logic [2:0][3:0] adjusted;

  // Double dabble: a digit of 5 or more carries when it is doubled; the highest is at most 4 then.
  for (genvar i = 0; i < 3; i++) begin : g_digit
    assign adjusted[i] = digits_q[i] > 4'd4 ? digits_q[i] + 4'd3 : digits_q[i];
  end

  always_ff @(posedge clk_i) begin
    if (step_q == Last) begin
      step_q   <= '0;
      number_q <= number_i;
      digits_q <= '0;
      digits_o <= digits_q;
    end else begin
      step_q <= step_q + 4'd1;
      {digits_q, number_q[13:1]} <= {digits_q[3][2:0], adjusted, number_q};
    end
  end

endmodule
