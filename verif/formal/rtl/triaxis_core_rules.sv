// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What a user of the core may rely on, in terms of its ports alone: stable results, no loss, no
// duplication, order, tags, latency, throughput, reset, occupancy. One pair is followed from the
// clock at which it is accepted to the one at which it is delivered: that for which mark_i is high.
// Where mark_i is free, as it is in the proof, what holds for that pair holds for every pair.
//
// Plain clocked assertions, so that the proof and a simulator read the same text.

module triaxis_core_rules #(
    parameter int unsigned Depth = 32,
    parameter int unsigned Latency = 22,
    parameter int unsigned ResultWidth = 32,
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
    // What is to come out for the pair that is being accepted.
    input logic [ResultWidth-1:0] due_i,
    input logic mark_i,
    output logic following_o,
    output logic [CountWidth-1:0] ahead_o,
    output logic [AgeWidth-1:0] age_o,
    output logic [ResultWidth-1:0] due_o,
    output logic [CountWidth-1:0] count_o
);

  typedef logic [CountWidth-1:0] count_t;
  typedef logic [AgeWidth-1:0] age_t;
  typedef logic [ResultWidth-1:0] result_t;

  logic accept, deliver;
  assign accept  = s_valid_i && s_ready_i;
  assign deliver = m_valid_i && m_ready_i;

  // Pairs accepted since the last reset and not delivered, counted from the outside.
  count_t count_q;
  // The pair that is followed: results to come before its own, clocks since it was accepted (held
  // at Latency), and its result.
  logic following_q;
  count_t ahead_q;
  age_t age_q;
  result_t due_q;
  // The clock before, and whether every result was taken at once since the last reset.
  logic awake_q, waited_q, eager_q;
  result_t result_q;
  // Whether a reset ever fell on pairs in flight.
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
      count_q  <= count_q + count_t'(accept) - count_t'(deliver);
      awake_q  <= 1'b1;
      waited_q <= m_valid_i && !m_ready_i;
      eager_q  <= eager_q && m_ready_i;
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
      NothingInReset :
      assert (!s_ready_i && !m_valid_i)
      else $error("a pair or a result could move in reset");
    end else begin
      ReadyAfterReset :
      assert (!awake_q || count_q == count_t'(Depth) || s_ready_i)
      else $error("not ready, one clock after reset and with a place for a result");
      Occupancy :
      assert (count_q <= count_t'(Depth) && !(s_ready_i && count_q == count_t'(Depth)))
      else $error("a pair could be accepted without a place for its result");
      NothingFromNothing :
      assert (!m_valid_i || count_q != '0)
      else $error("a result for no pair: duplicated, or from before the reset");
      ResultStable :
      assert (!waited_q || (m_valid_i && result_i == result_q))
      else $error("a result changed while it waited");
      FullThroughput :
      assert (!eager_q || !awake_q || s_ready_i)
      else $error("the core is not ready although every result was taken at once");
      if (following_q && ahead_q == '0) begin
        InTime :
        assert (m_valid_i == (age_q == age_t'(Latency)))
        else $error("the next result is lost, late or early");
        RightResult :
        assert (!m_valid_i || result_i == due_q)
        else $error("a result is not that of the pair whose turn it is");
      end
      EagerInTime :
      assert (!eager_q || !following_q || age_q != age_t'(Latency) || ahead_q == '0)
      else $error("results were taken at once, and others are still ahead of one that is due");

      SeenFull : cover (count_q == count_t'(Depth) && waited_q);
      SeenFullMove : cover (count_q == count_t'(Depth) && deliver);
      SeenDelivered :
      cover (following_q && ahead_q == '0 && deliver && waited_q && result_i != result_t'(0));
      SeenAtOnce : cover (following_q && eager_q && deliver && accept && ahead_q == '0);
      SeenAfterCut : cover (cut_q && following_q && ahead_q == '0 && deliver);
    end
  end

  assign following_o = following_q;
  assign ahead_o = ahead_q;
  assign age_o = age_q;
  assign due_o = due_q;
  assign count_o = count_q;

endmodule
