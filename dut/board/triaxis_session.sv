// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whose the board is, and which command is next. The HELLO of a new session takes the board
// and sets the sequence number; each executed command counts it up. The same number and command again
// is a repeat. Session 0 is nobody's.
// Latency: 1 clock from take_i or executed_i.

module triaxis_session
  import triaxis_board_pkg::*;
(
    input logic clk_i,
    input logic rst_ni,
    input logic [31:0] session_i,
    input sequence_t sequence_number_i,
    input byte_t command_i,
    input logic take_i,
    input logic executed_i,
    output logic nobody_o,
    output logic mine_o,
    output logic next_o,
    output logic repeat_o,
    output sequence_t expected_o
);

  logic [31:0] session_q;
  sequence_t sequence_q;
  byte_t command_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) session_q <= '0;
    else if (take_i) session_q <= session_i;
  end

  // Nobody's, the board asks for no number.
  always_ff @(posedge clk_i) begin
    if (take_i || executed_i) begin
      sequence_q <= sequence_number_i;
      command_q  <= command_i;
    end
  end

  assign expected_o = sequence_q + 32'd1;
  assign nobody_o = session_i == '0;
  assign mine_o = !nobody_o && session_i == session_q;
  assign next_o = mine_o && sequence_number_i == expected_o;
  assign repeat_o = mine_o && sequence_number_i == sequence_q && command_i == command_q;

endmodule
