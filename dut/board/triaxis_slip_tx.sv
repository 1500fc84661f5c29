// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: SLIP frames (RFC 1055) from bytes, with an END before and after each.
// Latency: 0 clocks; an escaped byte, and the first and last of a frame, take two or three bytes of
// the line.

module triaxis_slip_tx
  import triaxis_board_pkg::*;
(
    input  logic  clk_i,
    input  logic  rst_ni,
    input  logic  valid_i,
    output logic  ready_o,
    input  byte_t data_i,
    input  logic  last_i,
    output logic  valid_o,
    input  logic  ready_i,
    output byte_t data_o
);

  typedef enum logic [1:0] {
    First,
    Plain,
    Escaped,
    Last
  } state_e;

  state_e state_q;
  logic   special;
  assign special = data_i == SlipEnd || data_i == SlipEsc;

  // A byte is taken with the last byte of the line that it needs.
  assign valid_o = valid_i || state_q == Last;
  assign ready_o = ready_i && ((state_q == Plain && !special) || state_q == Escaped);

  always_comb begin
    case (state_q)
      Plain:   data_o = special ? SlipEsc : data_i;
      Escaped: data_o = data_i == SlipEnd ? SlipEscEnd : SlipEscEsc;
      default: data_o = SlipEnd;
    endcase
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= First;
    end else if (valid_o && ready_i) begin
      case (state_q)
        First: state_q <= Plain;
        Last:  state_q <= First;
        default: begin
          if (!ready_o) state_q <= Escaped;
          else state_q <= last_i ? Last : Plain;
        end
      endcase
    end
  end

endmodule
