// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the engine makes of what its checks find: that the two walks differ, or the two intakes of a mesh, that
// something rests on a word that is not intact, that a mesh is not as it was loaded, that the core tells a
// fault. All of that comes at any clocks here, see triaxis_checks_surroundings.
//
// In doubt is a run from the clock after one of these is seen, and from its beginning where one comes as it is accepted,
// or was before and is not acknowledged: it ends with StatusFault, whatever the walks say. What comes when it
// is over is no doubt about it: its status stays as it was told.

`include "triaxis_formal.svh"

module triaxis_checks_formal
  import triaxis_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 4,
    parameter int unsigned M = 4,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2,
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned TagWidth = 2 * IndexWidth + $bits(zone_e),
    localparam int unsigned SeenWidth = walk_seen_width(W, M, Depth, Group, Lanes, 2)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_run_tvalid_i,
    input logic [3*move_width(W)-1:0] s_axis_run_tdata_i,
    input logic [run_user_width(M)-1:0] s_axis_run_tuser_i,
    input logic abort_i,
    input logic m_axis_near_tready_i,
    input logic m_axis_done_tready_i,
    input logic acknowledge_i
);

  typedef logic [SeenWidth-1:0] seen_t;
  typedef logic [Lanes-1:0] lanes_t;

  logic ready, busy, done, fault_o;
  status_e status;
  logic [2*IndexWidth:0] near;
  logic [Zones-1:1] zones;
  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes),
      .CycleBits(2),
      .Certify(1'b1)
  ) u_mesh (
      .s_axis_load_tvalid_i(1'b0),
      .s_axis_load_tready_o(),
      .s_axis_load_tdata_i('0),
      .s_axis_load_tuser_i('0),
      .count_a_o(),
      .count_b_o(),
      .overfull_o(),
      .signature_a_o(),
      .signature_b_o(),
      .s_axis_run_tready_o(ready),
      .busy_o(busy),
      .m_axis_near_tvalid_o(),
      .m_axis_near_tdata_o(),
      .m_axis_done_tvalid_o(done),
      .status_o(status),
      .cycles_o(),
      .group_pairs_skipped_o(),
      .group_pairs_opened_o(),
      .pairs_skipped_o(),
      .tested_o(),
      .near_o(near),
      .zones_o(zones),
      .*
  );

  `TRIAXIS_RESET_FIRST

  // --- What the checks find -------------------------------------------------------------------------------

  // Of each walk: what rests on words, what it shows, and its summary.
  logic [1:0] row_used, box_a_used, triangles_used, over;
  lanes_t words_used[2], boxes_b_used[2];
  seen_t seen[2];
  status_e said[2];
  logic [2*IndexWidth:0] near_said[2];
  logic [Zones-1:1] zones_said[2];
  for (genvar i = 0; i < 2; i++) begin : g_walk
    assign row_used[i] = u_mesh.g_walk[i].u_walk.row_used_o;
    assign words_used[i] = u_mesh.g_walk[i].u_walk.word_used_o;
    assign box_a_used[i] = u_mesh.g_walk[i].u_walk.box_a_used_o;
    assign boxes_b_used[i] = u_mesh.g_walk[i].u_walk.boxes_b_used_o;
    assign triangles_used[i] = u_mesh.g_walk[i].u_walk.triangles_used_o;
    assign seen[i] = u_mesh.g_walk[i].u_walk.seen_o;
    assign over[i] = u_mesh.g_walk[i].u_walk.m_axis_done_tvalid_o;
    assign said[i] = u_mesh.g_walk[i].u_walk.status_o;
    assign near_said[i] = u_mesh.g_walk[i].u_walk.near_o;
    assign zones_said[i] = u_mesh.g_walk[i].u_walk.zones_o;
  end

  logic accept;
  logic [1:0] changed;
  trial_t trial_q;
  seen_t misread;
  assign accept  = s_axis_run_tvalid_i && ready;
  assign changed = {u_mesh.u_store_b.broken_o, u_mesh.u_store_a.broken_o};
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) trial_q <= '0;
    else if (accept) trial_q <= s_axis_run_tuser_i[Zones*M+$bits(mode_e)+:$bits(trial_t)];
    // Given up once it is acknowledged, or a mesh is found broken.
    else if (acknowledge_i || changed != '0) trial_q <= '0;
  end
  for (genvar i = 0; i < SeenWidth; i++) begin : g_misread
    assign misread[i] = busy && trial_q.kind == TrialWalk && i % 32 == 32'(trial_q.which);
  end

  logic broken, unlike, stores_differ, refuted, found;
  always_comb begin
    broken = 1'b0;
    for (int i = 0; i < 2; i++) begin
      if (row_used[i] && !u_mesh.u_store_a.groups_intact_o[0]) broken = 1'b1;
      if (box_a_used[i] && !u_mesh.u_store_a.boxes_intact_o[0]) broken = 1'b1;
      if (triangles_used[i] && !u_mesh.u_store_a.triangle_intact_o) broken = 1'b1;
      if (triangles_used[i] && !u_mesh.u_store_b.triangle_intact_o) broken = 1'b1;
      for (int l = 0; l < int'(Lanes); l++) begin
        if (words_used[i][l] && !u_mesh.u_store_b.groups_intact_o[l]) broken = 1'b1;
        if (boxes_b_used[i][l] && !u_mesh.u_store_b.boxes_intact_o[l]) broken = 1'b1;
      end
    end
  end
  assign unlike = (seen[0] ^ seen[1]) != misread;
  assign stores_differ = u_mesh.u_store_a.differ_o || u_mesh.u_store_b.differ_o;
  assign refuted = u_mesh.g_core.u_core.m_axis_tvalid_o && u_mesh.g_core.u_core.m_axis_tdata_o[4];

  // --- What becomes of it ---------------------------------------------------------------------------------

  // In the last clock something was found; a fault stood that was not acknowledged. Of the run: it is in doubt;
  // it was so from its beginning; a fault was told in one of its clocks; what its summary says.
  logic found_q, stood_q, doubt_q, condemned_q, met_q, tried_q, awake_q;
  status_e told_q;

  // What is found in this clock; that walks or intakes differ, a clock after they do.
  assign found = broken || changed != '0 || stores_differ || refuted || unlike;

  // What of a summary is compared in its own clock.
  logic standing, differs_now, in_doubt;
  assign standing = fault_o && !acknowledge_i;
  assign differs_now = stores_differ || unlike ||
      {over[0], said[0], zones_said[0], near_said[0]} !=
      {over[1], said[1], zones_said[1], near_said[1]};
  assign in_doubt = doubt_q || (done && differs_now);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {found_q, stood_q, doubt_q, condemned_q, met_q, tried_q, awake_q} <= '0;
      told_q <= StatusNone;
    end else begin
      awake_q <= 1'b1;
      found_q <= found;
      stood_q <= standing;
      if (accept) doubt_q <= found || standing;
      else if (busy) doubt_q <= doubt_q || found || standing || (done && differs_now);
      if (accept) condemned_q <= found || standing;
      met_q   <= !accept && busy && (met_q || fault_o);
      // The walks showed the same in a clock in which one of them was misread.
      tried_q <= !accept && (tried_q || (misread != '0 && seen[0] == seen[1]));
      if (accept) told_q <= StatusNone;
      // What is found in the very clock of the summary is told from the next one on.
      else if (done) told_q <= found ? StatusFault : status;
    end
  end

  // A clean past, for the covers.
  logic faulty_q, sound_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {faulty_q, sound_q} <= '0;
    else begin
      if (fault_o) faulty_q <= 1'b1;
      if (accept) sound_q <= s_axis_run_tuser_i[Zones*M+$bits(mode_e)+:$bits(trial_t)] == '0;
    end
  end

  always_comb begin
    if (rst_ni) begin
      // A fault is what was found in the last clock, or one that nobody acknowledged; and nothing else.
      Told : assert (fault_o == (found_q || stood_q));
      Summary : assert (done == over[0] && near == near_said[0] && zones == zones_said[0]);
      InDoubt : assert (said[0] == StatusNone || !in_doubt || status == StatusFault);
      ElseAsSaid : assert ((said[0] != StatusNone && in_doubt) || status == said[0]);
      // A fault that is told while it goes on ends it so, though it be acknowledged.
      Met : assert (!done || !(met_q || fault_o) || status == StatusFault);
      // Of a run that is over the status stays, whatever comes.
      Stays : assert (busy || status == told_q);
      BothComplete :
      assert (!done || status != StatusComplete ||
              (over[1] && said[0] == StatusComplete && said[1] == StatusComplete &&
               near_said[1] == near && zones_said[1] == zones && !fault_o) ||
              trial_q.kind == TrialWalk);
      Condemned : assert (!done || !condemned_q || status == StatusFault);
      TriedWalk : assert (!done || !tried_q || status == StatusFault);

      // Between runs the meshes are looked at, and only then.
      Scrubs :
      assert ({u_mesh.u_store_a.scrub_i, u_mesh.u_store_b.scrub_i} ==
              {2{ready && !s_axis_run_tvalid_i}});
      NotInARun : assert (!busy || !(u_mesh.u_store_a.scrub_i || u_mesh.u_store_b.scrub_i));

      // Only what was asked for is tried, of what is done in a run within it, of the scrub between runs.
      TriedIntake :
      assert ({2{busy && trial_q.kind == TrialIntake}} ==
              {u_mesh.u_store_a.trial_intake_i, u_mesh.u_store_b.trial_intake_i});
      TriedMemory :
      assert ((trial_q.kind == TrialMemory ? (32'd1 << trial_q.which) >> (busy ? 0 : 8) : 32'd0) %
              (32'd1 << 6) ==
              32'({u_mesh.u_store_b.trial_triangles_i, u_mesh.u_store_a.trial_triangles_i,
                   u_mesh.u_store_b.trial_boxes_i, u_mesh.u_store_a.trial_boxes_i,
                   u_mesh.u_store_b.trial_groups_i, u_mesh.u_store_a.trial_groups_i}));
      TriedScrub :
      assert ({2{!busy && trial_q.kind == TrialMemory && trial_q.which inside {[5'd16 : 5'd31]}}} ==
              {u_mesh.u_store_a.trial_scrub_i, u_mesh.u_store_b.trial_scrub_i});
      TriedBits :
      assert (u_mesh.u_store_a.which_i == trial_q.which &&
              u_mesh.u_store_b.which_i == trial_q.which);
      TriedCore :
      assert (u_mesh.g_core.u_core.s_axis_tuser_i[TagWidth+M+:$bits(
          try_t
      )] == {trial_q.kind inside {TrialClaim, TrialParity, TrialNumber} ? 2'(trial_q.kind) : 2'd0,
             trial_q.which});

      SeenComplete : cover (done && status == StatusComplete && sound_q && faulty_q);
      SeenTold : cover (fault_o && found_q && !stood_q);
      SeenCondemned : cover (done && condemned_q && said[0] == StatusComplete);
      SeenTried : cover (done && tried_q && said[0] == StatusComplete);
      SeenUnlike : cover (done && !doubt_q && differs_now && said[0] == StatusComplete);
      SeenLater : cover (!busy && fault_o && status == StatusComplete && changed == '0 && !found_q);
      SeenChanged : cover (!busy && changed != '0 && trial_q.kind == TrialMemory);

      // What makes it inductive.
      for (int i = 0; i < 2; i++) assert (!over[i] || (u_mesh.busy[i] && said[i] != StatusNone));
      assert (u_mesh.trial_q == trial_q);
      assert (doubt_q == u_mesh.ends_in_fault_q);
      assert (!condemned_q || doubt_q);
      assert (!met_q || doubt_q);
      assert (!busy || !tried_q || doubt_q);
      assert (!(busy && fault_o) || doubt_q);
    end
  end

endmodule
