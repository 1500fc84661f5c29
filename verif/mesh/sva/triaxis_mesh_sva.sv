// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Rules of the mesh engine's streams and of its account of pairs, bound from outside the RTL.

module triaxis_mesh_sva
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned LoadWidth = 146,
    parameter int unsigned RunWidth = 69,
    parameter int unsigned NearWidth = 24,
    parameter int unsigned CountersWidth = 32
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_load_tvalid_i,
    input logic s_axis_load_tready_o,
    input logic [LoadWidth-1:0] load_beat,
    input logic s_axis_run_tvalid_i,
    input logic s_axis_run_tready_o,
    input logic [RunWidth-1:0] run_beat,
    input logic abort_i,
    input logic busy_o,
    input logic m_axis_near_tvalid_o,
    input logic m_axis_near_tready_i,
    input logic [NearWidth-1:0] m_axis_near_tdata_o,
    input logic m_axis_done_tvalid_o,
    input logic m_axis_done_tready_i,
    input logic [CountersWidth-1:0] counters,
    input status_e status_o,
    input logic [Zones-1:1] zones_o,
    input logic [Zones-1:1] wider,  // than the zone within
    input logic [63:0] group_pairs,
    input logic [63:0] group_pairs_decided,
    input logic [63:0] tested,
    input logic [63:0] near,
    input logic tries,
    input logic fault_o
);

  // What is offered and not taken stays as it is.
  NearStable :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_near_tvalid_o && !m_axis_near_tready_i |=>
      m_axis_near_tvalid_o && $stable(
      m_axis_near_tdata_o
  ))
  else $error("a near pair changed while it waited");

  SummaryStable :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o && !m_axis_done_tready_i |=>
      m_axis_done_tvalid_o && $stable(
      status_o
  ) && $stable(
      counters
  ))
  else $error("a summary changed while it waited");

  // Its values can be read until the next run is accepted.
  logic run_accepted;
  assign run_accepted = s_axis_run_tvalid_i && s_axis_run_tready_o;

  SummaryKept :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      (m_axis_done_tvalid_o || !busy_o) && !run_accepted |=> $stable(
      status_o
  ) && $stable(
      counters
  ))
  else $error("a summary changed although no run was accepted");

  // The same rule for whoever drives the inputs.
  TriangleHeld :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      s_axis_load_tvalid_i && !s_axis_load_tready_o |=> s_axis_load_tvalid_i && $stable(
      load_beat
  ))
  else $error("a triangle was withdrawn or changed while it waited");

  RunHeld :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      s_axis_run_tvalid_i && !s_axis_run_tready_o |=> s_axis_run_tvalid_i && $stable(
      run_beat
  ))
  else $error("a run was withdrawn or changed while it waited");

  TriangleWithdrawnInReset :
  assert property (@(posedge clk_i) !rst_ni && $past(
      !rst_ni && s_axis_load_tvalid_i
  ) |-> !s_axis_load_tvalid_i)
  else $error("a triangle is offered on and on in a reset");

  RunWithdrawnInReset :
  assert property (@(posedge clk_i) !rst_ni && $past(
      !rst_ni && s_axis_run_tvalid_i
  ) |-> !s_axis_run_tvalid_i)
  else $error("a run is offered on and on in a reset");

  // A run has the meshes to itself, from its acceptance until its summary is taken.
  NotLoadedWhileBusy :
  assert property (@(posedge clk_i) disable iff (!rst_ni) busy_o |-> !s_axis_load_tready_o)
  else $error("ready to load during a run");

  OneRunAtATime :
  assert property (@(posedge clk_i) disable iff (!rst_ni) busy_o |-> !s_axis_run_tready_o)
  else $error("ready for a run during a run");

  BusyOnceAccepted :
  assert property (@(posedge clk_i) disable iff (!rst_ni) run_accepted |=> busy_o)
  else $error("not busy although a run was accepted");

  BusyUntilSummary :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_o && !(m_axis_done_tvalid_o && m_axis_done_tready_i) |=> busy_o)
  else $error("a run ended without a summary");

  SummaryComesLast :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o |-> busy_o && !m_axis_near_tvalid_o)
  else $error("a summary without a run, or before the last near pair was taken");

  StatusKnown :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o |-> status_o != StatusNone)
  else $error("a summary with a status that there is not");

  // Whatever ended the run, no more was counted than there is.
  AccountBounded :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o |-> group_pairs_decided <= group_pairs && near <= tested)
  else $error("more was counted than there is");

  NearInAllZones :
  assert property (@(posedge clk_i) disable iff (!rst_ni) near != 0 |-> zones_o == '1)
  else $error("a near pair, and a zone with nothing in it");

  SlowWithinWarn :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o && zones_o[ZoneSlow] && wider[ZoneSlow] |-> zones_o[ZoneWarn])
  else $error("a pair within a zone, and not within a wider one");

  NeverFreeUnasked :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o |-> (zones_o | wider) == '1)
  else $error("nothing in a zone that was not asked about");

  AccountComplete :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o && status_o == StatusComplete |-> group_pairs_decided == group_pairs)
  else $error("a complete run leaves pairs of groups out");

  // What looks at the status without its handshake must not read that of another run.
  StatusWithSummaryOnly :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      busy_o && !m_axis_done_tvalid_o |-> status_o == StatusNone)
  else $error("a status during a run");

  NoFalseAlarm :
  assert property (@(posedge clk_i) disable iff (!rst_ni) $rose(fault_o) |-> tries || $past(tries))
  else $error("a fault, although nothing was tried");

  FaultEndsRuns :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o && fault_o |-> status_o == StatusFault)
  else $error("a fault, and a summary that says nothing of it");

  // A run that is aborted before its summary is offered is not complete, whenever the summary comes.
  logic abort_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) abort_q <= 1'b0;
    else abort_q <= busy_o && (abort_q || abort_i && !m_axis_done_tvalid_o);
  end

  AbortedWhenAsked :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_done_tvalid_o && abort_q |-> status_o != StatusComplete)
  else $error("a run was complete although it was aborted");

endmodule

bind triaxis_mesh triaxis_mesh_sva #(
    .LoadWidth(9 * W + 2),
    .RunWidth(3 * triaxis_mesh_pkg::move_width(W) + triaxis_mesh_pkg::run_user_width(M)),
    .NearWidth(2 * IndexWidth),
    .CountersWidth(CycleBits + 2 * GroupPairWidth + 3 * PairCountWidth + $bits(zones_o))
) u_sva (
    .clk_i,
    .rst_ni,
    .s_axis_load_tvalid_i,
    .s_axis_load_tready_o,
    .load_beat({s_axis_load_tuser_i, s_axis_load_tdata_i}),
    .s_axis_run_tvalid_i,
    .s_axis_run_tready_o,
    .run_beat({s_axis_run_tuser_i, s_axis_run_tdata_i}),
    .abort_i,
    .busy_o,
    .m_axis_near_tvalid_o,
    .m_axis_near_tready_i,
    .m_axis_near_tdata_o,
    .m_axis_done_tvalid_o,
    .m_axis_done_tready_i,
    .counters({
      cycles_o,
      group_pairs_skipped_o,
      group_pairs_opened_o,
      pairs_skipped_o,
      tested_o,
      near_o,
      zones_o
    }),
    .status_o,
    .zones_o,
    .wider(g_walk[0].u_walk.wider),
    .group_pairs(64'(g_walk[0].u_walk.groups_a) * 64'(g_walk[0].u_walk.groups_b)),
    .group_pairs_decided(64'(group_pairs_skipped_o) + 64'(group_pairs_opened_o)),
    .tested(64'(tested_o)),
    .near(64'(near_o)),
    .tries(trial_q.kind != triaxis_mesh_pkg::TrialNothing),
    .fault_o
);
