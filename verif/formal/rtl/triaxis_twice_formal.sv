// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Whatever one of the two walks does that the other does not, and whatever one intake of a mesh makes of it
// that the other does not, is a difference in the next clock. The registers of each begin with anything: so
// this holds whatever it was that made them differ. In a reset they are alike, so that none is told after it.
// Memories and core: see triaxis_twice_surroundings.

`include "triaxis_formal.svh"

module triaxis_twice_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 8,
    parameter int unsigned M = 8,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2
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
    input logic m_axis_done_tready_i,
    input logic acknowledge_i
);

  logic fault_o;
  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes)
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
      .*
  );

  // --- The walks ------------------------------------------------------------------------------------------

  // Where a word is read, and what is said, by either; whether a verdict is taken, where there is one.
  logic same_reads, same_pair, same_answers;
  assign same_reads = ^u_mesh.row_read == 1'b0 && ^u_mesh.word_read == 1'b0 &&
      ^u_mesh.box_a_read == 1'b0 && ^u_mesh.box_b_read == 1'b0 && ^u_mesh.triangle_read == 1'b0 &&
      (!u_mesh.row_read[0] || u_mesh.row_group[0] == u_mesh.row_group[1]) &&
      (!u_mesh.word_read[0] || u_mesh.word_index[0] == u_mesh.word_index[1]) &&
      (!u_mesh.box_a_read[0] || u_mesh.box_a_index[0] == u_mesh.box_a_index[1]) &&
      (!u_mesh.box_b_read[0] || u_mesh.box_b_word[0] == u_mesh.box_b_word[1]) &&
      (!u_mesh.triangle_read[0] || (u_mesh.fetch_a[0] == u_mesh.fetch_a[1] &&
       u_mesh.fetch_b[0] == u_mesh.fetch_b[1]));
  assign same_pair = ^u_mesh.walk_core_valid == 1'b0 &&
      (!u_mesh.walk_core_valid[0] || (u_mesh.walk_core_pair[0] == u_mesh.walk_core_pair[1] &&
       u_mesh.walk_core_a[0] == u_mesh.walk_core_a[1] &&
       u_mesh.walk_core_b[0] == u_mesh.walk_core_b[1] &&
       u_mesh.core_zone[0] == u_mesh.core_zone[1] &&
       u_mesh.core_margin[0] == u_mesh.core_margin[1]));
  assign same_answers = ^u_mesh.run_ready == 1'b0 && ^u_mesh.busy == 1'b0 &&
      (!u_mesh.verdict_valid || ^u_mesh.verdicts_ready == 1'b0) && ^u_mesh.near_valid == 1'b0 &&
      (!u_mesh.near_valid[0] || u_mesh.near_data[0] == u_mesh.near_data[1]) &&
      u_mesh.cycles[0] == u_mesh.cycles[1] &&
      u_mesh.groups_skipped[0] == u_mesh.groups_skipped[1] &&
      u_mesh.groups_opened[0] == u_mesh.groups_opened[1] &&
      u_mesh.skipped[0] == u_mesh.skipped[1] && u_mesh.tested[0] == u_mesh.tested[1];

  logic [1:0] over;
  status_e said[2];
  logic [2*$clog2(Depth):0] near_said[2];
  logic [Zones-1:1] zones_said[2];
  for (genvar i = 0; i < 2; i++) begin : g_walk
    assign over[i] = u_mesh.g_walk[i].u_walk.m_axis_done_tvalid_o;
    assign said[i] = u_mesh.g_walk[i].u_walk.status_o;
    assign near_said[i] = u_mesh.g_walk[i].u_walk.near_o;
    assign zones_said[i] = u_mesh.g_walk[i].u_walk.zones_o;
  end
  logic same_summary;
  assign same_summary = over[0] == over[1] && said[0] == said[1] && near_said[0] == near_said[1] &&
      zones_said[0] == zones_said[1];

  // --- The intakes ----------------------------------------------------------------------------------------

  typedef logic [1:0][2:0][W-1:0] box_t;
  logic [1:0] same_counts, same_words, same_objects, told;
  `define COMPARE(mesh, u_store) \
  begin : g_``u_store \
    box_t object[2], box[2], group[2]; \
    for (genvar i = 0; i < 2; i++) begin : g_intake \
      for (genvar c = 0; c < 2; c++) begin : g_corner \
        for (genvar k = 0; k < 3; k++) begin : g_axis \
          assign object[i][c][k] = u_mesh.u_store.objects[i][c][k]; \
          assign box[i][c][k] = u_mesh.u_store.boxes[i][c][k]; \
          assign group[i][c][k] = u_mesh.u_store.groups[i][c][k]; \
        end \
      end \
    end \
    assign same_counts[mesh] = u_mesh.u_store.counts[0] == u_mesh.u_store.counts[1] && \
        ^u_mesh.u_store.overfull == 1'b0 && ^u_mesh.u_store.settled == 1'b0; \
    assign same_words[mesh] = ^u_mesh.u_store.writes == 1'b0 && (!u_mesh.u_store.writes[0] || \
        (u_mesh.u_store.indices[0] == u_mesh.u_store.indices[1] && \
         u_mesh.u_store.triangles[0] == u_mesh.u_store.triangles[1] && \
         box[0] == box[1] && group[0] == group[1])); \
    assign same_objects[mesh] = !u_mesh.u_store.settled[0] || u_mesh.u_store.counts[0] == '0 || \
        object[0] == object[1]; \
    assign told[mesh] = u_mesh.u_store.differ_o; \
  end
  `COMPARE(0, u_store_a)
  `COMPARE(1, u_store_b)
  `undef COMPARE

  // --- A clock later --------------------------------------------------------------------------------------

  typedef struct packed {
    logic same_reads;
    logic same_pair;
    logic same_answers;
    logic same_summary;
    logic [1:0] same_counts;
    logic [1:0] same_words;
    logic [1:0] same_objects;
  } known_t;
  known_t known, last_q;
  assign known = '{
          same_reads: same_reads,
          same_pair: same_pair,
          same_answers: same_answers,
          same_summary: same_summary,
          same_counts: same_counts,
          same_words: same_words,
          same_objects: same_objects
      };
  logic unlike, tries_walk, tries_intake, awake_q;
  assign unlike = u_mesh.seen[0] != u_mesh.second;
  assign tries_walk = u_mesh.trial_q.kind == TrialWalk;
  assign tries_intake = u_mesh.trial_q.kind == TrialIntake;
  always_ff @(posedge clk_i) begin
    last_q  <= known;
    awake_q <= rst_ni;
  end

  `TRIAXIS_FULL_AFTER(1)
  always_comb begin
    if (full) AfterReset : assert (awake_q || (!unlike && told == '0));
    if (full && awake_q) begin
      Reads : assert (tries_walk || last_q.same_reads || unlike);
      Pair : assert (tries_walk || last_q.same_pair || unlike);
      Answers : assert (tries_walk || last_q.same_answers || unlike);
      Summary : assert (tries_walk || last_q.same_summary || unlike);
      Counts : assert (tries_intake || (last_q.same_counts | told) == '1);
      Words : assert (tries_intake || (last_q.same_words | told) == '1);
      Objects : assert (tries_intake || (last_q.same_objects | told) == '1);
      SeenAlike :
      cover (!unlike && told == '0 && u_mesh.triangle_read[0] && u_mesh.u_store_a.writes[0]);
      SeenPair : cover (!tries_walk && !last_q.same_pair && last_q.same_reads);
      SeenObject : cover (!tries_intake && last_q.same_objects == '0 && last_q.same_counts == '1);
    end
  end

endmodule
