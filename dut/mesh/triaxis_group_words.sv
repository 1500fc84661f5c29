// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: for each row that comes, a group of A with its grown box, which groups of B it
// overlaps: Lanes a clock. Words in which some overlap leave with their mask; skipped_o and
// opened_o are the numbers of groups of B decided in this clock.
// Widths: see triaxis_mesh_pkg; a number of lanes has log2(Lanes)+1 bits. groups_b_i is not zero.
// Latency: 2 from a row to its first word.

module triaxis_group_words
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Groups = 512,
    parameter int unsigned Lanes = 8,
    localparam int unsigned GroupWidth = address_width(Groups),
    localparam int unsigned WordWidth = address_width(Groups / Lanes),
    localparam int unsigned CountWidth = $clog2(Groups) + 1,
    localparam int unsigned LaneCountWidth = $clog2(Lanes) + 1
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic drain_i,
    output logic idle_o,

    input logic [CountWidth-1:0] groups_b_i,

    input logic valid_i,
    output logic ready_o,
    input logic [GroupWidth-1:0] row_i,
    input logic signed [grown_width(W)-1:0] grown_i[2][3],

    output logic read_o,
    output logic [WordWidth-1:0] read_word_o,
    input logic signed [W-1:0] boxes_i[Lanes][2][3],

    output logic valid_o,
    input logic ready_i,
    output logic [GroupWidth-1:0] row_o,
    output logic [WordWidth-1:0] word_o,
    output logic [Lanes-1:0] mask_o,

    output logic [LaneCountWidth-1:0] skipped_o,
    output logic [LaneCountWidth-1:0] opened_o,
    output logic [Lanes-1:0] used_o  // boxes of groups, in this clock
);

  typedef logic [WordWidth-1:0] word_t;
  typedef logic [GroupWidth-1:0] group_t;
  typedef logic [CountWidth-1:0] count_t;
  typedef logic [Lanes-1:0] mask_t;
  typedef logic [LaneCountWidth-1:0] lane_count_t;

  logic enable, last, read_valid_q;
  word_t word_q, last_word, read_word_q;
  group_t read_row_q;
  logic signed [grown_width(W)-1:0] read_grown_q[2][3];
  mask_t lanes, overlap, decided;

  // A word is passed on once the last one is gone; until then all of this waits.
  assign enable = !valid_o || ready_i;
  assign last_word = word_t'((groups_b_i - count_t'(1)) >> $clog2(Lanes));
  assign last = word_q == last_word;
  assign ready_o = enable && last;
  assign read_o = valid_i && enable;
  assign read_word_o = word_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      word_q <= '0;
      read_valid_q <= 1'b0;
      mask_o <= '0;
    end else if (drain_i) begin
      word_q <= '0;
      read_valid_q <= 1'b0;
      mask_o <= '0;
    end else if (enable) begin
      if (valid_i) word_q <= last ? '0 : word_q + word_t'(1);
      read_valid_q <= valid_i;
      mask_o <= overlap & decided;
    end
  end

  always_ff @(posedge clk_i) begin
    if (enable) begin
      read_row_q <= row_i;
      read_word_q <= word_q;
      read_grown_q <= grown_i;
      row_o <= read_row_q;
      word_o <= read_word_q;
    end
  end

  triaxis_overlap #(
      .W(W),
      .Lanes(Lanes)
  ) u_overlap (
      .grown_i  (read_grown_q),
      .boxes_i,
      .overlap_o(overlap)
  );

  triaxis_lane_mask #(
      .Words(Groups / Lanes),
      .Lanes(Lanes)
  ) u_lanes (
      .count_i(groups_b_i),
      .word_i (read_word_q),
      .mask_o (lanes)
  );

  assign decided = (read_valid_q && enable) ? lanes : '0;
  assign used_o = decided;
  assign skipped_o = lane_count_t'($countones(decided & ~overlap));
  assign opened_o = lane_count_t'($countones(decided & overlap));
  assign valid_o = mask_o != '0;
  assign idle_o = !read_valid_q && !valid_o;

endmodule
