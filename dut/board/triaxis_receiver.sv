// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the frames on the serial line from the host: line, bytes, SLIP, CRC.
// Latency: see the parts.

module triaxis_receiver
  import triaxis_board_pkg::*;
#(
    parameter int unsigned ClocksPerThreeBits = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic line_i,
    output logic full_o,
    output logic [$clog2(MaxFrameBytes)-1:0] length_o,
    input logic [$clog2(MaxFrameBytes)-1:0] address_i,
    output byte_t data_o,
    input logic release_i,
    input logic trial_i,
    output logic broken_o,
    output logic error_o
);

  logic line_valid, framing_error, slip_valid, slip_end, slip_error;
  byte_t line_data, slip_data;

  triaxis_uart_rx #(
      .ClocksPerThreeBits(ClocksPerThreeBits)
  ) u_uart (
      .clk_i,
      .rst_ni,
      .line_i,
      .valid_o(line_valid),
      .data_o(line_data),
      .framing_error_o(framing_error)
  );

  triaxis_slip_rx u_slip (
      .clk_i,
      .rst_ni,
      .valid_i(line_valid),
      .data_i(line_data),
      .framing_error_i(framing_error),
      .valid_o(slip_valid),
      .data_o(slip_data),
      .end_o(slip_end),
      .error_o(slip_error)
  );

  triaxis_frame_rx u_frame (
      .clk_i,
      .rst_ni,
      .valid_i(slip_valid),
      .data_i (slip_data),
      .end_i  (slip_end),
      .error_i(slip_error),
      .full_o,
      .length_o,
      .address_i,
      .data_o,
      .release_i,
      .trial_i,
      .broken_o,
      .error_o
  );

endmodule
