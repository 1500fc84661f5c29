// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The count of pairs on their way through the core, bound from outside the RTL: a run may end only
// once it is back at zero, so it must neither run over nor fall below. Pairs that are asked again: in a
// narrower zone, in the next clock, before any that is new. A zone that was not asked about is never free.

module triaxis_near_pairs_sva
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned InFlight = 34
) (
    input logic clk_i,
    input logic rst_ni,
    input logic start_i,
    input logic issue_i,
    input logic drain_i,
    input logic take,
    input logic [$clog2(InFlight+1)-1:0] in_flight_q,
    input zone_e verdict_zone_i,
    input logic [Zones-1:1] wider_i,
    input logic again,
    input zone_e zone_o,
    input logic [Zones-1:1] zones_o
);

  PairsInFlightBounded :
  assert property (@(posedge clk_i) disable iff (!rst_ni) in_flight_q <= ($clog2(
      InFlight + 1
  ))'(InFlight))
  else $error("more pairs in flight than the core and what feeds it hold");

  VerdictWasAwaited :
  assert property (@(posedge clk_i) disable iff (!rst_ni) take |-> in_flight_q != '0)
  else $error("a verdict without a pair in flight");

  // One gate sees to this, in triaxis_mesh: it must not be lost.
  NothingIssuedWhileDraining :
  assert property (@(posedge clk_i) disable iff (!rst_ni) drain_i |-> !issue_i)
  else $error("a pair went to the core although the run is over");

  ZonesOnlySet :
  assert property (@(posedge clk_i) disable iff (!rst_ni) !start_i |=> ($past(
      zones_o
  ) & ~zones_o) == '0)
  else $error("in a zone in which a pair was found there is none any more");

  UnaskedFromTheStart :
  assert property (@(posedge clk_i) disable iff (!rst_ni) start_i |=> zones_o == ~$past(wider_i))
  else $error("a run does not begin with exactly the zones that are no wider");

  NothingAgainWhileDraining :
  assert property (@(posedge clk_i) disable iff (!rst_ni) drain_i |-> !again)
  else $error("a pair is to be asked again although the run is over");

  AgainNarrower :
  assert property (@(posedge clk_i) disable iff (!rst_ni) again |=> zone_o < $past(verdict_zone_i))
  else $error("a pair is to be asked again in no narrower zone");

endmodule

// verilog_lint: waive module-filename
module triaxis_again_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic again_valid,
    input logic fetch_ready,
    input logic pair_ready
);

  AgainAtOnce :
  assert property (@(posedge clk_i) disable iff (!rst_ni) again_valid |-> fetch_ready)
  else $error("a pair that is to be asked again is lost");

  AgainFirst :
  assert property (@(posedge clk_i) disable iff (!rst_ni) again_valid |-> !pair_ready)
  else $error("a new pair is asked before one that waits to be asked again");

endmodule

bind triaxis_near_pairs triaxis_near_pairs_sva #(
    .InFlight(InFlight)
) u_sva (
    .clk_i,
    .rst_ni,
    .issue_i,
    .drain_i,
    .take,
    .start_i,
    .in_flight_q,
    .verdict_zone_i,
    .wider_i,
    .again,
    .zone_o,
    .zones_o
);

bind triaxis_walk triaxis_again_sva u_again_sva (
    .clk_i,
    .rst_ni,
    .again_valid,
    .fetch_ready,
    .pair_ready
);
