// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the course of a run: accept it, wait until loaded triangles have settled, refuse what
// cannot be run, scan, drain where it ends early, report. start_o resets the counters and starts
// the scan.
// A zone that is not wider than the one within it is as wide as that one, and nothing is ever beyond it.
// Widths: A moved is compared in W+2 bits signed: |object + move| <= 2^(W-1) + 2^W. Cycles are
// counted from the accepting edge until the summary is offered, and stay at the largest number.
// Latency: 3 from the accepting edge to start_o, or to the summary of a run that is refused.

module triaxis_run_control
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned MarginWidth = 1,
    parameter int unsigned CycleBits = 32
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_run_tvalid_i,
    output logic s_axis_run_tready_o,
    input logic signed [move_width(W)-1:0] move_i[3],
    input logic [Zones-1:0][MarginWidth-1:0] margins_i,
    input logic [1:0] mode_i,
    input logic abort_i,
    output logic busy_o,

    input logic settled_i,
    input logic overfull_i,
    input logic empty_a_i,
    input logic empty_i,
    input logic signed [W-1:0] object_a_i[2][3],

    output logic signed [move_width(W)-1:0] move_o[3],
    output logic signed [grown_width(W)-1:0] shift_o[2][3],
    output logic [Zones-1:0][MarginWidth-1:0] margins_o,
    output logic [Zones-1:1] wider_o,  // than the zone inside it, once the run was accepted
    output mode_e mode_o,
    output logic clear_o,
    output logic start_o,
    output logic drain_o,
    input logic idle_i,
    input logic first_i,

    output logic m_axis_done_tvalid_o,
    input logic m_axis_done_tready_i,
    output status_e status_o,
    output logic [CycleBits-1:0] cycles_o
);

  typedef logic signed [grown_width(W)-1:0] grown_t;
  typedef logic [CycleBits-1:0] cycles_t;
  typedef enum logic [2:0] {
    StateReset,
    StateIdle,
    StateSettle,
    StateCheck,
    StateStart,
    StateScan,
    StateDrain,
    StateReport
  } state_e;

  localparam grown_t Highest = grown_t'((64'sd1 <<< (W - 1)) - 64'sd1);
  localparam grown_t Lowest = grown_t'(-(64'sd1 <<< (W - 1)));

  state_e state_q, state_d;
  status_e status_d;
  logic accept, overflow_d, overflow_q;
  logic [2:0] beyond;
  logic [Zones-1:0][MarginWidth-1:0] asked_q;
  logic [MarginWidth-1:0] slow;

  assign accept = s_axis_run_tvalid_i && s_axis_run_tready_o;
  assign s_axis_run_tready_o = state_q == StateIdle;
  assign busy_o = state_q != StateIdle && state_q != StateReset;
  assign clear_o = state_q == StateSettle;
  assign start_o = state_q == StateStart;
  assign drain_o = state_q == StateDrain;
  assign m_axis_done_tvalid_o = state_q == StateReport;

  // --- What was asked for -----------------------------------------------------------------------------

  always_ff @(posedge clk_i) begin
    if (accept) begin
      move_o  <= move_i;
      asked_q <= margins_i;
      mode_o  <= mode_e'(mode_i);
    end
  end

  assign wider_o[ZoneSlow] = asked_q[ZoneSlow] > asked_q[ZoneMargin];
  assign wider_o[ZoneWarn] = asked_q[ZoneWarn] > slow;
  assign slow = wider_o[ZoneSlow] ? asked_q[ZoneSlow] : asked_q[ZoneMargin];
  always_ff @(posedge clk_i) begin
    margins_o[ZoneMargin] <= asked_q[ZoneMargin];
    margins_o[ZoneSlow]   <= slow;
    margins_o[ZoneWarn]   <= wider_o[ZoneWarn] ? asked_q[ZoneWarn] : slow;
  end

  for (genvar k = 0; k < 3; k++) begin : g_axis
    always_ff @(posedge clk_i) begin
      shift_o[0][k] <= grown_t'(move_o[k]) - grown_t'({1'b0, margins_o[ZoneWarn]});
      shift_o[1][k] <= grown_t'(move_o[k]) + grown_t'({1'b0, margins_o[ZoneWarn]});
    end
    assign beyond[k] = grown_t'(object_a_i[0][k]) + grown_t'(move_o[k]) < Lowest ||
        grown_t'(object_a_i[1][k]) + grown_t'(move_o[k]) > Highest;
  end
  assign overflow_d = !empty_a_i && beyond != '0;
  always_ff @(posedge clk_i) overflow_q <= overflow_d;

  // --- The course of a run ------------------------------------------------------------------------------

  always_comb begin
    state_d  = state_q;
    status_d = status_o;
    unique case (state_q)
      StateIdle: begin
        if (accept) begin
          state_d  = StateSettle;
          status_d = StatusNone;
        end
      end
      StateSettle: begin
        if (settled_i) state_d = StateCheck;
      end
      StateCheck: begin
        state_d = StateReport;
        if (mode_o == ModeNone) status_d = StatusBadMode;
        else if (overfull_i) status_d = StatusOverfull;
        else if (overflow_q) status_d = StatusOverflow;
        else if (empty_i) status_d = StatusComplete;
        else state_d = StateStart;
      end
      StateStart: state_d = StateScan;
      StateScan: begin
        if (first_i) state_d = StateDrain;
        else if (idle_i) begin
          state_d  = StateReport;
          status_d = StatusComplete;
        end
      end
      StateDrain: begin
        if (idle_i) begin
          state_d  = StateReport;
          status_d = first_i ? StatusFirst : StatusAborted;
        end
      end
      StateReport: begin
        if (m_axis_done_tready_i) state_d = StateIdle;
      end
      // The clock after reset.
      default: state_d = StateIdle;
    endcase
    // Refused or aborted: whatever else was to come next does not.
    if (abort_i && state_q inside {StateSettle, StateCheck, StateStart, StateScan}) begin
      state_d  = StateDrain;
      status_d = status_o;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q  <= StateReset;
      status_o <= StatusNone;
    end else begin
      state_q  <= state_d;
      status_o <= status_d;
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) cycles_o <= '0;
    else if (accept) cycles_o <= cycles_t'(1);
    else if (busy_o && state_q != StateReport && cycles_o != '1)
      cycles_o <= cycles_o + cycles_t'(1);
  end

endmodule
