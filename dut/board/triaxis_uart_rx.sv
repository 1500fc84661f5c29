// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the bytes on a serial line (8 data bits, no parity, one stop bit). A low level that is
// gone by the middle of the start bit is noise and starts nothing. A byte without a stop bit is
// given with a framing error, once for however long the line stays low.
// The counter runs in thirds of a clock, so that what a bit has beside whole clocks is not lost: the middle of bit
// i, the start bit's i = 0, is (2i + 1) * ClocksPerThreeBits / 6 clocks, rounded down, after the line's fall was seen.
// Widths: a sample leaves at most 2 thirds, so the counter holds 0 .. ClocksPerThreeBits - 1.
// Latency: 2 clocks of the synchroniser, which a reset lasts at least: it needs none itself; a byte is
// given in the middle of its stop bit.

module triaxis_uart_rx #(
    parameter int unsigned ClocksPerThreeBits = 25  // at least 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic line_i,
    output logic valid_o,
    output logic [7:0] data_o,
    output logic framing_error_o
);

  if (ClocksPerThreeBits < 12) begin : g_bad_rate
    $fatal(1, "ClocksPerThreeBits must be at least 12");
  end

  localparam int unsigned CountWidth = $clog2(ClocksPerThreeBits);
  typedef logic [CountWidth-1:0] count_t;
  localparam count_t Whole = count_t'(ClocksPerThreeBits - 3);
  localparam count_t Half = count_t'(ClocksPerThreeBits / 2 - 3);

  typedef enum logic [2:0] {
    Idle,
    Start,
    Data,
    Stop,
    Rest
  } state_e;

  (* ASYNC_REG = "TRUE" *) logic [1:0] line_q;
  logic line;
  assign line = line_q[1];

  state_e state_q;
  count_t count_q;
  logic [2:0] bit_q;
  logic sample;
  assign sample = count_q < count_t'(3);
  assign valid_o = state_q == Stop && sample;
  assign framing_error_o = valid_o && !line;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= Idle;
      bit_q   <= '0;
    end else begin
      case (state_q)
        Idle:    if (!line) state_q <= Start;
        Start:   if (sample) state_q <= line ? Idle : Data;
        Data:
        if (sample) begin
          bit_q <= bit_q + 3'd1;
          if (bit_q == 3'd7) state_q <= Stop;
        end
        Stop:
        if (sample) state_q <= Rest;
        default: if (line) state_q <= Idle;
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    line_q <= {line_q[0], line_i};
    if (state_q == Idle) count_q <= Half;
    else count_q <= sample ? count_q + Whole : count_q - count_t'(3);
    if (sample) data_o <= {line, data_o[7:1]};
  end

endmodule
