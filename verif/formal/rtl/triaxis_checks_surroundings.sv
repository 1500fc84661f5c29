// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the real ones' headers, for what the engine compares, in the proof `engine_checks`.
// Signals named free_* have no driver: the prover chooses them anew each clock, and for each instance.

// A walk: it takes a run, and says at some clock that it is over, with some status: `engine_control`. All
// else that it does is anything, and so is what it shows of that a clock later, but that two after a reset show
// the same: `engine_twice`.
module triaxis_walk;

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
  logic [Zones-1:1] free_zones;
  logic [SeenWidth-1:0] free_seen;
  assign row_used_o = free_row_used;
  assign word_used_o = free_word_used;
  assign box_a_used_o = free_box_a_used;
  assign boxes_b_used_o = free_boxes_b_used;
  assign triangles_used_o = free_triangles_used;
  assign core_valid_o = free_core_valid;
  assign verdict_ready_o = free_verdict_ready;
  assign near_o = free_near;
  assign zones_o = free_zones;
  always_ff @(posedge clk_i) seen_o <= rst_ni ? free_seen : '0;

endmodule

// A mesh in memory: what is read, whether it is intact, whether the two intakes differ and whether what is
// there is found broken is anything.
module triaxis_mesh_store;

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
module triaxis_certified_core;

  logic free_ready, free_valid;
  logic [15:0] free_verdict;
  assign s_axis_tready_o = free_ready;
  assign m_axis_tvalid_o = free_valid;
  assign m_axis_tdata_o  = free_verdict;

endmodule
