// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Frames from any bytes, ends and errors: what is handed out is what came between two ends, whole,
// with its own CRC-32 at its end, and stays until it is released; whatever else came is told as an
// error. One byte of a frame, of any number, chosen once by the prover, is followed. The CRC is
// that of the definition: the remainder of the division by the polynomial, highest power first.
// A byte that is shown is broken where one bit of it, or of its parity, is inverted, or that is tried; else it
// is not. The bits that are inverted are free, at each clock: see the edit of the proof.

`include "triaxis_formal.svh"

module triaxis_frame_rx_formal
  import triaxis_board_pkg::*;
(
    input logic  clk_i,
    input logic  rst_ni,
    input logic  valid_i,
    input byte_t data_i,
    input logic  end_i,
    input logic  error_i,
    input logic  release_i,
    input logic  trial_i
);

  localparam logic [31:0] Polynomial = 32'h04C1_1DB7;
  typedef logic [31:0] remainder_t;
  typedef logic [8:0] count_t;

  logic full_o, broken_o, error_o;
  byte_t length_o;
  byte_t data_o, place_q;

  triaxis_frame_rx u_frame (
      .address_i(place_q),
      .*
  );

  `TRIAXIS_RESET_FIRST

  // The lowest bit of a byte is sent first, so belongs to the highest power.
  function automatic remainder_t divided(remainder_t remainder, byte_t data);
    for (int i = 0; i < 8; i++)
    remainder = {remainder[30:0], 1'b0} ^ (remainder[31] ^ data[i] ? Polynomial : '0);
    return remainder;
  endfunction

  function automatic remainder_t mirrored(remainder_t value);
    for (int i = 0; i < 32; i++) mirrored[i] = value[31-i];
  endfunction

  // Of the frame that comes: its bytes, the remainders after it and after all but its last one to
  // four, these four, the byte that is followed; whether any of it came while another frame was
  // held.
  count_t count_q;
  remainder_t remainder_q[5];
  byte_t last_q[4], followed_q;
  logic late_q, told_q;
  always_ff @(posedge clk_i) place_q <= place_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      remainder_q <= '{default: '1};
      {late_q, told_q} <= '0;
    end else if (end_i || error_i) begin
      count_q <= '0;
      remainder_q <= '{default: '1};
      {late_q, told_q} <= '0;
    end else if (valid_i) begin
      if (count_q <= 9'(MaxFrameBytes)) count_q <= count_q + 9'd1;
      remainder_q[0] <= divided(remainder_q[0], data_i);
      for (int i = 1; i < 5; i++) remainder_q[i] <= remainder_q[i-1];
      late_q <= late_q || full_o;
      told_q <= told_q || full_o || count_q >= 9'(MaxFrameBytes);
    end
  end
  always_ff @(posedge clk_i) begin
    if (valid_i && !end_i && !error_i) begin
      last_q[0] <= data_i;
      for (int i = 1; i < 4; i++) last_q[i] <= last_q[i-1];
      if (count_q == 9'(place_q)) followed_q <= data_i;
    end
  end

  // The frame's last four bytes are the complement of the remainder before them.
  logic own_crc, whole, held_q, released_q, ended_q, error_q, whole_q, told_before_q;
  byte_t  held_byte_q;
  count_t held_count_q;
  assign own_crc = ~mirrored(remainder_q[4]) == {last_q[0], last_q[1], last_q[2], last_q[3]};
  assign whole = count_q >= 9'(HeaderBytes + CrcBytes) && count_q <= 9'(MaxFrameBytes) && !late_q &&
      own_crc;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {held_q, released_q, ended_q, error_q, whole_q, told_before_q} <= '0;
    else begin
      held_q <= full_o;
      released_q <= release_i;
      ended_q <= end_i && count_q != '0;
      error_q <= error_i;
      whole_q <= end_i && whole;
      told_before_q <= told_q;
    end
  end
  always_ff @(posedge clk_i) begin
    if (end_i && whole) begin
      held_byte_q  <= followed_q;
      held_count_q <= count_q;
    end
  end

  logic shown;
  logic [8:0] inverted;
  assign shown = full_o && 9'(place_q) < held_count_q;
  assign inverted = u_frame.free_inverted;

  always_comb begin
    // The line gives one of them at a time: shown by `board_slip`.
    OneAtATime : assume (32'(valid_i) + 32'(end_i) + 32'(error_i) <= 1);
    if (rst_ni) begin
      HandedOut : assert (!full_o || held_q || whole_q);
      EachWhole : assert (!whole_q || full_o);
      Stays : assert (!held_q || full_o || released_q);
      Leaves : assert (!held_q || !released_q || !full_o);
      AsItCame :
      assert (!full_o || (length_o == 8'(held_count_q) &&
              (!shown || data_o == (held_byte_q ^ inverted[7:0]))));
      Broken : assert (broken_o == (shown && (trial_i || ^inverted)));
      Told : assert (!ended_q || whole_q || told_before_q || error_o);
      ErrorsTold : assert (!error_q || error_o);
      SeenFull : cover (whole_q && 9'(place_q) == held_count_q - 9'd1);
      SeenBroken : cover (broken_o && !trial_i && data_o != held_byte_q);
      SeenLate : cover (late_q && error_o);
      SeenBadCrc : cover (ended_q && !whole_q && !told_before_q && count_q == '0);
      // What makes it inductive.
      for (int i = 0; i < 4; i++)
      assert (9'(i) >= count_q || remainder_q[i] == divided(remainder_q[i+1], last_q[i]));
      assert (count_q <= 9'(MaxFrameBytes + 1));
      assert (told_q == (late_q || count_q > 9'(MaxFrameBytes)));
      assert (u_frame.skip_q == told_q);
      assert (!late_q || count_q != '0);
      assert (told_q || u_frame.count_q == count_q);
      assert (u_frame.count_q <= 9'(MaxFrameBytes));
      assert (told_q || u_frame.crc == mirrored(remainder_q[0]));
      assert (told_q || 9'(place_q) >= count_q || full_o ||
              u_frame.memory_q[place_q] == {^followed_q, followed_q});
      assert (!shown || u_frame.memory_q[place_q] == {^held_byte_q, held_byte_q});
      assert (!full_o || told_q || count_q == '0);
      assert (!full_o || held_count_q inside {[9'(HeaderBytes + CrcBytes) : 9'(MaxFrameBytes)]});
    end
  end

endmodule
