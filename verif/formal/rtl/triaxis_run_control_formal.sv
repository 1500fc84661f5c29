// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The course of a run: what its summary may say, that it waits unchanged, and that no run which was
// cut short is ever complete; and its margins: no zone is narrower than the one within it, and what is
// skipped is further than the widest; which are wider is told from the clock after it is accepted on. Idle,
// first and aborts come at any clocks.

`include "triaxis_formal.svh"

module triaxis_run_control_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 8,
    parameter int unsigned M = 8,
    parameter int unsigned CycleBits = 4
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_run_tvalid_i,
    input logic [1:0] mode_i,
    input logic abort_i,
    input logic settled_i,
    input logic overfull_i,
    input logic empty_a_i,
    input logic empty_i,
    input logic signed [W-1:0] low_i,
    input logic signed [move_width(W)-1:0] asked_i,
    input logic [Zones-1:0][M-1:0] margins_i,
    input logic idle_i,
    input logic first_i,
    input logic m_axis_done_tready_i
);

  typedef logic [CycleBits-1:0] cycles_t;
  typedef logic signed [W+3:0] wide_t;
  typedef logic [Zones-1:0][M-1:0] margins_t;
  // States, by their places in the enumeration.
  localparam logic [2:0] Settle = 3'd2, Check = 3'd3;
  localparam logic [2:0] Scan = 3'd5;

  logic s_axis_run_tready_o, busy_o, clear_o, start_o, drain_o, m_axis_done_tvalid_o;
  margins_t margins_o;
  logic [Zones-1:1] wider_o;
  mode_e mode_o;
  status_e status_o;
  cycles_t cycles_o;
  logic signed [move_width(W)-1:0] move_i[3], move_o[3];
  logic signed [grown_width(W)-1:0] shift_o[2][3];
  logic signed [W-1:0] object_a_i[2][3];
  assign move_i = '{default: asked_i};
  assign object_a_i = '{default: low_i};

  triaxis_run_control #(
      .W(W),
      .MarginWidth(M),
      .CycleBits(CycleBits)
  ) u_control (
      .*
  );

  `TRIAXIS_RESET_FIRST

  // Of the run under way: whether it was told to end early, whether it was drained, whether its scan
  // began, its clocks.
  logic aborted_q, drained_q, scanned_q, waited_q, running_q, cleared_q, awake_q;
  logic accept;
  cycles_t cycles_q, reported_q;
  status_e status_q;
  assign accept = s_axis_run_tvalid_i && s_axis_run_tready_o;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {aborted_q, drained_q, scanned_q, waited_q, running_q, cleared_q, awake_q} <= '0;
    end else begin
      awake_q  <= 1'b1;
      waited_q <= m_axis_done_tvalid_o && !m_axis_done_tready_i;
      if (accept) begin
        running_q <= 1'b1;
        {aborted_q, drained_q, scanned_q} <= '0;
      end else begin
        if (m_axis_done_tvalid_o && m_axis_done_tready_i) running_q <= 1'b0;
        if (running_q && abort_i && !m_axis_done_tvalid_o) aborted_q <= 1'b1;
        if (drain_o) drained_q <= 1'b1;
        if (start_o) scanned_q <= 1'b1;
      end
      // What is counted in a run begins at 0.
      if (clear_o) cleared_q <= 1'b1;
      else if (!running_q) cleared_q <= 1'b0;
    end
  end
  always_ff @(posedge clk_i) begin
    status_q   <= status_o;
    reported_q <= cycles_o;
    if (accept) cycles_q <= cycles_t'(1);
    else if (running_q && !m_axis_done_tvalid_o && cycles_q != '1)
      cycles_q <= cycles_q + cycles_t'(1);
  end

  logic was_idle_q, was_first_q, empty_q;
  always_ff @(posedge clk_i) begin
    was_idle_q <= idle_i;
    if (!m_axis_done_tvalid_o) was_first_q <= first_i;
    empty_q <= empty_i;
  end

  // The margins, and where it goes, that the run was asked for.
  margins_t margins_q;
  logic [Zones-1:1] wider_right, wider_q;
  logic wide_q;
  logic signed [move_width(W)-1:0] move_q;
  wide_t widest;
  assign widest = wide_t'({4'b0, margins_o[ZoneWarn]});
  logic [2:0] shift_right;
  for (genvar k = 0; k < 3; k++) begin : g_shift
    assign shift_right[k] = wide_t'(shift_o[0][k]) == wide_t'(move_q) - widest &&
        wide_t'(shift_o[1][k]) == wide_t'(move_q) + widest;
  end
  for (genvar z = 1; z < Zones; z++) begin : g_wider
    assign wider_right[z] = wider_o[z] == (margins_o[z] > margins_o[z-1]);
  end
  always_ff @(posedge clk_i) begin
    wider_q <= wider_o;
    wide_q  <= running_q;
    if (accept) begin
      margins_q <= margins_i;
      move_q <= asked_i;
    end
  end

  always_comb begin
    FirstStays : assume (!drain_o || !was_first_q || first_i);
    if (rst_ni) begin
      // What users see.
      Busy : assert (busy_o == running_q);
      OneAtATime : assert (!busy_o || !s_axis_run_tready_o);
      TakenAtOnce : assert (busy_o || s_axis_run_tready_o || !awake_q);
      OnlyInARun :
      assert (busy_o || !(m_axis_done_tvalid_o || drain_o || start_o || (clear_o && !accept)));
      Waits :
      assert (!waited_q ||
              (m_axis_done_tvalid_o && status_o == status_q && cycles_o == reported_q));
      Cycles : assert (!running_q || cycles_o == cycles_q);
      if (m_axis_done_tvalid_o) begin
        SaysSomething : assert (status_o != StatusNone && status_o != StatusFault);
        NeverCompleteIfCut : assert (status_o != StatusComplete || (!aborted_q && !drained_q));
        AbortedIsSaid : assert (!aborted_q || status_o == StatusAborted || status_o == StatusFirst);
        AbortedIsMeant : assert (status_o != StatusAborted || (aborted_q && drained_q));
        FirstIsMeant : assert (status_o != StatusFirst || (drained_q && was_first_q));
        RefusedIsNotRun :
        assert (!(status_o inside {StatusOverflow, StatusOverfull, StatusBadMode}) || !scanned_q);
      end
      BadModeIsRefused : assert (mode_o != ModeNone || !(start_o || (running_q && scanned_q)));
      Stays : assert (!awake_q || running_q || (status_o == status_q && cycles_o == reported_q));
      ClearedBefore : assert (!start_o || cleared_q);
      // Complete: nothing was left to do when it was said.
      CompleteIfIdle :
      assert (waited_q || !m_axis_done_tvalid_o || status_o != StatusComplete ||
              (scanned_q ? was_idle_q : empty_q));
      // From before the scan on.
      if (running_q && u_control.state_q != Settle) begin
        MarginAsAsked : assert (margins_o[ZoneMargin] == margins_q[ZoneMargin]);
        Ordered :
        assert (margins_o[ZoneMargin] <= margins_o[ZoneSlow] &&
                margins_o[ZoneSlow] <= margins_o[ZoneWarn]);
        ZonesAsAsked :
        assert ((margins_o[ZoneSlow] == margins_q[ZoneSlow] ||
                 (margins_o[ZoneSlow] == margins_o[ZoneMargin] &&
                  margins_q[ZoneSlow] < margins_o[ZoneSlow])) &&
                (margins_o[ZoneWarn] == margins_q[ZoneWarn] ||
                 (margins_o[ZoneWarn] == margins_o[ZoneSlow] &&
                  margins_q[ZoneWarn] < margins_o[ZoneWarn])));
        WiderIsWider : assert (wider_right == '1);
      end
      // Where what is found begins anew, it is known already.
      if (running_q && wide_q) WiderStays : assert (wider_o == wider_q);
      ShiftsByWidest : assert (!(start_o || u_control.state_q == Scan) || shift_right == '1);
      // What makes it inductive: where the ghosts and the state agree.
      assert (!running_q || u_control.asked_q == margins_q);
      for (int k = 0; k < 3; k++) assert (!running_q || move_o[k] == move_q);
      Clearing : assert (u_control.state_q != Settle || cleared_q || clear_o);
      Cleared : assert (u_control.state_q != Check || cleared_q);
      Drained : assert (!drained_q || !running_q || drain_o || m_axis_done_tvalid_o);
      DrainsForAReason : assert (!drain_o || aborted_q || was_first_q);
      Aborted : assert (!running_q || !aborted_q || drain_o || m_axis_done_tvalid_o);
      Scanned :
      assert (!running_q || scanned_q == (u_control.state_q == Scan) || drain_o ||
              m_axis_done_tvalid_o);
      SeenComplete : cover (m_axis_done_tvalid_o && status_o == StatusComplete && scanned_q);
      SeenFirst : cover (m_axis_done_tvalid_o && status_o == StatusFirst && waited_q);
      SeenAborted : cover (m_axis_done_tvalid_o && status_o == StatusAborted && scanned_q);
      SeenOverflow : cover (m_axis_done_tvalid_o && status_o == StatusOverflow);
      SeenZones :
      cover (start_o && margins_o[ZoneSlow] > margins_o[ZoneMargin] &&
             margins_o[ZoneWarn] > margins_q[ZoneWarn]);
      SeenMostCycles : cover (m_axis_done_tvalid_o && cycles_o == '1);
    end
  end

endmodule
