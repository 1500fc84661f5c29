// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// SLIP frames: of any bytes of a line with any framing errors, none is given but within a frame,
// from an END on and up to the first thing that is wrong; and what the encoder makes of a frame is
// given back byte by byte, with one end after it, and without an error.

`include "triaxis_formal.svh"

module triaxis_slip_rx_formal
  import triaxis_board_pkg::*;
(
    input logic  clk_i,
    input logic  rst_ni,
    // Any line.
    input logic  valid_i,
    input byte_t data_i,
    input logic  framing_error_i,
    // Frames for the encoder, and the pace of its line.
    input logic  frame_valid_i,
    input byte_t frame_data_i,
    input logic  frame_last_i,
    input logic  line_ready_i
);

  logic valid_o, end_o, error_o, frame_ready, line_valid, back_valid, back_end, back_error;
  byte_t data_o, line_data, back_data;
  // The encoder takes a byte; its line does, and it is an END.
  logic taken, sent, sends_end;
  assign taken = frame_valid_i && frame_ready;
  assign sent = line_valid && line_ready_i;
  assign sends_end = sent && line_data == SlipEnd;

  triaxis_slip_rx u_rx (.*);
  triaxis_slip_tx u_tx (
      .clk_i,
      .rst_ni,
      .valid_i(frame_valid_i),
      .ready_o(frame_ready),
      .data_i (frame_data_i),
      .last_i (frame_last_i),
      .valid_o(line_valid),
      .ready_i(line_ready_i),
      .data_o (line_data)
  );
  triaxis_slip_rx u_back (
      .clk_i,
      .rst_ni,
      .valid_i(sent),
      .data_i(line_data),
      .framing_error_i(1'b0),
      .valid_o(back_valid),
      .data_o(back_data),
      .end_o(back_end),
      .error_o(back_error)
  );

  `TRIAXIS_RESET_FIRST

  // The last two bytes of the line, and since when they count: an END that is no other's second
  // byte.
  logic byte_q, framing_q, in_frame_q, was_in_frame_q, escape_q, was_escape_q;
  byte_t last_q;
  logic stays_q, stays_last_q, taken_q, ended_q, closed_q;
  byte_t stays_data_q, taken_data_q;
  // Of the encoder: its line's END before a frame was sent, the one after it is due.
  logic open_q, closing_q, bad_escape;
  assign bad_escape = escape_q && !(data_i inside {SlipEscEnd, SlipEscEsc});
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {byte_q, framing_q, in_frame_q, was_in_frame_q, escape_q, was_escape_q} <= '0;
      {stays_q, taken_q, ended_q, closed_q, open_q, closing_q} <= '0;
    end else begin
      byte_q <= valid_i && !framing_error_i;
      framing_q <= framing_error_i;
      was_in_frame_q <= in_frame_q;
      was_escape_q <= escape_q;
      if (framing_error_i) {in_frame_q, escape_q} <= '0;
      else if (valid_i) begin
        in_frame_q <= data_i == SlipEnd || (in_frame_q && !bad_escape);
        escape_q   <= in_frame_q && !escape_q && data_i == SlipEsc;
      end
      stays_q  <= frame_valid_i && !frame_ready;
      taken_q  <= taken;
      ended_q  <= sends_end;
      closed_q <= sent && closing_q;
      if (sent) open_q <= !closing_q;
      closing_q <= taken ? frame_last_i : closing_q && !sent;
    end
  end
  always_ff @(posedge clk_i) begin
    last_q <= data_i;
    {stays_data_q, stays_last_q} <= {frame_data_i, frame_last_i};
    taken_data_q <= frame_data_i;
  end

  always_comb begin
    FrameStays :
    assume (!stays_q || (frame_valid_i &&
            {frame_data_i, frame_last_i} == {stays_data_q, stays_last_q}));
    if (rst_ni) begin
      // Any line.
      OneAtATime : assert (32'(valid_o) + 32'(end_o) + 32'(error_o) <= 1);
      OfALineByte : assert (!(valid_o || end_o) || byte_q);
      InAFrame : assert (!(valid_o || end_o) || was_in_frame_q);
      EndIsEnd : assert (end_o == (byte_q && was_in_frame_q && !was_escape_q && last_q == SlipEnd));
      NoEndInside : assert (!valid_o || last_q != SlipEnd);
      Plain :
      assert (!byte_q || !was_in_frame_q || was_escape_q || last_q inside {SlipEnd, SlipEsc} ||
              (valid_o && data_o == last_q));
      Escaped :
      assert (!byte_q || !was_escape_q || (last_q == SlipEscEnd && valid_o && data_o == SlipEnd) ||
              (last_q == SlipEscEsc && valid_o && data_o == SlipEsc) || error_o);
      NoEscape : assert (!valid_o || was_escape_q || last_q != SlipEsc);
      ErrorsTold :
      assert (error_o == (framing_q || (byte_q && was_escape_q &&
              !(last_q inside {SlipEscEnd, SlipEscEsc}))));
      // What was sent comes back.
      Back : assert (back_valid == taken_q && (!taken_q || back_data == taken_data_q));
      BackWhole : assert (!back_error);
      BackEnds : assert ((!back_end || ended_q) && (!closed_q || back_end));
      EndBefore : assert (!(sent && !open_q) || sends_end);
      EndAfter : assert (!(sent && closing_q) || sends_end);
      NoOtherEnd : assert (!sends_end || !open_q || closing_q);
      BytesBetween : assert (!taken || (open_q && !closing_q));
      SeenEscaped : cover (back_valid && back_data == SlipEnd);
      SeenEnd : cover (back_end && closed_q);
      SeenAfterError : cover (end_o && !was_escape_q && u_rx.state_q == 2'd1);
      SeenBadEscape : cover (error_o && was_escape_q);
      // What makes it inductive.
      assert (!escape_q || in_frame_q);
      assert (u_rx.state_q == (escape_q ? 2'd2 : in_frame_q ? 2'd1 : 2'd0));
      assert ((u_tx.state_q == 2'd2) == (u_back.state_q == 2'd2));
      assert (u_tx.state_q != 2'd2 || (stays_q && stays_data_q inside {SlipEnd, SlipEsc}));
      assert (u_tx.state_q == 2'd0 || u_back.state_q != 2'd0);
      assert (open_q == (u_tx.state_q != 2'd0) && closing_q == (u_tx.state_q == 2'd3));
      assert (u_back.state_q != 2'd3);
    end
  end

endmodule
