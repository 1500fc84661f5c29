// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what a run makes of the core's verdicts: counts of tested and of near pairs, and the
// near pairs themselves as a stream, as the mode asks. A pair that is near in an outer zone is asked
// again, in the next zone that no pair is known to be in: again_valid_o, again_pair_o. So a run asks few pairs more than
// once: those that were on their way when the first pair was found in a zone. first_o stays high once the first near pair
// has ended a run in mode first. What comes while drain_i is high is dropped; a near pair that is
// offered stays offered.
// Widths: a number of pairs has 2 log2(Depth) + 1 bits, for Depth^2 itself.
// Latency: 1 from a verdict to its near pair, or to its pair that is to be asked again.

module triaxis_near_pairs
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned IndexWidth = 12,
    parameter int unsigned InFlight = 34,  // most pairs between issue_i and their verdict
    localparam int unsigned PairCountWidth = 2 * IndexWidth + 1
) (
    input  logic  clk_i,
    input  logic  rst_ni,
    input  logic  start_i,
    input  logic  drain_i,
    output logic  idle_o,
    input  mode_e mode_i,
    output logic  first_o,

    input logic issue_i,
    input logic verdict_valid_i,
    output logic verdict_ready_o,
    input logic verdict_near_i,
    input zone_e verdict_zone_i,
    input logic [2*IndexWidth-1:0] verdict_pair_i,

    // wider_i: the zone is wider than the one inside it; zone_o: in which pairs are asked; zones_o: in which
    // one was found, or that are no wider.
    input logic [Zones-1:1] wider_i,
    output zone_e zone_o,
    output logic [Zones-1:1] zones_o,
    output logic again_valid_o,
    output logic [2*IndexWidth-1:0] again_pair_o,

    output logic m_axis_near_tvalid_o,
    input logic m_axis_near_tready_i,
    output logic [2*IndexWidth-1:0] m_axis_near_tdata_o,

    output logic [PairCountWidth-1:0] tested_o,
    output logic [PairCountWidth-1:0] near_o
);

  typedef logic [PairCountWidth-1:0] pair_count_t;
  typedef logic [$clog2(InFlight+1)-1:0] in_flight_t;

  logic drop, take, innermost, near_found, again, counted, near_taken, offer;
  in_flight_t in_flight_q;
  zone_e within_warn;

  assign drop = drain_i || first_o;
  // A verdict waits only where its pair has to be offered and another one is still on offer.
  assign innermost = verdict_near_i && verdict_zone_i == ZoneMargin;
  assign verdict_ready_o = drop || !innermost || !m_axis_near_tvalid_o || m_axis_near_tready_i;
  assign take = verdict_valid_i && verdict_ready_o;
  assign near_found = take && !drop && verdict_near_i;
  assign again = near_found && !innermost;
  assign counted = take && !drop && !again;
  assign near_taken = counted && verdict_near_i;
  assign offer = near_taken && mode_i != ModeCount;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      first_o  <= 1'b0;
      tested_o <= '0;
      near_o   <= '0;
    end else if (start_i) begin
      first_o  <= 1'b0;
      tested_o <= '0;
      near_o   <= '0;
    end else begin
      if (offer && mode_i == ModeFirst) first_o <= 1'b1;
      tested_o <= tested_o + pair_count_t'(counted);
      near_o   <= near_o + pair_count_t'(near_taken);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      m_axis_near_tvalid_o <= 1'b0;
      again_valid_o <= 1'b0;
      in_flight_q <= '0;
    end else begin
      again_valid_o <= again;
      if (offer) m_axis_near_tvalid_o <= 1'b1;
      else if (m_axis_near_tready_i) m_axis_near_tvalid_o <= 1'b0;
      in_flight_q <= in_flight_q + in_flight_t'(issue_i) - in_flight_t'(take);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) zones_o <= '0;
    else if (start_i) zones_o <= ~wider_i;
    else if (near_found) begin
      zones_o[ZoneWarn] <= 1'b1;
      if (verdict_zone_i != ZoneWarn) zones_o[ZoneSlow] <= 1'b1;
    end
  end
  assign within_warn = zones_o[ZoneSlow] ? ZoneMargin : ZoneSlow;
  assign zone_o = zones_o[ZoneWarn] ? within_warn : ZoneWarn;

  always_ff @(posedge clk_i) begin
    again_pair_o <= verdict_pair_i;
    if (offer) m_axis_near_tdata_o <= verdict_pair_i;
  end

  assign idle_o = in_flight_q == '0 && !m_axis_near_tvalid_o;

endmodule
