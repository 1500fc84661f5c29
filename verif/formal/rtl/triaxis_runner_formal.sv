// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What is said of a run is what the engine said at its end: every number of the summary, and the zones, whole,
// until the next run or HELLO; zeros before, and from a reset on. Its number, pose, mode, margins, trial and
// hold are those it was started with.

`include "triaxis_formal.svh"

module triaxis_runner_formal
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    localparam int unsigned RunBits = move_width(W)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic forget_i,
    input logic run_i,
    input logic abort_i,
    input logic [8*FieldBytes-1:0] fields_i,
    input logic done_tvalid_i,
    input status_e done_status_i,
    input logic [Zones-1:1] done_zones_i,
    input summary_t done_summary_i
);

  logic busy_o, aborting_o, run_tvalid_o;
  pose_t run_pose_o;
  byte_t run_number_o;
  run_state_e run_state_o;
  logic [1:0] run_mode_o;
  logic [31:0] run_margin_o;
  trial_t run_trial_o;
  hold_t run_hold_o;
  status_e engine_status_o;
  logic [Zones-1:1] zones_o;
  summary_t summary_o;
  logic [3*RunBits-1:0] run_tdata_o;
  logic [run_user_width(M)-1:0] run_tuser_o;

  triaxis_runner #(
      .W(W),
      .M(M)
  ) u_runner (
      .seen_o(),
      .*
  );

  `TRIAXIS_RESET_FIRST

  logic [2:0] commands;
  assign commands = {forget_i, run_i, abort_i};
  always_comb begin
    OneAtATime : assume ((commands & (commands - 3'd1)) == '0);
    NotInRuns : assume (!busy_o || !(forget_i || run_i));
    EndsRuns : assume (busy_o || !done_tvalid_i);
    NoneInReset : assume (rst_ni || !run_i);
  end

  // What has happened since the last HELLO, event by event.
  typedef struct packed {
    logic [Zones-1:0][31:0] margins;
    logic [1:0] mode;
    trial_t trial;
    hold_t hold;
  } asked_t;
  logic going_q, over_q, aborted_q;
  summary_t told_q;
  logic [Zones-1:1] zones_q;
  status_e status_q;
  pose_t begun_q;
  asked_t asked_q;
  byte_t runs_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {going_q, over_q, aborted_q} <= '0;
      {begun_q, asked_q, runs_q}   <= '0;
    end else if (forget_i) begin
      {going_q, over_q, aborted_q} <= '0;
      {begun_q, asked_q, runs_q}   <= '0;
    end else begin
      if (run_i) begin
        {going_q, over_q, aborted_q} <= 3'b100;
        begun_q <= fields_i[239:144];
        asked_q <= '{
            margins: fields_i[103:8],
            mode: fields_i[1:0],
            trial: fields_i[143:136],
            hold: fields_i[255:240]
        };
        runs_q <= runs_q + 8'd1;
      end
      if (abort_i && going_q) aborted_q <= 1'b1;
      if (done_tvalid_i) {going_q, over_q} <= 2'b01;
    end
  end
  always_ff @(posedge clk_i) begin
    if (done_tvalid_i) begin
      told_q   <= done_summary_i;
      zones_q  <= done_zones_i;
      status_q <= done_status_i;
    end
  end

  logic [3*RunBits-1:0] run_pose;
  for (genvar k = 0; k < 3; k++) begin : g_pose
    assign run_pose[k*RunBits+:RunBits] = run_pose_o[k][RunBits-1:0];
  end

  always_comb begin
    if (rst_ni) begin
      Going : assert (busy_o == going_q);
      State : assert (run_state_o == (going_q ? RunGoing : over_q ? RunDone : RunNever));
      Aborting : assert (aborting_o == (going_q && aborted_q));
      Told : assert (summary_o == (over_q ? told_q : '0));
      Zoned : assert (zones_o == (over_q ? zones_q : '0));
      Status : assert (engine_status_o == (over_q ? status_q : StatusNone));
      Number : assert (run_number_o == runs_q);
      Started : assert (run_pose_o == begun_q);
      Asked :
      assert ({run_margin_o, run_mode_o, run_trial_o, run_hold_o} ==
              {asked_q.margins[ZoneMargin], asked_q.mode, asked_q.trial, asked_q.hold});
      if (run_tvalid_o) begin
        Handed :
        assert (going_q && run_tuser_o == {asked_q.trial, asked_q.mode,
                asked_q.margins[ZoneWarn][M-1:0], asked_q.margins[ZoneSlow][M-1:0],
                asked_q.margins[ZoneMargin][M-1:0]});
        HandedPose : assert (run_tdata_o == run_pose);
      end
      // What makes it inductive.
      assert (u_runner.margins_q == asked_q.margins);
      assert (going_q || over_q || {begun_q, asked_q} == '0);
      SeenLong : cover (over_q && summary_o.cycles[31] && run_number_o == 8'd2);
    end
  end

endmodule
