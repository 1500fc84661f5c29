// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the bytes on a serial line (8 data bits, no parity, one stop bit). A low level that is
// gone by the middle of the start bit is noise and starts nothing. A byte without a stop bit is
// given with a framing error, once for however long the line stays low.
// Widths: the clock counter holds 0 .. ClocksPerBit - 1.
// Latency: 2 clocks of the synchroniser, which a reset lasts at least: it needs none itself; a byte is
// given in the middle of its stop bit.

module triaxis_uart_rx #(
    parameter int unsigned ClocksPerBit = 25  // at least 4
) (
    input logic clk_i,
    input logic rst_ni,
    input logic line_i,
    output logic valid_o,
    output logic [7:0] data_o,
    output logic framing_error_o
);

  if (ClocksPerBit < 4) begin : g_bad_rate
    $fatal(1, "ClocksPerBit must be at least 4");
  end

  localparam int unsigned CountWidth = $clog2(ClocksPerBit);
  typedef logic [CountWidth-1:0] count_t;
  localparam count_t Whole = count_t'(ClocksPerBit - 1);
  localparam count_t Half = count_t'(ClocksPerBit / 2 - 1);

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
  assign sample = count_q == '0;
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
    else count_q <= sample ? Whole : count_q - count_t'(1);
    if (sample) data_o <= {line, data_o[7:1]};
  end

endmodule
