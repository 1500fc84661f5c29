// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What a user of two streams, the second of which answers the first, may rely on, in terms of their
// ports alone: stable results, no loss, no duplication, order, latency, throughput, reset, occupancy.
// One word is followed from the clock at which it is accepted to the one at which its result is
// delivered: that for which mark_i is high. mark_i is free, so what holds for that one holds for all.

module triaxis_stream_rules #(
    parameter int unsigned Depth = 32,
    parameter int unsigned Latency = 22,
    parameter int unsigned ResultWidth = 32,
    // Whether in reset nothing may seem to move either.
    parameter bit QuietInReset = 1'b1,
    localparam int unsigned CountWidth = $clog2(Depth) + 1,
    localparam int unsigned AgeWidth = $clog2(Latency + 2)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_valid_i,
    input logic s_ready_i,
    input logic m_valid_i,
    input logic m_ready_i,
    input logic [ResultWidth-1:0] result_i,
    // What is to come out for the word that is being accepted.
    input logic [ResultWidth-1:0] due_i,
    input logic mark_i
);

  typedef logic [CountWidth-1:0] count_t;
  typedef logic [AgeWidth-1:0] age_t;
  typedef logic [ResultWidth-1:0] result_t;

  logic accept, deliver;
  assign accept  = s_valid_i && s_ready_i;
  assign deliver = m_valid_i && m_ready_i;

  // Words accepted since the last reset and not delivered, counted from the outside.
  count_t count_q, count_d;
  assign count_d = count_q + count_t'(accept) - count_t'(deliver);
  // The word that is followed: results to come before its own, clocks since it was accepted (held
  // at Latency), and its result.
  logic following_q;
  count_t ahead_q;
  age_t age_q;
  result_t due_q;
  // The clock before, and whether every result was taken at once since nothing was in flight.
  logic awake_q, waited_q, eager_q;
  result_t result_q;
  // Whether a reset ever fell on words in flight.
  logic accepted_q = 1'b0;
  logic cut_q = 1'b0;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      following_q <= 1'b0;
      ahead_q <= '0;
      age_q <= '0;
      awake_q <= 1'b0;
      waited_q <= 1'b0;
      eager_q <= 1'b1;
    end else begin
      count_q  <= count_d;
      awake_q  <= 1'b1;
      waited_q <= m_valid_i && !m_ready_i;
      eager_q  <= count_d == '0 || (eager_q && !(m_valid_i && !m_ready_i));
      if (following_q) begin
        ahead_q <= ahead_q - count_t'(deliver);
        if (age_q != age_t'(Latency)) age_q <= age_q + age_t'(1);
        if (deliver && ahead_q == '0) following_q <= 1'b0;
      end else if (accept && mark_i) begin
        following_q <= 1'b1;
        ahead_q <= count_q - count_t'(deliver);
        age_q <= age_t'(1);
      end
    end
  end

  always_ff @(posedge clk_i) begin
    result_q   <= result_i;
    accepted_q <= accept;
    if (!rst_ni && accepted_q) cut_q <= 1'b1;
    if (!following_q && accept && mark_i) due_q <= due_i;
  end

  always_ff @(posedge clk_i) begin
    if (!rst_ni) begin
      NothingInReset : assert (!QuietInReset || (!s_ready_i && !m_valid_i));
    end else begin
      ReadyAfterReset : assert (!awake_q || count_q == count_t'(Depth) || s_ready_i);
      Occupancy : assert (count_q <= count_t'(Depth) && !(s_ready_i && count_q == count_t'(Depth)));
      NothingFromNothing : assert (!m_valid_i || count_q != '0);
      ResultStable : assert (!waited_q || (m_valid_i && result_i == result_q));
      FullThroughput : assert (!eager_q || !awake_q || s_ready_i);
      if (following_q && ahead_q == '0) begin
        InTime : assert (m_valid_i == (age_q == age_t'(Latency)));
        RightResult : assert (!m_valid_i || result_i == due_q);
      end
      EagerInTime : assert (!eager_q || !following_q || age_q != age_t'(Latency) || ahead_q == '0);

      SeenFull : cover (count_q == count_t'(Depth) && waited_q);
      SeenFullMove : cover (count_q == count_t'(Depth) && deliver);
      SeenDelivered :
      cover (following_q && ahead_q == '0 && deliver && waited_q && result_i != result_t'(0));
      SeenAtOnce : cover (following_q && eager_q && deliver && accept && ahead_q == '0);
      SeenAfterCut : cover (cut_q && following_q && ahead_q == '0 && deliver);
    end
  end

endmodule
