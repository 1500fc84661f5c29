// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which triangles of mesh A, moved by a translation, come within a margin of which of
// mesh B. Both meshes are kept in memory; a run asks the exact core only about pairs that no box
// decides, see triaxis_walk.
// A pair is skipped only where a box axis separates it by more than the margin, so skipping
// changes no verdict. Streams:
//   s_axis_load   tuser {clear, mesh}: mesh 0 is A, 1 is B; clear empties it, otherwise tdata, nine
//                 coordinates, is appended. Not ready during a run.
//   s_axis_run    tdata {tz, ty, tx}, of W+1 bits each; tuser {trial, mode, warn, slow, margin}, without
//                 the three margins where M = 0; TrialNothing in use
//   m_axis_near   {index in B, index in A}, in the order of the scan; in a run with zones not quite
//   m_axis_done   one summary a run, after its last near pair was taken. Its values stay until the
//                 next run is accepted; during a run the status is none. A reset clears them, and
//                 empties both meshes: a run of empty meshes is complete, and nothing in it is near.
// Zones: warn and slow are wider margins that are looked at in the same run. What is skipped is further than
// the widest; what is near is within the margin. zones_o {warn, slow} of a complete run: 0 where the zone is
// wider than the one within it, and nothing is in it.
// What decides is checked while it does, against single wrong bits: the walk of a run is done twice, and the
// intake of each mesh, and compared in each clock; all that is kept of a mesh has parity, and between runs is
// looked at again, see triaxis_mesh_scrub; where Certify is set each "clear" of the core is shown again, see
// triaxis_certified_core. A check that fails is a fault, until it is acknowledged: the run, and all to come, end
// with StatusFault. Each check can be tried on the running engine.
// A complete run accounts for all pairs: skipped and opened pairs of groups are all there are, and
// the pairs within those opened are skipped by their boxes, or tested.
// Widths: see triaxis_mesh_pkg and triaxis_pkg; numbers of pairs 2 log2(Depth) + 1 bits.
// Latency: cycles_o tells; where nothing can be skipped, one clock a pair and some 50 more, 70 with Certify.

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
    parameter bit Certify = 1'b0,  // triaxis_certified_core in place of triaxis_core
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
    output logic [31:0] signature_a_o,
    output logic [31:0] signature_b_o,

    input logic s_axis_run_tvalid_i,
    output logic s_axis_run_tready_o,
    input logic [3*move_width(W)-1:0] s_axis_run_tdata_i,
    input logic [run_user_width(M)-1:0] s_axis_run_tuser_i,
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
    output logic [PairCountWidth-1:0] near_o,
    output logic [Zones-1:1] zones_o,

    input  logic acknowledge_i,
    output logic fault_o
);

  localparam int unsigned GroupWidth = address_width(Groups);
  localparam int unsigned GroupWordWidth = address_width(Groups / Lanes);
  localparam int unsigned WordWidth = address_width(Depth / Lanes);
  localparam int unsigned CoreWidth = 8 * ((18 * W + 7) / 8);
  // The core's queue, and two steps of fetching.
  localparam int unsigned CoreLatency = Certify ? certified_latency(W, M) : core_latency(W, M);
  localparam int unsigned InFlight = 2 ** $clog2(CoreLatency) + 2;
  localparam int unsigned SeenWidth = walk_seen_width(W, M, Depth, Group, Lanes, CycleBits);

  typedef logic signed [W-1:0] coord_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [Lanes-1:0] lanes_t;
  typedef logic [SeenWidth-1:0] seen_t;

  if (Depth != 2 ** IndexWidth || Group != 2 ** $clog2(
          Group
      ) || Lanes != 2 ** $clog2(
          Lanes
      )) begin : g_bad_powers
    $fatal(1, "Depth, Group and Lanes must be powers of two");
  end
  if (Lanes > Group || Group * Lanes > Depth) begin : g_bad_sizes
    $fatal(1, "Lanes must be at most Group, Group * Lanes at most Depth");
  end
  if (Depth < 2 || Depth > 65536 || Group > 64 || Lanes > 32) begin : g_bad_range
    $fatal(1, "Depth must be 2..65536, Group at most 64, Lanes at most 32");
  end
  if (CycleBits < 2 || CycleBits > 64) begin : g_bad_cycles
    $fatal(1, "CycleBits must be 2..64");
  end

  // --- The meshes ---------------------------------------------------------------------------------------

  trial_t trial_q;
  logic trying_intake, trying_scrub;
  logic [MemoryTrianglesB:0] broken_memory;
  logic load, scrub, settled_a, settled_b, settled;
  logic [1:0] clear, push, stores_differ, stores_broken;
  coord_t object_a[2][3], object_b[2][3];
  coord_t row_box[1][2][3], word_boxes[Lanes][2][3], box_a[1][2][3], boxes_b[Lanes][2][3];
  logic [9*W-1:0] triangle_a, triangle_b;
  logic row_intact, box_a_intact, triangle_a_intact, triangle_b_intact;
  lanes_t words_intact, boxes_b_intact;

  // Of the two walks, the first of which reads.
  logic [1:0] run_ready, busy, row_read, word_read, box_a_read, box_b_read, triangle_read;
  logic [GroupWidth-1:0] row_group[2];
  logic [GroupWordWidth-1:0] word_index[2];
  index_t box_a_index[2], fetch_a[2], fetch_b[2];
  logic [WordWidth-1:0] box_b_word[2];

  // The meshes can be loaded where a run could start.
  assign s_axis_load_tready_o = s_axis_run_tready_o;
  assign load = s_axis_load_tvalid_i && s_axis_run_tready_o;
  assign scrub = s_axis_run_tready_o && !s_axis_run_tvalid_i;
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
      .signature_o(signature_a_o),
      .scrub_i(scrub),
      .broken_o(stores_broken[0]),
      .triangle_read_i(triangle_read[0]),
      .triangle_index_i(fetch_a[0]),
      .triangle_o(triangle_a),
      .triangle_intact_o(triangle_a_intact),
      .box_read_i(box_a_read[0]),
      .box_word_i(box_a_index[0]),
      .boxes_o(box_a),
      .boxes_intact_o(box_a_intact),
      .group_read_i(row_read[0]),
      .group_word_i(row_group[0]),
      .group_boxes_o(row_box),
      .groups_intact_o(row_intact),
      .trial_triangles_i(broken_memory[MemoryTrianglesA]),
      .trial_boxes_i(broken_memory[MemoryBoxesA]),
      .trial_groups_i(broken_memory[MemoryGroupsA]),
      .trial_intake_i(trying_intake),
      .trial_scrub_i(trying_scrub),
      .which_i(trial_q.which),
      .differ_o(stores_differ[0])
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
      .signature_o(signature_b_o),
      .scrub_i(scrub),
      .broken_o(stores_broken[1]),
      .triangle_read_i(triangle_read[0]),
      .triangle_index_i(fetch_b[0]),
      .triangle_o(triangle_b),
      .triangle_intact_o(triangle_b_intact),
      .box_read_i(box_b_read[0]),
      .box_word_i(box_b_word[0]),
      .boxes_o(boxes_b),
      .boxes_intact_o(boxes_b_intact),
      .group_read_i(word_read[0]),
      .group_word_i(word_index[0]),
      .group_boxes_o(word_boxes),
      .groups_intact_o(words_intact),
      .trial_triangles_i(broken_memory[MemoryTrianglesB]),
      .trial_boxes_i(broken_memory[MemoryBoxesB]),
      .trial_groups_i(broken_memory[MemoryGroupsB]),
      .trial_intake_i(trying_intake),
      .trial_scrub_i(trying_scrub),
      .which_i(trial_q.which),
      .differ_o(stores_differ[1])
  );

  // --- The run, walked twice ------------------------------------------------------------------------------

  logic signed [move_width(W)-1:0] move[3];
  logic [Zones-1:0][margin_width(M)-1:0] margins;
  logic [margin_width(M)-1:0] core_margin[2];
  zone_e core_zone[2], verdict_zone;
  logic [Zones-1:1] zones[2];
  logic [1:0]
      row_used, box_a_used, triangles_used, walk_core_valid, verdicts_ready, near_valid, done;
  lanes_t words_used[2], boxes_b_used[2];
  logic [18*W-1:0] walk_core_pair[2];
  index_t walk_core_a[2], walk_core_b[2];
  logic [2*IndexWidth-1:0] near_data[2];
  status_e status[2];
  logic [CycleBits-1:0] cycles[2];
  logic [GroupPairWidth-1:0] groups_skipped[2], groups_opened[2];
  logic [PairCountWidth-1:0] skipped[2], tested[2], near[2];
  seen_t seen[2], misread, second;
  logic core_valid, core_ready, verdict_valid, verdict_fault;
  logic [18*W-1:0] core_pair;
  index_t core_a, core_b;
  logic [15:0] verdict;
  logic [2*IndexWidth-1:0] verdict_pair;

  for (genvar k = 0; k < 3; k++) begin : g_move
    assign move[k] = s_axis_run_tdata_i[k*move_width(W)+:move_width(W)];
  end
  if (M == 0) begin : g_no_margin
    assign margins = '0;
  end else begin : g_margin
    assign margins = s_axis_run_tuser_i[Zones*M-1:0];
  end

  assign settled = settled_a && settled_b;
  for (genvar i = 0; i < 2; i++) begin : g_walk
    // Never to be made one, as they are the same.
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_walk #(
        .W(W),
        .M(M),
        .Depth(Depth),
        .Group(Group),
        .Lanes(Lanes),
        .CycleBits(CycleBits),
        .InFlight(InFlight)
    ) u_walk (
        .clk_i,
        .rst_ni,
        .s_axis_run_tvalid_i,
        .s_axis_run_tready_o(run_ready[i]),
        .move_i(move),
        .margins_i(margins),
        .mode_i(s_axis_run_tuser_i[Zones*M+:$bits(mode_e)]),
        .abort_i,
        .busy_o(busy[i]),
        .settled_i(settled),
        .overfull_i(overfull_o != '0),
        .count_a_i(count_a_o),
        .count_b_i(count_b_o),
        .object_a_i(object_a),
        .object_b_i(object_b),
        .row_read_o(row_read[i]),
        .row_group_o(row_group[i]),
        .row_box_i(row_box[0]),
        .row_used_o(row_used[i]),
        .word_read_o(word_read[i]),
        .word_index_o(word_index[i]),
        .word_boxes_i(word_boxes),
        .word_used_o(words_used[i]),
        .box_a_read_o(box_a_read[i]),
        .box_a_index_o(box_a_index[i]),
        .box_a_i(box_a[0]),
        .box_a_used_o(box_a_used[i]),
        .box_b_read_o(box_b_read[i]),
        .box_b_word_o(box_b_word[i]),
        .boxes_b_i(boxes_b),
        .boxes_b_used_o(boxes_b_used[i]),
        .triangle_read_o(triangle_read[i]),
        .triangle_a_index_o(fetch_a[i]),
        .triangle_b_index_o(fetch_b[i]),
        .triangle_a_i(triangle_a),
        .triangle_b_i(triangle_b),
        .triangles_used_o(triangles_used[i]),
        .core_valid_o(walk_core_valid[i]),
        .core_ready_i(core_ready),
        .core_pair_o(walk_core_pair[i]),
        .core_a_o(walk_core_a[i]),
        .core_b_o(walk_core_b[i]),
        .core_zone_o(core_zone[i]),
        .core_margin_o(core_margin[i]),
        .verdict_valid_i(verdict_valid),
        .verdict_ready_o(verdicts_ready[i]),
        .verdict_near_i(verdict[0]),
        .verdict_zone_i(verdict_zone),
        .verdict_pair_i(verdict_pair),
        .m_axis_near_tvalid_o(near_valid[i]),
        .m_axis_near_tready_i,
        .m_axis_near_tdata_o(near_data[i]),
        .m_axis_done_tvalid_o(done[i]),
        .m_axis_done_tready_i,
        .status_o(status[i]),
        .cycles_o(cycles[i]),
        .group_pairs_skipped_o(groups_skipped[i]),
        .group_pairs_opened_o(groups_opened[i]),
        .pairs_skipped_o(skipped[i]),
        .tested_o(tested[i]),
        .near_o(near[i]),
        .zones_o(zones[i]),
        .seen_o(seen[i])
    );
  end

  // Of the second only what it shows is looked at.
  logic unused_second;
  assign unused_second = ^{
    run_ready[1],
    busy[1],
    row_read[1],
    word_read[1],
    box_a_read[1],
    box_b_read[1],
    triangle_read[1],
    row_group[1],
    word_index[1],
    box_a_index[1],
    fetch_a[1],
    fetch_b[1],
    box_b_word[1],
    walk_core_valid[1],
    walk_core_pair[1],
    walk_core_a[1],
    walk_core_b[1],
    core_zone[1],
    core_margin[1],
    verdicts_ready[1],
    near_valid[1],
    near_data[1],
    done[1],
    status[1],
    cycles[1],
    groups_skipped[1],
    groups_opened[1],
    skipped[1],
    tested[1],
    near[1],
    zones[1]
  };

  assign s_axis_run_tready_o = run_ready[0];
  assign busy_o = busy[0];
  assign m_axis_near_tvalid_o = near_valid[0];
  assign m_axis_near_tdata_o = near_data[0];
  assign m_axis_done_tvalid_o = done[0];
  assign cycles_o = cycles[0];
  assign group_pairs_skipped_o = groups_skipped[0];
  assign group_pairs_opened_o = groups_opened[0];
  assign pairs_skipped_o = skipped[0];
  assign tested_o = tested[0];
  assign near_o = near[0];
  assign zones_o = zones[0];

  // --- Verdicts -----------------------------------------------------------------------------------------

  assign core_valid = walk_core_valid[0];
  assign core_pair = walk_core_pair[0];
  assign core_a = walk_core_a[0];
  assign core_b = walk_core_b[0];

  // The tag of a pair: its numbers, and the zone in which it is asked.
  localparam int unsigned TagWidth = 2 * IndexWidth + $bits(zone_e);
  logic [TagWidth+M-1:0] core_user;
  if (M == 0) begin : g_bare_tag
    logic unused_margin;
    assign unused_margin = ^core_margin[0];
    assign core_user = {core_zone[0], core_b, core_a};
  end else begin : g_tag_margin
    assign core_user = {core_zone[0], core_b, core_a, core_margin[0]};
  end

  if (Certify) begin : g_core
    try_t attempt;
    assign attempt = {try_kind_e'(trial_q.kind[2] ? 2'd0 : trial_q.kind[1:0]), trial_q.which};
    triaxis_certified_core #(
        .W(W),
        .M(M),
        .TAG(TagWidth),
        .EdgeBox(EdgeBox),
        .Gating(Gating)
    ) u_core (
        .clk_i,
        .rst_ni,
        .s_axis_tvalid_i(core_valid),
        .s_axis_tready_o(core_ready),
        .s_axis_tdata_i (CoreWidth'(core_pair)),
        .s_axis_tuser_i ({attempt, core_user}),
        .m_axis_tvalid_o(verdict_valid),
        .m_axis_tready_i(verdicts_ready[0]),
        .m_axis_tdata_o (verdict),
        .m_axis_tuser_o ({verdict_zone, verdict_pair})
    );
  end else begin : g_core
    triaxis_core #(
        .W(W),
        .M(M),
        .TAG(TagWidth),
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
        .m_axis_tready_i(verdicts_ready[0]),
        .m_axis_tdata_o (verdict),
        .m_axis_tuser_o ({verdict_zone, verdict_pair})
    );
  end

  // Of the verdict, only whether it is near, or a fault: the engine's users ask for pairs, not for axes.
  assign verdict_fault = verdict_valid && verdict[4];
  logic [13:0] unused_verdict;
  assign unused_verdict = {verdict[15:5], verdict[3:1]};

  // --- Faults -------------------------------------------------------------------------------------------

  logic row_broken, box_a_broken, triangles_broken;
  lanes_t words_broken, boxes_b_broken;
  logic accept, trying_walk, broken, differ, unlike, fault, fault_q, ends_in_fault_q;
  assign accept = s_axis_run_tvalid_i && s_axis_run_tready_o;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) trial_q <= '0;
    else if (accept) trial_q <= s_axis_run_tuser_i[Zones*M+$bits(mode_e)+:$bits(trial_t)];
    // What was to be found is; else the next meshes would be in doubt as well.
    else if (acknowledge_i || stores_broken != '0) trial_q <= '0;
  end
  for (genvar i = 0; i <= MemoryTrianglesB; i++) begin : g_trying_memory
    assign broken_memory[i] = trial_q.kind == TrialMemory &&
        trial_q.which == (busy_o ? 5'(i) : 5'(WhichScrub + i));
  end
  assign trying_walk = trial_q.kind == TrialWalk && busy_o;
  assign trying_intake = trial_q.kind == TrialIntake && busy_o;
  assign trying_scrub =
      trial_q.kind == TrialMemory && trial_q.which >= 5'(WhichScrubbed) && !busy_o;

  // Words that something rests on, by either walk.
  assign row_broken = row_used != '0 && !row_intact;
  assign words_broken = (words_used[0] | words_used[1]) & ~words_intact;
  assign box_a_broken = box_a_used != '0 && !box_a_intact;
  assign boxes_b_broken = (boxes_b_used[0] | boxes_b_used[1]) & ~boxes_b_intact;
  assign triangles_broken = triangles_used != '0 && !(triangle_a_intact && triangle_b_intact);
  assign broken = row_broken || words_broken != '0 || box_a_broken || boxes_b_broken != '0 ||
      triangles_broken || stores_broken != '0;

  for (genvar i = 0; i < SeenWidth; i++) begin : g_misread
    assign misread[i] = trying_walk && 5'(i) == trial_q.which;
  end
  assign second = seen[1] ^ misread;
  // In a reset they are alike.
  assign differ = seen[0] != second || stores_differ != '0;
  assign fault  = broken || differ || verdict_fault || (fault_q && !acknowledge_i);

  // A run that meets a fault ends in one, though it be acknowledged; what comes after it changes it no more.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      fault_q <= 1'b0;
      ends_in_fault_q <= 1'b0;
    end else begin
      fault_q <= fault;
      ends_in_fault_q <= ((fault || unlike) && (busy_o || accept)) || (ends_in_fault_q && !accept);
    end
  end
  assign fault_o = fault_q;

  // What decides is compared in the very clock of the summary.
  assign unlike = done[0] && (differ || !done[1] || status[0] != status[1] ||
      zones[0] != zones[1] || near[0] != near[1]);
  assign status_o =
      (status[0] != StatusNone && (unlike || ends_in_fault_q)) ? StatusFault : status[0];

endmodule
