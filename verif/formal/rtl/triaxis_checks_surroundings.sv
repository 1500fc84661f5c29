// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the ports of the real ones, for what the engine compares, in the proof `engine_checks`.
// Signals named free_* have no driver: the prover chooses them anew each clock, and for each instance.

// A walk: it takes a run, and says at some clock that it is over, with some status: `engine_control`. All
// else that it does is anything, and so is what it shows of that, but for its summary, and that two in a reset
// show the same: `engine_twice`.
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
    input logic [margin_width(M)-1:0] margin_i,
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
    output logic [margin_width(M)-1:0] core_margin_o,
    input logic verdict_valid_i,
    output logic verdict_ready_o,
    input logic verdict_near_i,
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

    output logic [SeenWidth-1:0] seen_o
);

  logic awake_q, running_q, over_q, accept, free_ends;
  status_e status_q, free_status;
  assign accept = s_axis_run_tvalid_i && s_axis_run_tready_o;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {awake_q, running_q, over_q} <= '0;
      status_q <= StatusNone;
    end else begin
      awake_q <= 1'b1;
      if (accept) begin
        running_q <= 1'b1;
        status_q  <= StatusNone;
      end else if (over_q) begin
        if (m_axis_done_tready_i) {running_q, over_q} <= '0;
      end else if (running_q && free_ends) begin
        over_q   <= 1'b1;
        status_q <= free_status;
      end
    end
  end
  assign s_axis_run_tready_o = awake_q && !running_q;
  assign busy_o = running_q;
  assign m_axis_done_tvalid_o = over_q;
  assign status_o = status_q;
  always_comb begin
    SaysSomething : assume (free_status != StatusNone && free_status != StatusFault);
  end

  logic free_row_used, free_box_a_used, free_triangles_used, free_core_valid, free_verdict_ready;
  logic [Lanes-1:0] free_word_used, free_boxes_b_used;
  logic [PairCountWidth-1:0] free_near;
  logic [SeenWidth-summary_width(Depth)-1:0] free_seen;
  assign row_used_o = free_row_used;
  assign word_used_o = free_word_used;
  assign box_a_used_o = free_box_a_used;
  assign boxes_b_used_o = free_boxes_b_used;
  assign triangles_used_o = free_triangles_used;
  assign core_valid_o = free_core_valid;
  assign verdict_ready_o = free_verdict_ready;
  assign near_o = free_near;
  assign seen_o = rst_ni ? {free_seen, m_axis_done_tvalid_o, status_o, near_o} : '0;

endmodule

// A mesh in memory: what is read, whether it is intact, whether the two intakes differ and whether what is
// there is found broken is anything.
module triaxis_mesh_store
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned WordWidth = address_width(Depth / Lanes),
    localparam int unsigned GroupWordWidth = address_width(Depth / Group / Lanes)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    output logic [IndexWidth:0] count_o,
    output logic overfull_o,
    output logic settled_o,
    output logic signed [W-1:0] object_o[2][3],
    output logic [31:0] signature_o,

    input  logic scrub_i,
    output logic broken_o,

    input logic triangle_read_i,
    input logic [IndexWidth-1:0] triangle_index_i,
    output logic [9*W-1:0] triangle_o,
    output logic triangle_intact_o,

    input logic box_read_i,
    input logic [WordWidth-1:0] box_word_i,
    output logic signed [W-1:0] boxes_o[Lanes][2][3],
    output logic [Lanes-1:0] boxes_intact_o,

    input logic group_read_i,
    input logic [GroupWordWidth-1:0] group_word_i,
    output logic signed [W-1:0] group_boxes_o[Lanes][2][3],
    output logic [Lanes-1:0] groups_intact_o,

    // What is tried: words of a memory are taken as broken; the second intake is misread, in each 32nd bit.
    input logic trial_triangles_i,
    input logic trial_boxes_i,
    input logic trial_groups_i,
    input logic trial_intake_i,
    input logic trial_scrub_i,
    input logic [4:0] which_i,
    output logic differ_o
);

  logic free_triangle_intact, free_differ, free_broken;
  logic [Lanes-1:0] free_boxes_intact, free_groups_intact;
  assign triangle_intact_o = free_triangle_intact;
  assign boxes_intact_o = free_boxes_intact;
  assign groups_intact_o = free_groups_intact;
  assign differ_o = free_differ;
  assign broken_o = free_broken;

endmodule

// The core: any verdicts at any clocks.
// verilog_lint: waive module-filename
module triaxis_certified_core
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter int unsigned TAG = 16,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1,
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_tvalid_i,
    output logic s_axis_tready_o,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [$bits(try_t)+TAG+M-1:0] s_axis_tuser_i,

    output logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    output logic [15:0] m_axis_tdata_o,
    output logic [TAG-1:0] m_axis_tuser_o
);

  logic free_ready, free_valid;
  logic [15:0] free_verdict;
  assign s_axis_tready_o = free_ready;
  assign m_axis_tvalid_o = free_valid;
  assign m_axis_tdata_o  = free_verdict;

endmodule
