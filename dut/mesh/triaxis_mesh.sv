// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which triangles of mesh A, moved by a translation, come within a margin of which of
// mesh B. Both meshes are kept in memory; a run asks the exact core only about pairs that no box
// decides:
//   rows    the box of each group of A against the box of the whole of B
//   words   rows that overlap against the boxes of B's groups, Lanes a clock
//   boxes   pairs of groups that overlap: each triangle of A against Lanes triangles of B a clock
//   fetch   pairs that overlap: their vertices, one pair a clock
//   core    triaxis_core
// A pair is skipped only where a box axis separates it by more than the margin, so skipping
// changes no verdict. Streams:
//   s_axis_load   tuser {clear, mesh}: mesh 0 is A, 1 is B; clear empties it, otherwise tdata, nine
//                 coordinates, is appended. Not ready during a run.
//   s_axis_run    tdata {tz, ty, tx}, of W+1 bits each; tuser {mode, margin}, only the mode
//                 where M = 0
//   m_axis_near   {index in B, index in A}, in the order of the scan
//   m_axis_done   one summary a run, after its last near pair was taken. Its values stay until the
//                 next run is accepted; during a run the status is none. A reset clears them, and
//                 empties both meshes: a run of empty meshes is complete, and nothing in it is near.
// A complete run accounts for all pairs: skipped and opened pairs of groups are all there are, and
// the pairs within those opened are skipped by their boxes, or tested.
// Widths: see triaxis_mesh_pkg and triaxis_pkg; numbers of pairs 2 log2(Depth) + 1 bits.
// Latency: cycles_o tells; where nothing can be skipped, one clock a pair and some 50 more.

module triaxis_mesh
  import triaxis_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,  // coordinate bits, 8..32
    parameter int unsigned M = 16,  // margin bits, 0..W
    parameter int unsigned Depth = 4096,  // triangles a mesh holds, a power of two
    parameter int unsigned Group = 8,  // triangles in a group, a power of two
    parameter int unsigned Lanes = 8,  // boxes compared a clock, a power of two, at most Group
    parameter int unsigned CycleBits = 32,
    parameter bit EdgeBox = 1'b1,  // as in triaxis_core
    parameter bit Gating = 1'b1,  // as in triaxis_core
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned Groups = Depth / Group,
    localparam int unsigned GroupPairWidth = 2 * $clog2(Groups) + 1,
    localparam int unsigned PairCountWidth = 2 * IndexWidth + 1
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_load_tvalid_i,
    output logic s_axis_load_tready_o,
    input logic [9*W-1:0] s_axis_load_tdata_i,
    input logic [1:0] s_axis_load_tuser_i,
    output logic [IndexWidth:0] count_a_o,
    output logic [IndexWidth:0] count_b_o,
    output logic [1:0] overfull_o,

    input logic s_axis_run_tvalid_i,
    output logic s_axis_run_tready_o,
    input logic [3*move_width(W)-1:0] s_axis_run_tdata_i,
    input logic [M+1:0] s_axis_run_tuser_i,
    input logic abort_i,
    output logic busy_o,

    output logic m_axis_near_tvalid_o,
    input logic m_axis_near_tready_i,
    output logic [2*IndexWidth-1:0] m_axis_near_tdata_o,

    output logic m_axis_done_tvalid_o,
    input logic m_axis_done_tready_i,
    output status_e status_o,
    output logic [CycleBits-1:0] cycles_o,
    output logic [GroupPairWidth-1:0] group_pairs_skipped_o,
    output logic [GroupPairWidth-1:0] group_pairs_opened_o,
    output logic [PairCountWidth-1:0] pairs_skipped_o,
    output logic [PairCountWidth-1:0] tested_o,
    output logic [PairCountWidth-1:0] near_o
);

  localparam int unsigned GroupWidth = address_width(Groups);
  localparam int unsigned GroupWordWidth = address_width(Groups / Lanes);
  localparam int unsigned WordWidth = address_width(Depth / Lanes);
  localparam int unsigned LaneWidth = address_width(Lanes);
  localparam int unsigned LaneCountWidth = $clog2(Lanes) + 1;
  localparam int unsigned GroupCountWidth = $clog2(Groups) + 1;
  localparam int unsigned QueueDepth = 16;
  localparam int unsigned CoreWidth = 8 * ((18 * W + 7) / 8);
  // The core's queue, and two steps of fetching.
  localparam int unsigned InFlight = 2 ** $clog2(core_latency(W, M)) + 2;

  typedef logic signed [W-1:0] coord_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;
  typedef logic [GroupWidth-1:0] group_t;
  typedef logic [GroupCountWidth-1:0] group_count_t;
  typedef logic [GroupPairWidth-1:0] group_pair_count_t;
  typedef logic [PairCountWidth-1:0] pair_count_t;
  typedef struct packed {
    group_t a;
    group_t b;
  } group_pair_t;
  typedef struct packed {
    group_t row;
    logic [GroupWordWidth-1:0] word;
  } group_word_t;
  typedef struct packed {
    index_t index;
    logic [WordWidth-1:0] word;
  } pair_word_t;
  typedef struct packed {
    pair_word_t pairs;
    logic [Lanes-1:0] mask;
  } masked_pairs_t;

  if (Depth != 2 ** IndexWidth || Group != 2 ** $clog2(
          Group
      ) || Lanes != 2 ** $clog2(
          Lanes
      )) begin : g_bad_powers
    $fatal(1, "Depth, Group and Lanes must be powers of two");
  end
  if (Lanes > Group || Group * Lanes > Depth || Depth < 2 || Depth > 65536) begin : g_bad_sizes
    $fatal(1, "Lanes must be at most Group, Group * Lanes at most Depth, Depth 2..65536");
  end
  if (CycleBits < 2) begin : g_bad_cycles
    $fatal(1, "CycleBits must be at least 2");
  end

  // --- The meshes ---------------------------------------------------------------------------------------

  logic load, settled_a, settled_b, settled, empty_a, empty;
  logic [1:0] clear, push;
  coord_t object_a[2][3], object_b[2][3];
  logic row_read, word_read, box_a_read, box_b_read, triangle_read;
  group_t row_group;
  logic [GroupWordWidth-1:0] word_index;
  index_t box_a_index, fetch_a, fetch_b;
  logic [WordWidth-1:0] box_b_word;
  coord_t row_box[1][2][3], word_boxes[Lanes][2][3], box_a[1][2][3], boxes_b[Lanes][2][3];
  logic [9*W-1:0] triangle_a, triangle_b;

  // The meshes can be loaded where a run could start.
  assign s_axis_load_tready_o = s_axis_run_tready_o;
  assign load = s_axis_load_tvalid_i && s_axis_run_tready_o;
  for (genvar mesh = 0; mesh < 2; mesh++) begin : g_load
    assign clear[mesh] = load && s_axis_load_tuser_i == {1'b1, 1'(mesh)};
    assign push[mesh]  = load && s_axis_load_tuser_i == {1'b0, 1'(mesh)};
  end

  triaxis_mesh_store #(
      .W(W),
      .Depth(Depth),
      .Group(Group),
      .Lanes(1)
  ) u_store_a (
      .clk_i,
      .rst_ni,
      .clear_i(clear[0]),
      .push_i(push[0]),
      .triangle_i(s_axis_load_tdata_i),
      .count_o(count_a_o),
      .overfull_o(overfull_o[0]),
      .settled_o(settled_a),
      .object_o(object_a),
      .triangle_read_i(triangle_read),
      .triangle_index_i(fetch_a),
      .triangle_o(triangle_a),
      .box_read_i(box_a_read),
      .box_word_i(box_a_index),
      .boxes_o(box_a),
      .group_read_i(row_read),
      .group_word_i(row_group),
      .group_boxes_o(row_box)
  );

  triaxis_mesh_store #(
      .W(W),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes)
  ) u_store_b (
      .clk_i,
      .rst_ni,
      .clear_i(clear[1]),
      .push_i(push[1]),
      .triangle_i(s_axis_load_tdata_i),
      .count_o(count_b_o),
      .overfull_o(overfull_o[1]),
      .settled_o(settled_b),
      .object_o(object_b),
      .triangle_read_i(triangle_read),
      .triangle_index_i(fetch_b),
      .triangle_o(triangle_b),
      .box_read_i(box_b_read),
      .box_word_i(box_b_word),
      .boxes_o(boxes_b),
      .group_read_i(word_read),
      .group_word_i(word_index),
      .group_boxes_o(word_boxes)
  );

  // --- The run ------------------------------------------------------------------------------------------

  logic signed [move_width(W)-1:0] asked_move[3], move[3];
  logic signed [grown_width(W)-1:0] shift[2][3];
  logic [margin_width(M)-1:0] asked_margin, margin;
  mode_e mode;
  logic restart, start, drain, first, idle, groups_idle;
  logic rows_idle, words_idle, boxes_idle, near_idle;
  logic pick_group_valid, group_pair_valid, masked_valid, pair_valid;

  for (genvar k = 0; k < 3; k++) begin : g_move
    assign asked_move[k] = s_axis_run_tdata_i[k*move_width(W)+:move_width(W)];
  end
  if (M == 0) begin : g_no_margin
    assign asked_margin = '0;
  end else begin : g_margin
    assign asked_margin = s_axis_run_tuser_i[M-1:0];
  end

  assign settled = settled_a && settled_b;
  assign empty_a = count_a_o == '0;
  assign empty   = empty_a || count_b_o == '0;

  triaxis_run_control #(
      .W(W),
      .MarginWidth(margin_width(M)),
      .CycleBits(CycleBits)
  ) u_control (
      .clk_i,
      .rst_ni,
      .s_axis_run_tvalid_i,
      .s_axis_run_tready_o,
      .move_i(asked_move),
      .margin_i(asked_margin),
      .mode_i(s_axis_run_tuser_i[M+:2]),
      .abort_i,
      .busy_o,
      .settled_i(settled),
      .overfull_i(overfull_o != '0),
      .empty_a_i(empty_a),
      .empty_i(empty),
      .object_a_i(object_a),
      .move_o(move),
      .shift_o(shift),
      .margin_o(margin),
      .mode_o(mode),
      .clear_o(restart),
      .start_o(start),
      .drain_o(drain),
      .idle_i(idle),
      .first_i(first),
      .m_axis_done_tvalid_o,
      .m_axis_done_tready_i,
      .status_o,
      .cycles_o
  );

  // Pairs that are fetched are on their way to a verdict already.
  assign groups_idle = rows_idle && words_idle && !pick_group_valid && !group_pair_valid;
  assign idle = groups_idle && boxes_idle && !masked_valid && !pair_valid && near_idle;

  // --- Groups -------------------------------------------------------------------------------------------

  group_count_t groups_a, groups_b;
  logic row_valid, row_ready, row_skip;
  group_t row;
  logic signed [grown_width(W)-1:0] row_grown[2][3];
  logic word_valid, word_ready;
  group_word_t word, picked;
  logic [Lanes-1:0] word_mask;
  logic [LaneCountWidth-1:0] words_skipped, words_opened;
  logic pick_group_ready;
  logic [LaneWidth-1:0] picked_lane;
  group_pair_t group_pair_found, group_pair;
  logic group_pair_ready, group_pair_taken;

  assign groups_a = group_count_t'((count_a_o + count_t'(Group - 1)) >> $clog2(Group));
  assign groups_b = group_count_t'((count_b_o + count_t'(Group - 1)) >> $clog2(Group));

  triaxis_group_rows #(
      .W(W),
      .Groups(Groups)
  ) u_rows (
      .clk_i,
      .rst_ni,
      .start_i(start),
      .drain_i(drain),
      .idle_o(rows_idle),
      .groups_a_i(groups_a),
      .shift_i(shift),
      .object_b_i(object_b),
      .read_o(row_read),
      .group_o(row_group),
      .box_i(row_box[0]),
      .valid_o(row_valid),
      .ready_i(row_ready),
      .row_o(row),
      .grown_o(row_grown),
      .skip_o(row_skip)
  );

  triaxis_group_words #(
      .W(W),
      .Groups(Groups),
      .Lanes(Lanes)
  ) u_words (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .idle_o(words_idle),
      .groups_b_i(groups_b),
      .valid_i(row_valid),
      .ready_o(row_ready),
      .row_i(row),
      .grown_i(row_grown),
      .read_o(word_read),
      .read_word_o(word_index),
      .boxes_i(word_boxes),
      .valid_o(word_valid),
      .ready_i(word_ready),
      .row_o(word.row),
      .word_o(word.word),
      .mask_o(word_mask),
      .skipped_o(words_skipped),
      .opened_o(words_opened)
  );

  triaxis_pick #(
      .T(group_word_t),
      .Lanes(Lanes)
  ) u_pick_group (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .valid_i(word_valid),
      .ready_o(word_ready),
      .payload_i(word),
      .mask_i(word_mask),
      .valid_o(pick_group_valid),
      .ready_i(pick_group_ready),
      .payload_o(picked),
      .lane_o(picked_lane)
  );

  assign group_pair_found.a = picked.row;
  assign group_pair_found.b = group_t'(picked.word) * group_t'(Lanes) + group_t'(picked_lane);

  assign group_pair_taken   = group_pair_ready || drain;
  triaxis_stream_fifo #(
      .T(group_pair_t),
      .Depth(QueueDepth)
  ) u_group_pairs (
      .clk_i,
      .rst_ni,
      .valid_i(pick_group_valid),
      .ready_o(pick_group_ready),
      .data_i (group_pair_found),
      .valid_o(group_pair_valid),
      .ready_i(group_pair_taken),
      .data_o (group_pair)
  );

  // --- Triangles ----------------------------------------------------------------------------------------

  masked_pairs_t boxed, masked;
  logic boxed_valid, boxed_ready, masked_ready;
  logic [LaneCountWidth-1:0] boxes_skipped;
  pair_word_t pair_word;
  logic [LaneWidth-1:0] pair_lane;
  logic pair_ready;

  triaxis_pair_boxes #(
      .W(W),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes)
  ) u_boxes (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .idle_o(boxes_idle),
      .count_a_i(count_a_o),
      .count_b_i(count_b_o),
      .shift_i(shift),
      .valid_i(group_pair_valid),
      .ready_o(group_pair_ready),
      .group_a_i(group_pair.a),
      .group_b_i(group_pair.b),
      .read_a_o(box_a_read),
      .index_a_o(box_a_index),
      .box_a_i(box_a[0]),
      .read_b_o(box_b_read),
      .word_b_o(box_b_word),
      .boxes_b_i(boxes_b),
      .valid_o(boxed_valid),
      .ready_i(boxed_ready),
      .index_o(boxed.pairs.index),
      .word_o(boxed.pairs.word),
      .mask_o(boxed.mask),
      .skipped_o(boxes_skipped)
  );

  triaxis_stream_fifo #(
      .T(masked_pairs_t),
      .Depth(QueueDepth)
  ) u_masked_pairs (
      .clk_i,
      .rst_ni,
      .valid_i(boxed_valid),
      .ready_o(boxed_ready),
      .data_i (boxed),
      .valid_o(masked_valid),
      .ready_i(masked_ready),
      .data_o (masked)
  );

  triaxis_pick #(
      .T(pair_word_t),
      .Lanes(Lanes)
  ) u_pick_pair (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .valid_i(masked_valid),
      .ready_o(masked_ready),
      .payload_i(masked.pairs),
      .mask_i(masked.mask),
      .valid_o(pair_valid),
      .ready_i(pair_ready),
      .payload_o(pair_word),
      .lane_o(pair_lane)
  );

  // --- Vertices, verdicts ---------------------------------------------------------------------------------

  logic issue, core_valid, core_ready, verdict_valid, verdict_ready;
  logic [18*W-1:0] core_pair;
  index_t core_a, core_b;
  logic [15:0] verdict;
  logic [2*IndexWidth-1:0] verdict_pair;

  assign fetch_a = pair_word.index;
  assign fetch_b = index_t'(pair_word.word) * index_t'(Lanes) + index_t'(pair_lane);

  triaxis_pair_fetch #(
      .W(W),
      .Depth(Depth)
  ) u_fetch (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .move_i(move),
      .valid_i(pair_valid),
      .ready_o(pair_ready),
      .index_a_i(fetch_a),
      .index_b_i(fetch_b),
      .read_o(triangle_read),
      .triangle_a_i(triangle_a),
      .triangle_b_i(triangle_b),
      .valid_o(core_valid),
      .ready_i(core_ready),
      .pair_o(core_pair),
      .index_a_o(core_a),
      .index_b_o(core_b)
  );

  logic [2*IndexWidth+M-1:0] core_user;
  if (M == 0) begin : g_bare_tag
    logic unused_margin;
    assign unused_margin = ^margin;
    assign core_user = {core_b, core_a};
  end else begin : g_tag_margin
    assign core_user = {core_b, core_a, margin};
  end

  triaxis_core #(
      .W(W),
      .M(M),
      .TAG(2 * IndexWidth),
      .EdgeBox(EdgeBox),
      .Gating(Gating)
  ) u_core (
      .clk_i,
      .rst_ni,
      .s_axis_tvalid_i(core_valid),
      .s_axis_tready_o(core_ready),
      .s_axis_tdata_i (CoreWidth'(core_pair)),
      .s_axis_tuser_i (core_user),
      .m_axis_tvalid_o(verdict_valid),
      .m_axis_tready_i(verdict_ready),
      .m_axis_tdata_o (verdict),
      .m_axis_tuser_o (verdict_pair)
  );

  // Of the verdict, only whether it is near: the engine's users ask for pairs, not for axes.
  logic [14:0] unused_verdict;
  assign unused_verdict = verdict[15:1];

  // A pair that is fetched while draining is dropped.
  assign issue = triangle_read && !drain;

  triaxis_near_pairs #(
      .IndexWidth(IndexWidth),
      .InFlight  (InFlight)
  ) u_near (
      .clk_i,
      .rst_ni,
      .start_i(restart),
      .drain_i(drain),
      .idle_o(near_idle),
      .mode_i(mode),
      .first_o(first),
      .issue_i(issue),
      .verdict_valid_i(verdict_valid),
      .verdict_ready_o(verdict_ready),
      .verdict_near_i(verdict[0]),
      .verdict_pair_i(verdict_pair),
      .m_axis_near_tvalid_o,
      .m_axis_near_tready_i,
      .m_axis_near_tdata_o,
      .tested_o,
      .near_o
  );

  // --- Counters of what was skipped -----------------------------------------------------------------------

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      group_pairs_skipped_o <= '0;
      group_pairs_opened_o <= '0;
      pairs_skipped_o <= '0;
    end else if (restart) begin
      group_pairs_skipped_o <= '0;
      group_pairs_opened_o <= '0;
      pairs_skipped_o <= '0;
    end else begin
      group_pairs_skipped_o <= group_pairs_skipped_o + group_pair_count_t'(words_skipped) +
          (row_skip ? group_pair_count_t'(groups_b) : '0);
      group_pairs_opened_o <= group_pairs_opened_o + group_pair_count_t'(words_opened);
      pairs_skipped_o <= pairs_skipped_o + pair_count_t'(boxes_skipped);
    end
  end

endmodule
