// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What a run makes of free verdicts: every near pair is offered once, unchanged until it is taken,
// and in order; none after the first where one was asked for, none where only counts were; nothing
// of what is drained; idle only with nothing on offer and nothing on its way. A pair that is near in an
// outer zone is not counted, but asked again, in a narrower one; the zones are those of the verdicts, and one
// that is no wider at the start of a run is never free in it.

`include "triaxis_formal.svh"

module triaxis_near_pairs_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned IndexWidth = 3,
    parameter int unsigned InFlight   = 34
) (
    input logic clk_i,
    input logic rst_ni,
    input logic start_i,
    input logic drain_i,
    input logic [1:0] asked_i,
    input logic issue_i,
    input logic verdict_valid_i,
    input logic verdict_near_i,
    input zone_e verdict_zone_i,
    input logic [2*IndexWidth-1:0] verdict_pair_i,
    input logic [Zones-1:1] wider_i,
    input logic m_axis_near_tready_i
);

  typedef logic [2*IndexWidth:0] count_t;
  typedef logic [2*IndexWidth-1:0] pair_t;
  typedef logic [$clog2(InFlight+1)-1:0] in_flight_t;

  logic idle_o, first_o, verdict_ready_o, again_valid_o, m_axis_near_tvalid_o;
  zone_e zone_o;
  logic [Zones-1:1] zones_o;
  pair_t m_axis_near_tdata_o, again_pair_o;
  count_t tested_o, near_o;

  mode_e mode_q;
  triaxis_near_pairs #(
      .IndexWidth(IndexWidth),
      .InFlight  (InFlight)
  ) u_near (
      .mode_i(mode_q),
      .*
  );

  logic take, taken, counts, last, near, offer;
  assign take   = verdict_valid_i && verdict_ready_o;
  assign taken  = m_axis_near_tvalid_o && m_axis_near_tready_i;
  assign counts = take && !drain_i && !first_o;
  // The pair's last verdict.
  assign last   = !verdict_near_i || verdict_zone_i == ZoneMargin;
  assign near   = counts && verdict_near_i && last;
  // What must be offered next.
  assign offer  = near && mode_q != ModeCount;

  `TRIAXIS_RESET_FIRST

  // Pairs on their way, the pair on offer, and whether it waits.
  logic offered_q, waited_q, first_q, again_q, ran_q;
  zone_e again_zone_q;
  logic [Zones-1:1] zones_q, wider_q;
  in_flight_t way_q;
  pair_t due_q, again_pair_q;
  count_t tested_q, near_q;
  always_ff @(posedge clk_i) begin
    // What was asked for changes between runs, when nothing is under way.
    if (start_i) mode_q <= mode_e'(asked_i);
    if (start_i) wider_q <= wider_i;
    if (offer) due_q <= verdict_pair_i;
    again_zone_q <= verdict_zone_i;
    again_pair_q <= verdict_pair_i;
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {offered_q, waited_q, first_q, again_q, ran_q} <= '0;
      zones_q <= '0;
      way_q <= '0;
      tested_q <= '0;
      near_q <= '0;
    end else begin
      offered_q <= offer || (offered_q && !taken);
      waited_q <= m_axis_near_tvalid_o && !m_axis_near_tready_i;
      way_q <= way_q + in_flight_t'(issue_i) - in_flight_t'(take);
      first_q <= !start_i && (first_q || (offer && mode_q == ModeFirst));
      tested_q <= start_i ? '0 : tested_q + count_t'(counts && last);
      near_q <= start_i ? '0 : near_q + count_t'(near);
      again_q <= counts && !last;
      ran_q <= ran_q || start_i;
      // Near in a zone, or in one within it; or the zone is no wider than that.
      for (int z = 1; z < int'(Zones); z++)
      zones_q[z] <= start_i ? !wider_i[z] : zones_q[z] ||
          (counts && verdict_near_i && 32'(verdict_zone_i) <= 32'(z));
    end
  end

  logic start_q, asks_right;
  always_ff @(posedge clk_i) start_q <= start_i;
  always_comb begin
    asks_right = zone_o == ZoneMargin || (!zones_o[zone_o] && (!ran_q || wider_q[zone_o]));
    for (int z = 1; z < int'(Zones); z++)
    if (!zones_o[z] && 32'(zone_o) < 32'(z)) asks_right = 1'b0;
  end

  always_comb begin
    Zone : assume (verdict_zone_i <= ZoneWarn);
    VerdictsOfPairs : assume (!verdict_valid_i || way_q != '0);
    RoomForPairs : assume (!issue_i || way_q < in_flight_t'(InFlight));
    StartIdle : assume (!start_i || (idle_o && !issue_i));
    if (rst_ni) begin
      NothingLost : assert (m_axis_near_tvalid_o == offered_q);
      Unchanged : assert (!m_axis_near_tvalid_o || m_axis_near_tdata_o == due_q);
      Waits : assert (!waited_q || m_axis_near_tvalid_o);
      NoOverwrite : assert (!offer || !offered_q || taken);
      OneFirst : assert (first_o == first_q);
      NoMoreThanFirst : assert (mode_q != ModeFirst || !offer || near_q == '0 || !first_q);
      Counted : assert (tested_o == tested_q && near_o == near_q);
      // Each verdict is the last one of its pair, or the pair is asked again, in a narrower zone.
      Again : assert (again_valid_o == again_q && (!again_q || again_pair_o == again_pair_q));
      AgainNarrower : assert (!again_q || start_q || zone_o < again_zone_q);
      // Asked in the widest zone in which nothing was found.
      WidestOpen : assert (asks_right);
      ZonesOfVerdicts : assert (zones_o == zones_q);
      NearInAllZones : assert (near_o == '0 || zones_o == '1);
      NeverFreeUnasked : assert (!ran_q || (zones_o | wider_q) == '1);
      SlowWithinWarn :
      assert (!ran_q || !wider_q[ZoneSlow] || !zones_o[ZoneSlow] || zones_o[ZoneWarn]);
      Idle : assert (idle_o == (way_q == '0 && !offered_q));
      OnItsWay : assert (u_near.in_flight_q == way_q && way_q <= in_flight_t'(InFlight));
      SeenWaiting : cover (waited_q && taken && offer);
      SeenAgain : cover (again_q && counts && !last && zone_o == ZoneMargin && zones_o == '1);
      SeenWarnAlone : cover (ran_q && !wider_q[ZoneSlow] && zone_o == ZoneMargin && tested_o != '0);
      SeenFirst : cover (first_o && take && verdict_near_i);
      SeenDrained : cover (drain_i && take && verdict_near_i && offered_q);
      SeenStalled : cover (verdict_valid_i && !verdict_ready_o);
    end
  end

endmodule
