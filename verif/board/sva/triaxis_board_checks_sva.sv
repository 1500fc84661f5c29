// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the checks of the board look at, bound from outside the RTL: without an upset two runners are alike
// whatever they show of themselves, so no answer tells what is compared. And what the decision of go keeps over a
// reset, which rests on nothing of it.

module triaxis_runner_sva
  import triaxis_board_pkg::*;
(
    input logic clk_i,
    input logic rst_ni,
    input logic forget,
    input logic [RunnerSeenWidth-1:0] seen,
    input logic [RunnerSeenWidth-1:0] due,
    input run_fields_t asked,
    input logic [7:0] number
);

  RunnerShowsAll :
  assert property (@(posedge clk_i) disable iff (!rst_ni) seen == due)
  else $error("what is compared of a runner is not all that rests on it");

  NothingInReset :
  assert property (@(posedge clk_i) !rst_ni && $past(!rst_ni) |=> due == '0)
  else $error("after two clocks of reset a runner keeps something of a run");

  ForgottenByHello :
  assert property (@(posedge clk_i) disable iff (!rst_ni) forget |=> asked == '0 && number == '0)
  else $error("a runner keeps what a session before has asked for");

endmodule

// verilog_lint: waive module-filename
module triaxis_runners_sva
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
(
    input logic clk_i,
    input logic rst_ni,
    input logic busy,
    input trial_t trial,
    input logic [RunnerSeenWidth-1:0] misread,
    input logic trying_frame
);

  // The highest number has frames taken as broken.
  localparam int unsigned Step = 31;
  logic [RunnerSeenWidth-1:0] wrong;
  always_comb begin
    wrong = '0;
    if (32'(trial.which) < Step) begin
      for (int unsigned i = 32'(trial.which); i < RunnerSeenWidth; i += Step) begin
        wrong[i] = busy && trial.kind == TrialBoard;
      end
    end
  end

  RunnerMisreadAsAsked :
  assert property (@(posedge clk_i) disable iff (!rst_ni) misread == wrong)
  else $error("other bits of the second runner are misread than the run tries");

  FrameTriedAsAsked :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      trying_frame == (busy && trial.kind == TrialBoard && 32'(trial.which) == Step))
  else $error("a frame is taken as broken, and the run does not try it; or the other way");

endmodule

// verilog_lint: waive module-filename
module triaxis_decision_sva
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned PartWidth = 17
) (
    input logic clk_i,
    input logic rst_ni,
    input logic armed,
    input logic [Zones-1:1] zones,
    input logic timed,
    input hold_t left,
    input logic [PartWidth-1:0] part
);

  // With two states the reset of power-up is no edge: the zones are as in reset from the first clock on.
  logic begun = 1'b0;
  always_ff @(posedge clk_i) begun <= 1'b1;

  ForgottenInReset :
  assert property (@(posedge clk_i) rst_ni ||
      (!armed && (zones == '1 || !begun) && !timed && left == '0 && part == '0))
  else $error("in reset a run is armed, found nothing in a zone, or has a hold that goes on");

endmodule

bind triaxis_runner triaxis_runner_sva u_shown_sva (
    .clk_i,
    .rst_ni,
    .forget(forget_i),
    .seen(seen_o),
    .due({
      run_tvalid_o,
      aborting_o,
      run_state_o,
      run_mode_o,
      margins_q[Zones-1:1],
      run_margin_o,
      run_trial_o,
      run_hold_o,
      run_pose_o,
      run_number_o,
      engine_status_o,
      zones_o,
      summary_o
    }),
    .asked(
    '{
        mode: 8'(run_mode_o),
        margins: {margins_q[Zones-1:1], run_margin_o},
        count_a: '0,
        count_b: '0,
        trial: run_trial_o,
        pose: run_pose_o,
        hold: run_hold_o
    }
    ),
    .number(run_number_o)
);

bind nexys4ddr_top triaxis_runners_sva u_runners_sva (
    .clk_i (clk_100mhz_i),
    .rst_ni(rst_n),
    .busy,
    .trial,
    .misread,
    .trying_frame
);

bind triaxis_safety triaxis_decision_sva #(
    .PartWidth($bits(part_t))
) u_decision_sva (
    .clk_i,
    .rst_ni,
    .armed(armed_q),
    .zones(zones_q),
    .timed(timed_q),
    .left (left_q),
    .part (part_q)
);
