// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether the machine may go, and says it on two antivalent outputs. All conditions are
// here. There are two on the board: go is that of the one, stop that of the other, so that no single bit of
// either permits anything. Go is said only from the end of a complete run that found nothing near, and only while
// - nothing was changed since that run began: no LOAD, MOVE, RUN, HELLO or ABORT was accepted;
// - nothing went wrong since that run began: no error on the link, no refused command, no fault of the board;
// - the link has been alive since that run began, and when it began: a run that comes after silence,
//   being itself the first sign of life, gives no go; the next one does.
// Otherwise stop is said: from power-up (the registers are configured so), in reset, and until a
// later run. Anything that is neither go nor stop on the outputs is a fault, and means stop.
// Latency: 1 clock.

module triaxis_safety
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned NearWidth = 25
) (
    input logic clk_i,
    input logic rst_ni,
    // Accepted commands.
    input logic hello_i,
    input logic load_i,
    input logic move_i,
    input logic run_i,
    input logic abort_i,
    // Faults.
    input logic link_error_i,
    input logic refused_i,
    input logic alive_i,
    input logic fault_i,
    // The end of a run.
    input logic done_i,
    input status_e engine_status_i,
    input logic [NearWidth-1:0] near_i,

    output logic go_o,
    output logic stop_o
);

  logic changed, fault, clear;
  assign changed = hello_i || load_i || move_i || run_i || abort_i;
  assign fault   = link_error_i || refused_i || !alive_i || fault_i;
  assign clear   = done_i && engine_status_i == StatusComplete && near_i == '0;

  // The values at configuration count. The outputs' registers are kept apart: neither is made from
  // the other.
  // verilator lint_off PROCASSINIT
  logic armed_q = 1'b0;
  (* keep = "true", dont_touch = "true" *)logic go_q = 1'b0;
  (* keep = "true", dont_touch = "true" *)logic stop_q = 1'b1;
  // verilator lint_on PROCASSINIT
  logic armed_d, go_d;

  // Armed: a run is going on, or has ended, that nothing has invalidated.
  assign armed_d = (run_i || (armed_q && !changed)) && !fault;
  assign go_d = (go_q || (armed_q && clear)) && !changed && !fault;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      armed_q <= 1'b0;
      go_q <= 1'b0;
      stop_q <= 1'b1;
    end else begin
      armed_q <= armed_d;
      go_q <= go_d;
      stop_q <= !go_d;
    end
  end

  assign go_o   = go_q;
  assign stop_o = stop_q;

endmodule
