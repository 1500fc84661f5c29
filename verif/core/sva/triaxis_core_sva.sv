// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Rules of the core's streams and of its result queue, bound from outside the RTL.

module triaxis_core_sva #(
    parameter int unsigned Depth = 32,
    parameter int unsigned Latency = 22,
    parameter int unsigned PairWidth = 304
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_tvalid_i,
    input logic s_axis_tready_o,
    input logic [PairWidth-1:0] pair,
    input logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    input logic [15:0] m_axis_tdata_o,
    input logic [63:0] tag,
    input logic [$clog2(Depth):0] in_flight_q,
    input logic push,
    input logic [$clog2(Depth):0] queued
);

  // Nothing is offered and nothing taken in reset.
  QuietInReset :
  assert property (@(posedge clk_i) !rst_ni |-> !m_axis_tvalid_o && !s_axis_tready_o)
  else $error("the core is not quiet in reset");

  // A result offered and not taken stays as it is.
  ResultStable :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_tvalid_o && !m_axis_tready_i |=>
      m_axis_tvalid_o && $stable(
      m_axis_tdata_o
  ) && $stable(
      tag
  ))
  else $error("a result changed while it waited");

  // The same rule for whoever drives the input.
  PairHeld :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      s_axis_tvalid_i && !s_axis_tready_o |=> s_axis_tvalid_i && $stable(
      pair
  ))
  else $error("a pair was withdrawn or changed while it waited");

  // One pair per clock as long as there is a place for it, of which there are as many as the latency has clocks
  // at least; at a fixed latency but for results that wait.
  typedef logic [$clog2(Depth):0] count_t;
  logic accepts, delivers, awake_q;
  assign accepts  = s_axis_tvalid_i && s_axis_tready_o;
  assign delivers = m_axis_tvalid_o && m_axis_tready_i;
  count_t held_q, waiting_q;
  logic [Latency-1:0] accepted_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      awake_q <= 1'b0;
      held_q <= '0;
      waiting_q <= '0;
      accepted_q <= '0;
    end else begin
      awake_q <= 1'b1;
      held_q <= held_q + count_t'(accepts) - count_t'(delivers);
      waiting_q <= waiting_q + count_t'(accepted_q[Latency-1]) - count_t'(delivers);
      accepted_q <= {accepted_q[Latency-2:0], accepts};
    end
  end

  FullThroughput :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      awake_q && (held_q < count_t'(Depth) || 32'(held_q) < Latency) |-> s_axis_tready_o)
  else $error("the core is not ready although it has a place for a pair");

  FixedLatency :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      m_axis_tvalid_o == (accepted_q[Latency-1] || waiting_q != '0))
  else $error("a result is due and not there, or there and not due");

  QueueNeverOverflows :
  assert property (@(posedge clk_i) disable iff (!rst_ni) push |-> queued < count_t'(Depth))
  else $error("a result was pushed into a full queue");

  InFlightBounded :
  assert property (@(posedge clk_i) disable iff (!rst_ni) in_flight_q <= count_t'(Depth))
  else $error("more pairs in flight than the queue holds");

  InFlightCoversQueue :
  assert property (@(posedge clk_i) disable iff (!rst_ni) queued <= in_flight_q)
  else $error("more results queued than pairs in flight");

endmodule

bind triaxis_core triaxis_core_sva #(
    .Depth(Depth),
    .Latency(triaxis_pkg::core_latency(W, M)),
    .PairWidth(DataWidth + TAG + M)
) u_sva (
    .clk_i,
    .rst_ni,
    .s_axis_tvalid_i,
    .s_axis_tready_o,
    .pair({s_axis_tdata_i, s_axis_tuser_i}),
    .m_axis_tvalid_o,
    .m_axis_tready_i,
    .m_axis_tdata_o,
    .tag(64'(m_axis_tuser_o)),
    .in_flight_q,
    .push(u_results.push_i),
    .queued(u_results.write_q - u_results.read_q)
);

// The certified core keeps the same rules; its numbers count what is in flight.
bind triaxis_certified_core triaxis_core_sva #(
    .Depth(Depth),
    .Latency(triaxis_pkg::certified_latency(W, M)),
    .PairWidth(DataWidth + $bits(triaxis_pkg::try_t) + TAG + M)
) u_sva (
    .clk_i,
    .rst_ni,
    .s_axis_tvalid_i,
    .s_axis_tready_o,
    .pair({s_axis_tdata_i, s_axis_tuser_i}),
    .m_axis_tvalid_o,
    .m_axis_tready_i,
    .m_axis_tdata_o,
    .tag(64'(m_axis_tuser_o)),
    .in_flight_q(in_flight),
    .push(u_results.push_i),
    .queued(u_results.write_q - u_results.read_q)
);
