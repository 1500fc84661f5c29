// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the serial line to the host, from replies: bytes, CRC, SLIP, line.
// Latency: see the parts.

module triaxis_transmitter
  import triaxis_board_pkg::*;
#(
    parameter int unsigned IndexWidth = 12,
    parameter int unsigned ClocksPerThreeBits = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    output logic ready_o,
    input reply_t reply_i,
    input body_bytes_t body_bytes_i,
    input near_pairs_t pairs_i,
    input logic [31:0] first_pair_i,
    output logic [31:0] ring_number_o,
    input logic [2*IndexWidth-1:0] ring_data_i,
    output logic line_o
);

  logic reply_valid, reply_ready, reply_last, slip_valid, slip_ready;
  byte_t reply_data, slip_data;

  triaxis_reply #(
      .IndexWidth(IndexWidth)
  ) u_reply (
      .clk_i,
      .rst_ni,
      .valid_i,
      .ready_o,
      .reply_i,
      .body_bytes_i,
      .pairs_i,
      .first_pair_i,
      .ring_number_o,
      .ring_data_i,
      .valid_o(reply_valid),
      .taken_i(reply_ready),
      .data_o (reply_data),
      .last_o (reply_last)
  );

  triaxis_slip_tx u_slip (
      .clk_i,
      .rst_ni,
      .valid_i(reply_valid),
      .ready_o(reply_ready),
      .data_i (reply_data),
      .last_i (reply_last),
      .valid_o(slip_valid),
      .ready_i(slip_ready),
      .data_o (slip_data)
  );

  triaxis_uart_tx #(
      .ClocksPerThreeBits(ClocksPerThreeBits)
  ) u_uart (
      .clk_i,
      .rst_ni,
      .valid_i(slip_valid),
      .ready_o(slip_ready),
      .data_i (slip_data),
      .line_o
  );

endmodule
