// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether the machine may go, and says it on two antivalent outputs. All conditions are
// here. There are two on the board: go is that of the one, stop that of the other, and what is beyond a zone
// both must say, so that no single bit of either permits anything. Go is said only from the end of a complete
// run that found nothing near, and only while
// - nothing was changed since that run began: no LOAD, HELLO or ABORT was accepted, and no RUN but one
//   that holds (below);
// - nothing went wrong since that run began: no error on the link, no refused command, no fault of the board;
// - the link has been alive since that run began, and when it began: a run that comes after silence,
//   being itself the first sign of life, gives no go; the next one does;
// - its hold, if it has one, is not over.
// A run that holds checks where a moving machine is going to be while it is where the runs before permit it to
// be: go stays while it goes on, until the deadline of the one before. Ends it clear in time, go stays, and its
// own hold begins; ends it in another way, go ends with it. Go that has ended so does not come back before a
// run that begins later.
// Beyond a zone is said with go where the last clear run looked at that zone, and found nothing in it.
// Otherwise stop is said: from power-up (the registers are configured so), in reset, and until a
// later run. Anything that is neither go nor stop on the outputs is a fault, and means stop.
// Widths: hold_t counts HoldClocks clocks each; within one, 0 .. HoldClocks - 1.
// Latency: 1 clock. Go that is not renewed is said for hold * HoldClocks clocks.

module triaxis_safety
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned NearWidth  = 25,
    parameter int unsigned HoldClocks = ClocksPerMs
) (
    input logic clk_i,
    input logic rst_ni,
    // Accepted commands.
    input logic hello_i,
    input logic load_i,
    input logic run_i,
    input logic keep_i,  // with run_i: it holds
    input logic abort_i,
    // Faults.
    input logic link_error_i,
    input logic refused_i,
    input logic alive_i,
    input logic fault_i,
    // The end of a run, and its hold.
    input logic done_i,
    input status_e engine_status_i,
    input logic [NearWidth-1:0] near_i,
    input logic [Zones-1:1] zones_i,
    input hold_t hold_i,

    output logic go_o,
    output logic stop_o,
    output logic [Zones-1:1] beyond_o
);

  typedef logic [$clog2(HoldClocks+1)-1:0] part_t;

  logic changed, fault, clear, late;
  assign changed = hello_i || load_i || (run_i && !keep_i) || abort_i;
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
  assign armed_d = (run_i || (armed_q && !changed && !late)) && !fault;
  assign go_d = ((go_q && !late && !done_i) || (armed_q && clear)) && !changed && !fault;

  // The deadline of the last run that was clear: this is the last clock before it. What ends in it is in time.
  logic  timed_q;
  hold_t left_q;
  part_t part_q;
  logic  last;
  assign last = part_q == '0;
  assign late = go_q && timed_q && last && left_q == hold_t'(1) && !done_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      timed_q <= 1'b0;
      left_q  <= '0;
      part_q  <= '0;
    end else if (armed_q && clear) begin
      timed_q <= hold_i != '0;
      left_q  <= hold_i;
      part_q  <= part_t'(HoldClocks - 1);
    end else if (last) begin
      left_q <= left_q - hold_t'(1);
      part_q <= part_t'(HoldClocks - 1);
    end else begin
      part_q <= part_q - part_t'(1);
    end
  end

  logic [Zones-1:1] zones_d, zones_q;
  assign zones_d = (armed_q && clear) ? zones_i : zones_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      zones_q  <= '1;
      beyond_o <= '0;
    end else begin
      zones_q  <= zones_d;
      beyond_o <= go_d ? ~zones_d : '0;
    end
  end

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
