// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: for each pair of groups that comes, which triangles of the one, moved and grown,
// overlap which of the other by their boxes: one triangle of A against Lanes of B a clock. Words in
// which some overlap leave as (triangle of A, word of triangles of B, mask); skipped_o is the
// number of pairs that their boxes decide in this clock.
// Widths: see triaxis_mesh_pkg; a number of lanes has log2(Lanes)+1 bits.
// Latency: 3 from a pair of groups to its first word. A pair of groups takes a clock for each
// triangle of A and word of B that it has.

module triaxis_pair_boxes
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned GroupWidth = address_width(Depth / Group),
    localparam int unsigned WordWidth = address_width(Depth / Lanes),
    localparam int unsigned LaneCountWidth = $clog2(Lanes) + 1
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic drain_i,
    output logic idle_o,

    input logic [IndexWidth:0] count_a_i,
    input logic [IndexWidth:0] count_b_i,
    input logic signed [grown_width(W)-1:0] shift_i[2][3],

    input logic valid_i,
    output logic ready_o,
    input logic [GroupWidth-1:0] group_a_i,
    input logic [GroupWidth-1:0] group_b_i,

    output logic read_a_o,
    output logic [IndexWidth-1:0] index_a_o,
    input logic signed [W-1:0] box_a_i[2][3],
    output logic read_b_o,
    output logic [WordWidth-1:0] word_b_o,
    input logic signed [W-1:0] boxes_b_i[Lanes][2][3],

    output logic valid_o,
    input logic ready_i,
    output logic [IndexWidth-1:0] index_o,
    output logic [WordWidth-1:0] word_o,
    output logic [Lanes-1:0] mask_o,

    output logic [LaneCountWidth-1:0] skipped_o,
    output logic used_a_o,  // the boxes of triangles, in this clock
    output logic [Lanes-1:0] used_b_o
);

  localparam int unsigned WordsOfGroup = Group / Lanes;

  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;
  typedef logic [WordWidth-1:0] word_t;
  typedef logic [Lanes-1:0] mask_t;
  typedef logic [LaneCountWidth-1:0] lane_count_t;
  typedef logic [address_width(Group)-1:0] step_t;
  typedef logic [address_width(WordsOfGroup)-1:0] part_t;

  // --- The triangles of A and the words of B of a pair of groups -----------------------------------------

  logic enable, last_triangle, last_word;
  step_t  triangle_q;
  part_t  word_q;
  index_t index_a;
  word_t word_b, word_of_last;

  assign enable = !valid_o || ready_i;
  assign index_a = index_t'(group_a_i) * index_t'(Group) + index_t'(triangle_q);
  assign word_b = word_t'(group_b_i) * word_t'(WordsOfGroup) + word_t'(word_q);
  assign word_of_last = word_t'((count_b_i - count_t'(1)) >> $clog2(Lanes));
  assign last_word = word_q == part_t'(WordsOfGroup - 1) || word_b == word_of_last;
  assign last_triangle = triangle_q == step_t'(Group - 1) ||
      count_t'(index_a) + count_t'(1) == count_a_i;
  assign ready_o = enable && last_word && last_triangle;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      triangle_q <= '0;
      word_q <= '0;
    end else if (drain_i) begin
      triangle_q <= '0;
      word_q <= '0;
    end else if (valid_i && enable) begin
      word_q <= last_word ? '0 : word_q + part_t'(1);
      if (last_word) triangle_q <= last_triangle ? '0 : triangle_q + step_t'(1);
    end
  end

  // --- Read A, grow it while B is read, compare ----------------------------------------------------------

  logic read_valid_q, grown_valid_q;
  index_t read_index_q, grown_index_q;
  word_t read_word_q, grown_word_q;
  logic signed [grown_width(W)-1:0] grown[2][3];
  mask_t lanes, overlap, decided;

  assign read_a_o  = valid_i && enable;
  assign index_a_o = index_a;
  assign read_b_o  = read_valid_q && enable;
  assign word_b_o  = read_word_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_valid_q <= 1'b0;
      grown_valid_q <= 1'b0;
      mask_o <= '0;
    end else if (drain_i) begin
      read_valid_q <= 1'b0;
      grown_valid_q <= 1'b0;
      mask_o <= '0;
    end else if (enable) begin
      read_valid_q <= valid_i;
      grown_valid_q <= read_valid_q;
      mask_o <= overlap & decided;
    end
  end

  always_ff @(posedge clk_i) begin
    if (enable) begin
      read_index_q <= index_a;
      read_word_q <= word_b;
      grown_index_q <= read_index_q;
      grown_word_q <= read_word_q;
      index_o <= grown_index_q;
      word_o <= grown_word_q;
    end
  end

  triaxis_grow #(
      .W(W)
  ) u_grow (
      .clk_i,
      .enable_i(enable),
      .box_i(box_a_i),
      .shift_i,
      .grown_o(grown)
  );

  triaxis_overlap #(
      .W(W),
      .Lanes(Lanes)
  ) u_overlap (
      .grown_i  (grown),
      .boxes_i  (boxes_b_i),
      .overlap_o(overlap)
  );

  triaxis_lane_mask #(
      .Words(Depth / Lanes),
      .Lanes(Lanes)
  ) u_lanes (
      .count_i(count_b_i),
      .word_i (grown_word_q),
      .mask_o (lanes)
  );

  assign decided = (grown_valid_q && enable) ? lanes : '0;
  assign used_a_o = read_valid_q && enable;
  assign used_b_o = decided;
  assign skipped_o = lane_count_t'($countones(decided & ~overlap));
  assign valid_o = mask_o != '0;
  assign idle_o = !read_valid_q && !grown_valid_q && !valid_o;

endmodule
