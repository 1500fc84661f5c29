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
    input logic awake_q,
    input logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    input logic [15:0] m_axis_tdata_o,
    input logic [31:0] tag,
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

  // One pair per clock, at a fixed latency, for a user who has taken every result at once so far.
  logic eager_q;
  logic [Latency-1:0] accepted_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      eager_q <= 1'b1;
      accepted_q <= '0;
    end else begin
      eager_q <= eager_q && m_axis_tready_i;
      accepted_q <= {accepted_q[Latency-2:0], s_axis_tvalid_i && s_axis_tready_o};
    end
  end

  FullThroughput :
  assert property (@(posedge clk_i) disable iff (!rst_ni) eager_q && awake_q |-> s_axis_tready_o)
  else $error("the core is not ready although every result was taken at once");

  FixedLatency :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      eager_q |-> m_axis_tvalid_o == accepted_q[Latency-1])
  else $error("a result is due and not there, or there and not due");

  QueueNeverOverflows :
  assert property (@(posedge clk_i) disable iff (!rst_ni) push |-> queued < ($clog2(
      Depth
  ) + 1)'(Depth))
  else $error("a result was pushed into a full queue");

  InFlightBounded :
  assert property (@(posedge clk_i) disable iff (!rst_ni) in_flight_q <= ($clog2(
      Depth
  ) + 1)'(Depth))
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
    .awake_q,
    .m_axis_tvalid_o,
    .m_axis_tready_i,
    .m_axis_tdata_o,
    .tag(32'(m_axis_tuser_o)),
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
    .awake_q(u_core.awake_q),
    .m_axis_tvalid_o,
    .m_axis_tready_i,
    .m_axis_tdata_o,
    .tag(32'(m_axis_tuser_o)),
    .in_flight_q(in_flight),
    .push(u_results.push_i),
    .queued(u_results.write_q - u_results.read_q)
);
