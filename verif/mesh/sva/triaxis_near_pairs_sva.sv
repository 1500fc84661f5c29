// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The count of pairs on their way through the core, bound from outside the RTL: a run may end only
// once it is back at zero, so it must neither run over nor fall below.

module triaxis_near_pairs_sva #(
    parameter int unsigned InFlight = 34
) (
    input logic clk_i,
    input logic rst_ni,
    input logic issue_i,
    input logic drain_i,
    input logic take,
    input logic [$clog2(InFlight+1)-1:0] in_flight_q
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

endmodule

bind triaxis_near_pairs triaxis_near_pairs_sva #(
    .InFlight(InFlight)
) u_sva (
    .clk_i,
    .rst_ni,
    .issue_i,
    .drain_i,
    .take,
    .in_flight_q
);
