// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a serial line (8 data bits, no parity, one stop bit) from bytes.
// Widths: the counter of thirds of a clock, see triaxis_uart_rx, holds 0 .. ClocksPerThreeBits - 1; 10 bits a byte.
// Latency: 1 clock from acceptance to the start bit; 10 * ClocksPerThreeBits / 3 clocks a byte, rounded
// down, and one until the next is accepted.

module triaxis_uart_tx #(
    parameter int unsigned ClocksPerThreeBits = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    output logic ready_o,
    input logic [7:0] data_i,
    output logic line_o
);

  typedef logic [$clog2(ClocksPerThreeBits)-1:0] count_t;
  localparam count_t Whole = count_t'(ClocksPerThreeBits - 3);

  // Start bit and data, lowest first. Ones come in behind: the stop bit and the idle line.
  logic [8:0] bits_q;
  logic [3:0] left_q;
  count_t count_q;

  assign ready_o = left_q == '0;
  assign line_o  = bits_q[0];

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      bits_q  <= '1;
      left_q  <= '0;
      count_q <= Whole;
    end else if (ready_o) begin
      if (valid_i) begin
        bits_q  <= {data_i, 1'b0};
        left_q  <= 4'd10;
        count_q <= Whole;
      end
    end else if (count_q < count_t'(3)) begin
      bits_q  <= {1'b1, bits_q[8:1]};
      left_q  <= left_q - 4'd1;
      count_q <= count_q + Whole;
    end else begin
      count_q <= count_q - count_t'(3);
    end
  end

endmodule
