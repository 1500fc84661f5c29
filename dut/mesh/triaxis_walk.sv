// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the walk of a run over two meshes in memory, from its acceptance to its summary: which boxes are
// read and held against one another, which pairs of triangles go to the core, and what is made of its
// verdicts:
//   rows    the box of each group of A against the box of the whole of B
//   words   rows that overlap against the boxes of B's groups, Lanes a clock
//   boxes   pairs of groups that overlap: each triangle of A against Lanes triangles of B a clock
//   fetch   pairs that overlap: their vertices, one pair a clock; first those that are asked again, in a
//           narrower zone, see triaxis_near_pairs
// A pair is skipped only where a box axis separates it by more than the margin, so skipping
// changes no verdict. The memories and the core are outside, see triaxis_mesh; so two walks can be held
// against each other: seen_o, in which all that a walk does shows a clock later, or is counted.
// Widths: see triaxis_mesh_pkg and triaxis_pkg; numbers of pairs 2 log2(Depth) + 1 bits.
// Latency: cycles_o tells; where nothing can be skipped, one clock a pair and some 50 more.

module triaxis_walk
  import triaxis_mesh_pkg::*;
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    parameter int unsigned CycleBits = 32,
    parameter int unsigned InFlight = 34,  // most pairs between their issue and their verdict
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned Groups = Depth / Group,
    localparam int unsigned GroupPairWidth = 2 * $clog2(Groups) + 1,
    localparam int unsigned PairCountWidth = 2 * IndexWidth + 1,
    localparam int unsigned GroupWidth = address_width(Groups),
    localparam int unsigned GroupWordWidth = address_width(Groups / Lanes),
    localparam int unsigned WordWidth = address_width(Depth / Lanes),
    localparam int unsigned SeenWidth = walk_seen_width(W, M, Depth, Group, Lanes, CycleBits)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_run_tvalid_i,
    output logic s_axis_run_tready_o,
    input logic signed [move_width(W)-1:0] move_i[3],
    input logic [Zones-1:0][margin_width(M)-1:0] margins_i,
    input logic [1:0] mode_i,
    input logic abort_i,
    output logic busy_o,

    // The meshes, and words of their memories, a clock after they are read; used_o: what rests on the word
    // in this clock.
    input logic settled_i,
    input logic overfull_i,
    input logic [IndexWidth:0] count_a_i,
    input logic [IndexWidth:0] count_b_i,
    input logic signed [W-1:0] object_a_i[2][3],
    input logic signed [W-1:0] object_b_i[2][3],
    output logic row_read_o,
    output logic [GroupWidth-1:0] row_group_o,
    input logic signed [W-1:0] row_box_i[2][3],
    output logic row_used_o,
    output logic word_read_o,
    output logic [GroupWordWidth-1:0] word_index_o,
    input logic signed [W-1:0] word_boxes_i[Lanes][2][3],
    output logic [Lanes-1:0] word_used_o,
    output logic box_a_read_o,
    output logic [IndexWidth-1:0] box_a_index_o,
    input logic signed [W-1:0] box_a_i[2][3],
    output logic box_a_used_o,
    output logic box_b_read_o,
    output logic [WordWidth-1:0] box_b_word_o,
    input logic signed [W-1:0] boxes_b_i[Lanes][2][3],
    output logic [Lanes-1:0] boxes_b_used_o,
    output logic triangle_read_o,
    output logic [IndexWidth-1:0] triangle_a_index_o,
    output logic [IndexWidth-1:0] triangle_b_index_o,
    input logic [9*W-1:0] triangle_a_i,
    input logic [9*W-1:0] triangle_b_i,
    output logic triangles_used_o,

    // The core.
    output logic core_valid_o,
    input logic core_ready_i,
    output logic [18*W-1:0] core_pair_o,
    output logic [IndexWidth-1:0] core_a_o,
    output logic [IndexWidth-1:0] core_b_o,
    output zone_e core_zone_o,
    output logic [margin_width(M)-1:0] core_margin_o,
    input logic verdict_valid_i,
    output logic verdict_ready_o,
    input logic verdict_near_i,
    input zone_e verdict_zone_i,
    input logic [2*IndexWidth-1:0] verdict_pair_i,

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
    output logic [PairCountWidth-1:0] near_o,
    output logic [Zones-1:1] zones_o,

    output logic [SeenWidth-1:0] seen_o  // of the last clock
);

  localparam int unsigned LaneWidth = address_width(Lanes);
  localparam int unsigned LaneCountWidth = $clog2(Lanes) + 1;
  localparam int unsigned GroupCountWidth = $clog2(Groups) + 1;
  localparam int unsigned QueueDepth = 16;

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

  // --- The run ------------------------------------------------------------------------------------------

  logic signed [move_width(W)-1:0] move[3];
  logic signed [grown_width(W)-1:0] shift[2][3];
  logic [Zones-1:0][margin_width(M)-1:0] margins;
  logic [Zones-1:1] wider;
  mode_e mode;
  logic restart, start, drain, first, idle, groups_idle, empty_a, empty;
  logic rows_idle, words_idle, boxes_idle, near_idle;
  logic pick_group_valid, group_pair_valid, masked_valid, pair_valid;
  logic again_valid;

  assign empty_a = count_a_i == '0;
  assign empty   = empty_a || count_b_i == '0;

  triaxis_run_control #(
      .W(W),
      .MarginWidth(margin_width(M)),
      .CycleBits(CycleBits)
  ) u_control (
      .clk_i,
      .rst_ni,
      .s_axis_run_tvalid_i,
      .s_axis_run_tready_o,
      .move_i,
      .margins_i,
      .mode_i,
      .abort_i,
      .busy_o,
      .settled_i,
      .overfull_i,
      .empty_a_i(empty_a),
      .empty_i(empty),
      .object_a_i,
      .move_o(move),
      .shift_o(shift),
      .margins_o(margins),
      .wider_o(wider),
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
  assign idle = groups_idle && boxes_idle && !masked_valid && !pair_valid && !again_valid &&
      near_idle;

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

  assign groups_a = group_count_t'((count_a_i + count_t'(Group - 1)) >> $clog2(Group));
  assign groups_b = group_count_t'((count_b_i + count_t'(Group - 1)) >> $clog2(Group));

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
      .object_b_i,
      .read_o(row_read_o),
      .group_o(row_group_o),
      .box_i(row_box_i),
      .valid_o(row_valid),
      .ready_i(row_ready),
      .row_o(row),
      .grown_o(row_grown),
      .skip_o(row_skip),
      .used_o(row_used_o)
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
      .read_o(word_read_o),
      .read_word_o(word_index_o),
      .boxes_i(word_boxes_i),
      .valid_o(word_valid),
      .ready_i(word_ready),
      .row_o(word.row),
      .word_o(word.word),
      .mask_o(word_mask),
      .skipped_o(words_skipped),
      .opened_o(words_opened),
      .used_o(word_used_o)
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
      .count_a_i,
      .count_b_i,
      .shift_i(shift),
      .valid_i(group_pair_valid),
      .ready_o(group_pair_ready),
      .group_a_i(group_pair.a),
      .group_b_i(group_pair.b),
      .read_a_o(box_a_read_o),
      .index_a_o(box_a_index_o),
      .box_a_i,
      .read_b_o(box_b_read_o),
      .word_b_o(box_b_word_o),
      .boxes_b_i,
      .valid_o(boxed_valid),
      .ready_i(boxed_ready),
      .index_o(boxed.pairs.index),
      .word_o(boxed.pairs.word),
      .mask_o(boxed.mask),
      .skipped_o(boxes_skipped),
      .used_a_o(box_a_used_o),
      .used_b_o(boxes_b_used_o)
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

  logic issue, fetch_valid, fetch_ready;
  zone_e zone;
  logic [2*IndexWidth-1:0] pair_found, pair_again;

  assign pair_found[IndexWidth-1:0] = pair_word.index;
  assign pair_found[IndexWidth+:IndexWidth] =
      index_t'(pair_word.word) * index_t'(Lanes) + index_t'(pair_lane);
  // What is to be asked again never waits: pairs are asked, and so answered, in zones that only get narrower,
  // and a verdict waits in the innermost one alone; so while pairs are asked again each verdict was taken at
  // once, and the core takes a pair a clock.
  assign {triangle_b_index_o, triangle_a_index_o} = again_valid ? pair_again : pair_found;
  assign pair_ready = fetch_ready && !again_valid;
  assign fetch_valid = pair_valid || again_valid;

  triaxis_pair_fetch #(
      .W(W),
      .Depth(Depth)
  ) u_fetch (
      .clk_i,
      .rst_ni,
      .drain_i(drain),
      .move_i(move),
      .valid_i(fetch_valid),
      .ready_o(fetch_ready),
      .index_a_i(triangle_a_index_o),
      .index_b_i(triangle_b_index_o),
      .zone_i(zone),
      .read_o(triangle_read_o),
      .used_o(triangles_used_o),
      .triangle_a_i,
      .triangle_b_i,
      .valid_o(core_valid_o),
      .ready_i(core_ready_i),
      .pair_o(core_pair_o),
      .index_a_o(core_a_o),
      .index_b_o(core_b_o),
      .zone_o(core_zone_o)
  );

  assign core_margin_o = margins[core_zone_o];

  // A pair that is fetched while draining is dropped.
  assign issue = triangle_read_o && !drain;

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
      .verdict_valid_i,
      .verdict_ready_o,
      .verdict_near_i,
      .verdict_zone_i,
      .verdict_pair_i,
      .wider_i(wider),
      .zone_o(zone),
      .zones_o,
      .again_valid_o(again_valid),
      .again_pair_o(pair_again),
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

  // --- What two walks of the same run must have alike -----------------------------------------------------

  // Data of streams and addresses as long as they are valid: until then they may be anything, and 0 is shown, for
  // which a register needs no logic.
  logic [SeenWidth-1:0] seen;
  assign seen[SeenWidth-M-1:0] = {
    s_axis_run_tready_o,
    busy_o,
    drain,
    row_read_o,
    row_read_o ? row_group_o : group_t'(0),
    word_read_o,
    word_read_o ? word_index_o : GroupWordWidth'(0),
    box_a_read_o,
    box_a_read_o ? box_a_index_o : index_t'(0),
    box_b_read_o,
    box_b_read_o ? box_b_word_o : WordWidth'(0),
    triangle_read_o,
    triangle_read_o ? {triangle_a_index_o, triangle_b_index_o} : (2 * IndexWidth)'(0),
    core_valid_o,
    core_valid_o ? {core_pair_o, core_a_o, core_b_o} : (18 * W + 2 * IndexWidth)'(0),
    core_valid_o ? core_zone_o : ZoneMargin,
    // What it hangs on is told with a verdict alone.
    verdict_valid_i && verdict_ready_o,
    m_axis_near_tvalid_o,
    m_axis_near_tvalid_o ? m_axis_near_tdata_o : (2 * IndexWidth)'(0),
    cycles_o,
    group_pairs_skipped_o,
    group_pairs_opened_o,
    pairs_skipped_o,
    tested_o,
    m_axis_done_tvalid_o,
    status_o,
    zones_o,
    near_o
  };
  if (M > 0) begin : g_seen_margin
    assign seen[SeenWidth-1-:M] = core_valid_o ? core_margin_o : '0;
  end
  always_ff @(posedge clk_i) seen_o <= seen;

endmodule
