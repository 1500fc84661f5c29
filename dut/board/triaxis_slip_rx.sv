// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the bytes of SLIP frames (RFC 1055) and where they end. What is wrong with a frame is
// told once, and the rest of it up to the next END is passed over; so is all before the first END.
// A framing error of the line is told whether or not a frame is under way: the line cannot be
// trusted.
// Latency: 1 clock.

module triaxis_slip_rx
  import triaxis_board_pkg::*;
(
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    input byte_t data_i,
    input logic framing_error_i,
    output logic valid_o,
    output byte_t data_o,
    output logic end_o,
    output logic error_o  // the frame under way is dropped
);

  typedef enum logic [1:0] {
    Hunt,
    Plain,
    Escaped
  } state_e;

  // What the last byte of the line was.
  typedef enum logic [1:0] {
    Nothing,
    Byte,
    End,
    Error
  } seen_e;

  state_e state_q;
  seen_e  seen_q;
  logic is_end, is_escape, escapes, unescaped_end, unescaped_escape;
  assign is_end = data_i == SlipEnd;
  assign is_escape = data_i == SlipEsc;
  assign unescaped_end = data_i == SlipEscEnd;
  assign unescaped_escape = data_i == SlipEscEsc;
  assign escapes = unescaped_end || unescaped_escape;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= Hunt;
      seen_q  <= Nothing;
    end else begin
      seen_q <= Nothing;
      if (framing_error_i) begin
        seen_q  <= Error;
        state_q <= Hunt;
      end else if (valid_i) begin
        case (state_q)
          Plain: begin
            if (is_end) seen_q <= End;
            else if (is_escape) state_q <= Escaped;
            else seen_q <= Byte;
          end
          Escaped: begin
            seen_q  <= escapes ? Byte : Error;
            // An END after an ESC is wrong, and yet ends the frame.
            state_q <= (escapes || is_end) ? Plain : Hunt;
          end
          default: if (is_end) state_q <= Plain;
        endcase
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (state_q == Escaped) data_o <= unescaped_end ? SlipEnd : SlipEsc;
    else data_o <= data_i;
  end

  assign valid_o = seen_q == Byte;
  assign end_o   = seen_q == End;
  assign error_o = seen_q == Error;

endmodule
