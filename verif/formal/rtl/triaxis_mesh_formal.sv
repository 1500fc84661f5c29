// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The walk of a run: one triangle of A and one of B are followed, free constants, from the start of a
// run to its end. A complete run has handed the pair to the core, once in a zone, as it is in memory, A moved,
// and has its verdict: near, of the margin; or clear, and not less far than any zone in which it says that
// nothing is; a zone that is no wider than the one within it is never one of these. Or it has held its boxes, or
// boxes around them, against one another, and on one axis they are apart by more than the widest margin. Or
// something rested on a word of a memory that was not intact, and then the engine knows of it at that clock. All
// this is of the first of the two walks: what becomes of a difference, and of a fault, is `engine_checks`. While
// a mesh is scrubbed the walk reads nothing.
//
// While the run goes on the pair is in one place: not yet reached by the scan of the rows, in a stage,
// or in a queue, alone or in a group or a word that holds it; in the core, or to be asked again; or it was skipped; or its last verdict was taken.

`include "triaxis_formal.svh"

`define WALK u_mesh.g_walk[0].u_walk

module triaxis_mesh_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 8,
    parameter int unsigned M = 8,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2,
    parameter int unsigned QueueDepth = 4,
    localparam int unsigned IndexWidth = $clog2(Depth)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_load_tvalid_i,
    input logic [9*W-1:0] s_axis_load_tdata_i,
    input logic [1:0] s_axis_load_tuser_i,
    input logic s_axis_run_tvalid_i,
    input logic [3*move_width(W)-1:0] s_axis_run_tdata_i,
    input logic [run_user_width(M)-1:0] s_axis_run_tuser_i,
    input logic abort_i,
    input logic m_axis_near_tready_i,
    input logic m_axis_done_tready_i
);

  localparam int unsigned RowQueueDepth = 4;
  localparam int unsigned WordsOfGroup = Group / Lanes;
  // States of the run's control, by their places in the enumeration.
  localparam logic [2:0] Fresh = 3'd0, Idle = 3'd1, Settle = 3'd2, Check = 3'd3, Start = 3'd4;
  localparam logic [2:0] Scan = 3'd5, Drain = 3'd6, Report = 3'd7;

  typedef logic signed [W+3:0] wide_t;
  typedef logic [1:0][2:0][W-1:0] box_t;

  logic done;
  status_e status;
  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes),
      .CycleBits(2)
  ) u_mesh (
      .s_axis_load_tready_o(),
      .count_a_o(),
      .count_b_o(),
      .overfull_o(),
      .signature_a_o(),
      .signature_b_o(),
      .s_axis_run_tready_o(),
      .busy_o(),
      .m_axis_near_tvalid_o(),
      .m_axis_near_tdata_o(),
      .m_axis_done_tvalid_o(),
      .status_o(),
      .cycles_o(),
      .group_pairs_skipped_o(),
      .group_pairs_opened_o(),
      .pairs_skipped_o(),
      .tested_o(),
      .near_o(),
      .zones_o(),
      .acknowledge_i(1'b0),
      .fault_o(),
      .*
  );
  assign done   = `WALK.m_axis_done_tvalid_o;
  assign status = `WALK.status_o;

  `TRIAXIS_RESET_FIRST

  // --- The pair, and where it is found ------------------------------------------------------------------

  logic [IndexWidth-1:0] a, b;
  logic [31:0] row, column, column_word, column_lane, word, lane, step, part;
  logic present, empty;
  logic [2:0] state;
  assign a = u_mesh.u_store_a.number_q;
  assign b = u_mesh.u_store_b.number_q;
  assign row = 32'(a) / Group;
  assign step = 32'(a) % Group;
  assign column = 32'(b) / Group;
  assign column_word = column / Lanes;
  assign column_lane = column % Lanes;
  assign word = 32'(b) / Lanes;
  assign lane = 32'(b) % Lanes;
  assign part = word % WordsOfGroup;
  assign present = 32'(a) < 32'(u_mesh.count_a_o) && 32'(b) < 32'(u_mesh.count_b_o);
  assign empty = u_mesh.count_a_o == '0 || u_mesh.count_b_o == '0;
  assign state = `WALK.u_control.state_q;

  // --- By the definition ----------------------------------------------------------------------------------

  function automatic wide_t low(box_t box, int k);
    return wide_t'($signed(box[0][k]));
  endfunction
  function automatic wide_t high(box_t box, int k);
    return wide_t'($signed(box[1][k]));
  endfunction

  // Margin is the widest: what is skipped is further.
  wide_t move[3], margin;
  logic [Zones-1:0][M-1:0] margins;
  for (genvar k = 0; k < 3; k++) begin : g_move
    assign move[k] = wide_t'($signed(`WALK.u_control.move_o[k]));
  end
  assign margins = `WALK.u_control.margins_o;
  assign margin  = wide_t'({4'b0, margins[ZoneWarn]});

  // On one axis more than the margin lies between a box of A, moved, and one of B.
  function automatic logic apart(box_t of_a, box_t of_b);
    apart = 1'b0;
    for (int k = 0; k < 3; k++) begin
      if (low(of_b, k) - (high(of_a, k) + move[k]) > margin) apart = 1'b1;
      if (low(of_a, k) + move[k] - high(of_b, k) > margin) apart = 1'b1;
    end
  endfunction

  box_t object_a, object_b, group_a, group_b, box_a, box_b;
  assign object_a = u_mesh.u_store_a.object_q;
  assign object_b = u_mesh.u_store_b.object_q;
  assign group_a  = u_mesh.u_store_a.group_q;
  assign group_b  = u_mesh.u_store_b.group_q;
  assign box_a    = u_mesh.u_store_a.box_q;
  assign box_b    = u_mesh.u_store_b.box_q;

  logic [9*W-1:0] moved;
  for (genvar i = 0; i < 9; i++) begin : g_vertex
    assign moved[i*W+:W] = u_mesh.u_store_a.triangle_q[i*W+:W] + move[i%3][W-1:0];
  end

  // --- What becomes of it ---------------------------------------------------------------------------------

  logic skips_row, skips_word, skips_box, issues, sends, answered, last;
  assign skips_row = `WALK.row_skip && 32'(`WALK.u_rows.grown_group_q) == row;
  assign skips_word = 32'(`WALK.u_words.read_row_q) == row &&
      32'(`WALK.u_words.read_word_q) == column_word && `WALK.u_words.decided[column_lane] &&
      !`WALK.u_words.overlap[column_lane];
  assign skips_box = `WALK.u_boxes.grown_index_q == a &&
      32'(`WALK.u_boxes.grown_word_q) == word && `WALK.u_boxes.decided[lane] &&
      !`WALK.u_boxes.overlap[lane];
  assign issues = `WALK.issue && `WALK.triangle_a_index_o == a && `WALK.triangle_b_index_o == b;
  assign sends = u_mesh.core_valid && u_mesh.core_ready && u_mesh.core_a == a && u_mesh.core_b == b;
  assign answered = u_mesh.verdict_valid && u_mesh.verdicts_ready[0] &&
      u_mesh.verdict_pair == {b, a};
  // Whatever else it says, the pair is asked again.
  assign last = !u_mesh.verdict[0] || u_mesh.verdict_zone == ZoneMargin;

  // In this clock something rests on a word that is not intact; something did in this run.
  logic breaks, broken_q;
  assign breaks = (`WALK.row_used_o && !u_mesh.row_intact) ||
      (`WALK.word_used_o & ~u_mesh.words_intact) != '0 ||
      (`WALK.box_a_used_o && !u_mesh.box_a_intact) ||
      (`WALK.boxes_b_used_o & ~u_mesh.boxes_b_intact) != '0 ||
      (`WALK.triangles_used_o && !(u_mesh.triangle_a_intact && u_mesh.triangle_b_intact));
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) broken_q <= 1'b0;
    else broken_q <= breaks || (broken_q && !`WALK.restart);
  end

  // The pair is followed in this run; what became of it: the zone that it was asked in last; its last verdict.
  logic followed_q, follows, skipped_q, asked_q, decided_q, near_q;
  zone_e asked_zone_q;
  assign follows = followed_q && !breaks;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {followed_q, skipped_q, asked_q, decided_q} <= '0;
    else if (`WALK.restart || `WALK.drain || `WALK.first || breaks)
      {followed_q, skipped_q, asked_q, decided_q} <= '0;
    else if (`WALK.start) followed_q <= present;
    else if (followed_q) begin
      if (skips_row || skips_word || skips_box) skipped_q <= 1'b1;
      if (issues) asked_q <= 1'b1;
      if (answered && last) decided_q <= 1'b1;
    end
  end
  always_ff @(posedge clk_i) begin
    if (issues) asked_zone_q <= `WALK.zone;
    if (answered) near_q <= u_mesh.verdict[0];
  end

  // What the run says of each outer zone is so of the pair: something is in it, or this pair is not.
  logic [Zones-1:1] zones, zone_told, not_less, wider;
  assign zones = `WALK.zones_o;
  for (genvar z = 1; z < Zones; z++) begin : g_zone
    assign not_less[z] = margins[asked_zone_q] >= margins[z];
    assign wider[z] = margins[z] > margins[z-1];
    assign zone_told[z] = zones[z] || (!near_q && not_less[z]);
  end

  always_comb begin
    if (rst_ni) begin
      Accounted :
      assert (!done || status != StatusComplete || empty || !present || broken_q || skipped_q ||
              decided_q);
      ZonesTold : assert (!done || status != StatusComplete || !decided_q || zone_told == '1);
      NeverFreeUnasked : assert (!done || status != StatusComplete || (zones | wider) == '1);
      NearOfMargin : assert (!decided_q || !near_q || (asked_zone_q == ZoneMargin && zones == '1));
      RowsApart : assert (!follows || !skips_row || apart(group_a, object_b));
      WordsApart : assert (!follows || !skips_word || apart(group_a, group_b));
      BoxesApart : assert (!follows || !skips_box || apart(box_a, box_b));
      // Once, or again in a narrower zone.
      Once :
      assert (!followed_q || !issues ||
              (!decided_q && !skipped_q && (!asked_q || `WALK.zone < asked_zone_q)));
      DecidedOnce : assert (!followed_q || !answered || (!decided_q && asked_q));
      AsItIs :
      assert (!followed_q || !sends ||
              (u_mesh.core_pair == {u_mesh.u_store_b.triangle_q, moved} &&
               u_mesh.core_margin[0] == margins[asked_zone_q]));
      // What is to be asked again is not lost, and is asked before any that is new.
      AgainAtOnce : assert (!`WALK.again_valid || (`WALK.fetch_ready && !`WALK.pair_ready));
      // One more that is issued is still counted.
      RoomToIssue : assert (!`WALK.issue || 32'(`WALK.u_near.in_flight_q) < u_mesh.InFlight);
      VerdictsAwaited : assert (!u_mesh.verdict_valid || `WALK.u_near.in_flight_q != '0);
      BrokenIsTold : assert (!breaks || u_mesh.broken);
      // No one else reads, so that a word is where the walk looked for it.
      ScrubsAtRest :
      assert (!(u_mesh.u_store_a.scrub_i || u_mesh.u_store_b.scrub_i) || !(u_mesh.busy_o ||
              u_mesh.row_read[0] || u_mesh.word_read[0] || u_mesh.box_a_read[0] ||
              u_mesh.box_b_read[0] || u_mesh.triangle_read[0]));
      // Verdicts are taken; nothing is found broken, and no verdict wrong, once the summary is there.
      VerdictTaken : assert (!done || (!breaks && u_mesh.g_core.u_core.held_q == '0));

      SeenSent : cover (done && status == StatusComplete && decided_q);
      SeenAgain :
      cover (done && status == StatusComplete && decided_q && !near_q && zones == 2'b10 &&
             margins[ZoneMargin] < margins[ZoneSlow] && margins[ZoneSlow] < margins[ZoneWarn]);
      SeenSkippedRow : cover (followed_q && skips_row);
      SeenSkippedWord : cover (followed_q && skips_word);
      SeenSkippedBox : cover (followed_q && skips_box);
      SeenBroken : cover (done && status == StatusComplete && broken_q && present);
      SeenDrained : cover (state == Drain && u_mesh.core_valid);
    end
  end

  // --- What makes it inductive ----------------------------------------------------------------------------

  // Entries of the queues that hold the pair; of the oldest, what is left of it.
  logic [RowQueueDepth-1:0] in_rows;
  logic [QueueDepth-1:0] in_groups, in_masked;
  logic in_again;
  logic ahead_in_row, ahead_in_group;
  assign ahead_in_row = 32'(`WALK.u_words.word_q) <= column_word;
  assign ahead_in_group = 32'(`WALK.u_boxes.triangle_q) < step ||
      (32'(`WALK.u_boxes.triangle_q) == step && 32'(`WALK.u_boxes.word_q) <= part);

  localparam int unsigned GrownWidth = grown_width(W);
  typedef logic [1:0][2:0][GrownWidth-1:0] grown_t;
  function automatic logic right(grown_t grown, box_t box);
    right = 1'b1;
    for (int k = 0; k < 3; k++) begin
      if (wide_t'($signed(grown[0][k])) != low(box, k) + move[k] - margin) right = 1'b0;
      if (wide_t'($signed(grown[1][k])) != high(box, k) + move[k] + margin) right = 1'b0;
    end
  endfunction

  grown_t grown_of_row, grown_of_word, grown_of_box;
  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign grown_of_row[c][k]  = `WALK.u_rows.grown[c][k];
      assign grown_of_word[c][k] = `WALK.u_words.read_grown_q[c][k];
      assign grown_of_box[c][k]  = `WALK.u_boxes.grown[c][k];
    end
  end

  logic [RowQueueDepth-1:0] row_right;
  for (genvar i = 0; i < RowQueueDepth; i++) begin : g_rows
    logic [1:0] age;
    logic of_row;
    assign age = 2'(i) - `WALK.u_rows.u_waiting.u_words.read_q[1:0];
    assign of_row = 3'(age) < `WALK.u_rows.u_waiting.held_q &&
        32'(`WALK.u_rows.u_waiting.u_words.memory_q[i].row) == row;
    assign in_rows[i] = of_row && (age != '0 || ahead_in_row);
    assign row_right[i] = !of_row || right(
        `WALK.u_rows.u_waiting.u_words.memory_q[i].grown, group_a
    );
  end
  for (genvar i = 0; i < QueueDepth; i++) begin : g_queues
    logic [$clog2(QueueDepth)-1:0] age_group, age_masked;
    assign age_group = 2'(i) - `WALK.u_group_pairs.u_words.read_q[1:0];
    assign in_groups[i] = 3'(age_group) < `WALK.u_group_pairs.held_q &&
        32'(`WALK.u_group_pairs.u_words.memory_q[i].a) == row &&
        32'(`WALK.u_group_pairs.u_words.memory_q[i].b) == column &&
        (age_group != '0 || ahead_in_group);
    assign age_masked = 2'(i) - `WALK.u_masked_pairs.u_words.read_q[1:0];
    assign in_masked[i] = 3'(age_masked) < `WALK.u_masked_pairs.held_q &&
        `WALK.u_masked_pairs.u_words.memory_q[i].pairs.index == a &&
        32'(`WALK.u_masked_pairs.u_words.memory_q[i].pairs.word) == word &&
        `WALK.u_masked_pairs.u_words.memory_q[i].mask[lane];
  end

  assign in_again = `WALK.again_valid && `WALK.pair_again == {b, a};

  logic [9:0] in_stages;
  assign in_stages = {
    `WALK.u_rows.scanning_q && 32'(`WALK.u_rows.next_q) <= row,
    `WALK.u_rows.read_valid_q && 32'(`WALK.u_rows.read_group_q) == row,
    `WALK.u_rows.grown_valid_q && 32'(`WALK.u_rows.grown_group_q) == row,
    `WALK.u_words.read_valid_q && 32'(`WALK.u_words.read_row_q) == row &&
        32'(`WALK.u_words.read_word_q) == column_word,
    32'(`WALK.word.row) == row && 32'(`WALK.word.word) == column_word &&
        `WALK.word_mask[column_lane],
    32'(`WALK.picked.row) == row && 32'(`WALK.picked.word) == column_word &&
        `WALK.u_pick_group.mask_q[column_lane],
    `WALK.u_boxes.read_valid_q && `WALK.u_boxes.read_index_q == a &&
        32'(`WALK.u_boxes.read_word_q) == word,
    `WALK.u_boxes.grown_valid_q && `WALK.u_boxes.grown_index_q == a &&
        32'(`WALK.u_boxes.grown_word_q) == word,
    `WALK.boxed.pairs.index == a && 32'(`WALK.boxed.pairs.word) == word && `WALK.boxed.mask[lane],
    `WALK.pair_word.index == a && 32'(`WALK.pair_word.word) == word &&
        `WALK.u_pick_pair.mask_q[lane]
  };
  localparam int unsigned Places = 10 + RowQueueDepth + 2 * QueueDepth + 6;
  logic [Places-1:0] places;
  logic somewhere, twice;
  logic read_here, offered_here, core_here;
  assign read_here = `WALK.u_fetch.read_valid_q && `WALK.u_fetch.read_a_q == a &&
      `WALK.u_fetch.read_b_q == b;
  assign offered_here = u_mesh.core_valid && u_mesh.core_a == a && u_mesh.core_b == b;
  assign core_here = u_mesh.g_core.u_core.here_q;
  assign places = {
    in_stages,
    in_rows,
    in_groups,
    in_masked,
    in_again,
    read_here,
    offered_here,
    core_here,
    skipped_q,
    decided_q
  };
  always_comb begin
    {somewhere, twice} = '0;
    for (int i = 0; i < int'(Places); i++) begin
      twice |= somewhere && places[i];
      somewhere |= places[i];
    end
  end
  logic at_rest, in_run;
  assign at_rest = `WALK.groups_idle && `WALK.rows_idle && `WALK.boxes_idle &&
      !`WALK.masked_valid && !`WALK.pair_valid && !`WALK.again_valid;
  assign in_run = state inside {Start, Scan, Drain};

  // What the margins are made of: no zone is narrower than the one within it.
  logic [Zones-1:0][M-1:0] asked;
  logic [M-1:0] asked_slow, asked_warn;
  assign asked = `WALK.u_control.asked_q;
  assign asked_slow = asked[ZoneSlow] > asked[ZoneMargin] ? asked[ZoneSlow] : asked[ZoneMargin];
  assign asked_warn = asked[ZoneWarn] > asked_slow ? asked[ZoneWarn] : asked_slow;

  always_comb begin
    assume (u_mesh.g_core.u_core.followed_q == {b, a});
    if (rst_ni) begin
      // The place of the pair.
      assert (!followed_q || (somewhere && !twice));
      assert (!followed_q ||
              (read_here || offered_here || core_here || decided_q || in_again) == asked_q);
      // The zone that it was asked in.
      if (followed_q && asked_q) begin
        assert (asked_zone_q <= ZoneWarn);
        assert (!read_here || `WALK.u_fetch.read_zone_q == asked_zone_q);
        assert (!offered_here || `WALK.core_zone_o == asked_zone_q);
        assert (!core_here || u_mesh.g_core.u_core.zone_q == asked_zone_q);
        assert (!in_again || (asked_zone_q != ZoneMargin && zones[asked_zone_q]));
        assert (!(state inside {Scan, Report}) || (zones | not_less) == '1);
      end
      assert (!(state inside {Check, Start, Scan, Drain, Report}) || (zones | `WALK.wider) == '1);
      assert (!followed_q || !u_mesh.g_core.u_core.twice_q);
      assert (u_mesh.g_core.u_core.held_q != '0 ||
              !(u_mesh.g_core.u_core.here_q || u_mesh.g_core.u_core.twice_q));
      assert (!(state inside {Check, Start} || (done && status == StatusComplete)) || !`WALK.first);
      assert (state != Scan || followed_q == (present && !broken_q));
      assert (!broken_q || !(followed_q || state inside {Check, Start}));
      assert (followed_q || {skipped_q, asked_q, decided_q} == '0);
      assert (!followed_q ||
              (state inside {Scan, Drain, Report} ? present : state inside {Idle, Settle}));

      // At rest between runs.
      assert (in_run || (at_rest && `WALK.u_near.in_flight_q == '0));
      assert (state != Start || (at_rest && `WALK.u_near.in_flight_q == '0));
      assert (`WALK.u_words.word_q == '0 ||
              (`WALK.row_valid && `WALK.u_words.word_q <= `WALK.u_words.last_word));
      assert ({`WALK.u_boxes.triangle_q, `WALK.u_boxes.word_q} == '0 || `WALK.group_pair_valid);
      assert (32'(`WALK.u_near.in_flight_q) == 32'(`WALK.u_fetch.read_valid_q) +
              32'(u_mesh.core_valid) + 32'(u_mesh.g_core.u_core.held_q));
      assert (32'(u_mesh.g_core.u_core.held_q) <= u_mesh.g_core.u_core.Places);

      // Zones only get narrower from the scan to the verdict, and a verdict waits in the innermost alone.
      assert (!`WALK.u_fetch.read_valid_q || `WALK.zone <= `WALK.u_fetch.read_zone_q);
      assert (!`WALK.core_valid_o || (`WALK.zone <= `WALK.core_zone_o &&
              (!`WALK.u_fetch.read_valid_q || `WALK.u_fetch.read_zone_q <= `WALK.core_zone_o)));
      if (u_mesh.g_core.u_core.held_q != '0) begin
        assert (`WALK.zone <= u_mesh.g_core.u_core.latest_q);
        assert (!`WALK.u_fetch.read_valid_q ||
                `WALK.u_fetch.read_zone_q <= u_mesh.g_core.u_core.latest_q);
        assert (!`WALK.core_valid_o || `WALK.core_zone_o <= u_mesh.g_core.u_core.latest_q);
      end else begin
        assert (u_mesh.g_core.u_core.eager_q && u_mesh.g_core.u_core.told_q == '1);
      end
      assert (u_mesh.g_core.u_core.eager_q || u_mesh.g_core.u_core.told_q == ZoneMargin);
      assert (u_mesh.g_core.u_core.awake_q || !`WALK.again_valid);
      assert (u_mesh.g_core.u_core.eager_q || !`WALK.again_valid);

      assert (32'(u_mesh.count_a_o) <= Depth && 32'(u_mesh.count_b_o) <= Depth);

      // The queues.
      assert (`WALK.u_rows.u_waiting.held_q == `WALK.u_rows.u_waiting.u_words.write_q -
              `WALK.u_rows.u_waiting.u_words.read_q && `WALK.u_rows.u_waiting.held_q <= 3'd4);
      assert (`WALK.u_group_pairs.held_q == `WALK.u_group_pairs.u_words.write_q -
              `WALK.u_group_pairs.u_words.read_q && `WALK.u_group_pairs.held_q <= 3'd4);
      assert (`WALK.u_masked_pairs.held_q == `WALK.u_masked_pairs.u_words.write_q -
              `WALK.u_masked_pairs.u_words.read_q && `WALK.u_masked_pairs.held_q <= 3'd4);
      assert (!`WALK.u_rows.u_waiting.ready_q || `WALK.u_rows.u_waiting.held_q != 3'd4);
      assert (!`WALK.u_group_pairs.ready_q || `WALK.u_group_pairs.held_q != 3'd4);
      assert (!`WALK.u_masked_pairs.ready_q || `WALK.u_masked_pairs.held_q != 3'd4);

      // What was asked for: refused where A moved leaves the range, so that no sum is cut.
      if (state inside {Check, Start, Scan}) begin
        assert (`WALK.settled_i);
        for (int k = 0; k < 3; k++) begin
          assert (state == Check || wide_t'($signed(`WALK.shift[0][k])) == move[k] - margin);
          assert (state == Check || wide_t'($signed(`WALK.shift[1][k])) == move[k] + margin);
          assert ((state == Check && (`WALK.u_control.overflow_q || `WALK.empty_a)) || (low(
              object_a, k
          ) + move[k] >= -(wide_t'(1) <<< (W - 1)) && high(
              object_a, k
          ) + move[k] < (wide_t'(1) <<< (W - 1))));
        end
      end
      assert (state inside {Fresh, Idle, Settle} ||
              margins == {asked_warn, asked_slow, asked[ZoneMargin]});
      assert (!(state inside {Start, Scan}) || !empty);
      assert (!`WALK.u_rows.scanning_q || !(state inside {Scan, Drain}) ||
              32'(`WALK.u_rows.next_q) < 32'(`WALK.groups_a));

      // The memories were read where the stages say.
      assert (!`WALK.u_rows.read_valid_q ||
              u_mesh.u_store_a.group_at_q == `WALK.u_rows.read_group_q);
      assert (!`WALK.u_words.read_valid_q ||
              u_mesh.u_store_b.group_at_q == `WALK.u_words.read_word_q);
      assert (!`WALK.u_boxes.read_valid_q ||
              u_mesh.u_store_a.box_at_q == `WALK.u_boxes.read_index_q);
      assert (!`WALK.u_boxes.grown_valid_q ||
              u_mesh.u_store_b.box_at_q == `WALK.u_boxes.grown_word_q);
      assert (!`WALK.u_fetch.read_valid_q ||
              (u_mesh.u_store_a.triangle_at_q == `WALK.u_fetch.read_a_q &&
               u_mesh.u_store_b.triangle_at_q == `WALK.u_fetch.read_b_q));

      // What was read of the pair, grown and moved.
      if (state == Scan && !broken_q) begin
        assert (!in_stages[7] || right(grown_of_row, group_a));
        assert (row_right == '1);
        assert (!(`WALK.u_words.read_valid_q && 32'(`WALK.u_words.read_row_q) == row) || right(
            grown_of_word, group_a
        ));
        assert (!(`WALK.u_boxes.grown_valid_q && `WALK.u_boxes.grown_index_q == a) || right(
            grown_of_box, box_a
        ));
        assert (!offered_here || !followed_q ||
                u_mesh.core_pair == {u_mesh.u_store_b.triangle_q, moved});
      end
    end
  end

endmodule
