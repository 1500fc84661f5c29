// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the two displays of four digits: on the left a word, on the right the near pairs of the
// last run in decimal, dashes above 9,999. The word, the first that fits: Go, run (a run is going
// on), Err (something went wrong since the last HELLO or RUN), StoP.
// Widths: the scan counter holds 0 .. DigitClocks - 1.
// Latency: each digit is lit DigitClocks clocks in turn: at 12,500 all eight every millisecond.

module triaxis_display #(
    parameter int unsigned DigitClocks = 12_500  // at least 2
) (
    input logic clk_i,
    input logic rst_ni,
    input logic go_i,
    input logic running_i,
    input logic error_i,
    input logic [31:0] near_i,
    output logic [7:0] seg_no,  // bit 0 segment a .. bit 6 segment g, bit 7 the point; low is lit
    output logic [7:0] an_no  // bit 0 the rightmost digit; low is lit
);

  typedef logic [6:0] segments_t;  // g .. a, high is lit
  typedef logic [3:0][6:0] word_t;
  typedef logic [$clog2(DigitClocks)-1:0] count_t;

  localparam segments_t Blank = 7'h00;
  localparam segments_t Dash = 7'h40;
  localparam word_t WordGo = {Blank, Blank, 7'h3D, 7'h5C};
  localparam word_t WordRun = {Blank, 7'h50, 7'h1C, 7'h54};
  localparam word_t WordErr = {Blank, 7'h79, 7'h50, 7'h50};
  localparam word_t WordStop = {7'h6D, 7'h78, 7'h5C, 7'h73};
  localparam logic [15:0][6:0] Numerals = {
    {6{Dash}}, 7'h6F, 7'h7F, 7'h07, 7'h7D, 7'h6D, 7'h66, 7'h4F, 7'h5B, 7'h06, 7'h3F
  };
  localparam logic [31:0] Shown = 32'd9_999;

  logic [3:0][3:0] digits;
  triaxis_decimal u_decimal (
      .clk_i,
      .number_i(near_i[13:0]),
      .digits_o(digits)
  );

  logic [7:0][6:0] shown;
  always_comb begin
    if (go_i) shown[7:4] = WordGo;
    else if (running_i) shown[7:4] = WordRun;
    else if (error_i) shown[7:4] = WordErr;
    else shown[7:4] = WordStop;
    for (int unsigned i = 0; i < 4; i++) shown[i] = near_i > Shown ? Dash : Numerals[digits[i]];
  end

  count_t count_q;
  logic [2:0] digit_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      digit_q <= '0;
      an_no   <= '1;
    end else begin
      count_q <= count_q == '0 ? count_t'(DigitClocks - 1) : count_q - count_t'(1);
      if (count_q == '0) digit_q <= digit_q + 3'd1;
      an_no <= ~(8'd1 << digit_q);
    end
  end

  // In reset no digit is lit.
  always_ff @(posedge clk_i) seg_no <= {1'b1, ~shown[digit_q]};

endmodule
