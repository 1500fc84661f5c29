// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the engine's runs: what they are asked with, their number, and the summary of the last.
// While a run is going on its summary reads zero. Runs are kept twice on the board, and seen_o is what two
// runners must have alike.
// Widths: a pose has W+1 bits a coordinate, at most 32 of which a RUN can give; the engine's numbers
// are at most 32 bits (Depth <= 32,768).
// Latency: 1 clock.

module triaxis_runner
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    localparam int unsigned RunBits = move_width(W)
) (
    input logic clk_i,
    input logic rst_ni,
    // Commands, a clock each. None but abort_i comes while busy_o.
    input logic forget_i,
    input logic run_i,
    input logic abort_i,
    input logic [8*FieldBytes-1:0] fields_i,

    output logic busy_o,
    output logic aborting_o,
    output byte_t run_number_o,
    output run_state_e run_state_o,
    output logic [1:0] run_mode_o,
    output pose_t run_pose_o,
    output logic [31:0] run_margin_o,
    output trial_t run_trial_o,
    output hold_t run_hold_o,
    output status_e engine_status_o,
    output logic [Zones-1:1] zones_o,
    output summary_t summary_o,

    output logic run_tvalid_o,  // taken at once: no run is going on
    output logic [3*RunBits-1:0] run_tdata_o,
    output logic [run_user_width(M)-1:0] run_tuser_o,
    // The summary is taken at once.
    input logic done_tvalid_i,
    input status_e done_status_i,
    input logic [Zones-1:1] done_zones_i,
    input summary_t done_summary_i,

    output logic [RunnerSeenWidth-1:0] seen_o
);

  logic [1:0] mode_q;
  logic [Zones-1:0][31:0] margins_q;
  trial_t trial_q;
  hold_t hold_q;
  logic waiting_q;  // the engine takes the run in this clock
  logic aborting_q;
  pose_t pose_q;
  byte_t run_number_q;
  run_state_e run_state_q;
  status_e engine_status_q;
  logic [Zones-1:1] zones_q;
  summary_t summary_q;

  run_fields_t asked;
  assign asked = fields_i[0+:$bits(asked)];

  assign busy_o = run_state_q == RunGoing;
  assign aborting_o = aborting_q;
  assign run_number_o = run_number_q;
  assign run_state_o = run_state_q;
  assign run_mode_o = mode_q;
  assign run_pose_o = pose_q;
  assign run_margin_o = margins_q[ZoneMargin];
  assign run_trial_o = trial_q;
  assign run_hold_o = hold_q;
  assign engine_status_o = engine_status_q;
  assign zones_o = zones_q;
  assign summary_o = summary_q;

  assign run_tvalid_o = waiting_q;
  for (genvar k = 0; k < 3; k++) begin : g_pose
    assign run_tdata_o[k*RunBits+:RunBits] = RunBits'($signed(pose_q[k]));
  end
  assign run_tuser_o[Zones*M+:$bits(mode_e)] = mode_q;
  assign run_tuser_o[Zones*M+$bits(mode_e)+:$bits(trial_t)] = trial_q;
  if (M > 0) begin : g_margins
    for (genvar z = 0; z < Zones; z++) begin : g_zone
      assign run_tuser_o[z*M+:M] = margins_q[z][M-1:0];
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      waiting_q <= 1'b0;
      aborting_q <= 1'b0;
      run_number_q <= '0;
      run_state_q <= RunNever;
      engine_status_q <= StatusNone;
    end else begin
      waiting_q <= run_i;
      if (done_tvalid_i) aborting_q <= 1'b0;
      else if (abort_i) aborting_q <= busy_o;
      if (run_i) begin
        run_number_q <= run_number_q + 8'd1;
        run_state_q <= RunGoing;
        engine_status_q <= StatusNone;
      end
      if (done_tvalid_i) begin
        run_state_q <= RunDone;
        engine_status_q <= done_status_i;
      end
      if (forget_i) begin
        run_number_q <= '0;
        run_state_q <= RunNever;
        engine_status_q <= StatusNone;
      end
    end
  end

  // Zeros as long as there was no run, so from a reset on too: set by the clock, which takes no logic of theirs.
  logic never;
  assign never = forget_i || run_state_q == RunNever;
  always_ff @(posedge clk_i) begin
    if (never && !run_i) begin
      mode_q <= '0;
      margins_q <= '0;
      trial_q <= '0;
      hold_q <= '0;
      pose_q <= '0;
    end else if (run_i) begin
      mode_q <= asked.mode[1:0];
      margins_q <= asked.margins;
      trial_q <= asked.trial;
      hold_q <= asked.hold;
      pose_q <= asked.pose;
    end
    if (never || run_i) begin
      zones_q   <= '0;
      summary_q <= '0;
    end else if (done_tvalid_i) begin
      zones_q   <= done_zones_i;
      summary_q <= done_summary_i;
    end
  end

  // What the judge has looked at.
  logic [37:0] unused_asked;
  assign unused_asked = {asked.count_a, asked.count_b, asked.mode[7:2]};

  assign seen_o = {
    waiting_q,
    aborting_q,
    run_state_q,
    mode_q,
    margins_q,
    trial_q,
    hold_q,
    pose_q,
    run_number_q,
    engine_status_q,
    zones_q,
    summary_q
  };

endmodule
