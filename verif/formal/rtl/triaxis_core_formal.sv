// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The core with its rules, and what makes them inductive: where the followed pair is, at each age.

`include "triaxis_formal.svh"

module triaxis_core_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter int unsigned TAG = 16,
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic mark_i,
    input logic s_axis_tvalid_i,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [TAG+M-1:0] s_axis_tuser_i,
    input logic m_axis_tready_i
);

  localparam int unsigned Latency = core_latency(W, M);
  localparam int unsigned Stages = datapath_latency(W, M);
  localparam int unsigned Depth = 2 ** $clog2(Latency);
  typedef logic [$clog2(Depth):0] count_t;
  typedef logic [$clog2(Depth)-1:0] slot_t;
  typedef logic [$clog2(Latency+2)-1:0] age_t;
  typedef logic [TAG+15:0] result_t;

  logic s_axis_tready_o, m_axis_tvalid_o;
  logic [15:0] m_axis_tdata_o;
  logic [TAG-1:0] m_axis_tuser_o;

  triaxis_core #(
      .W  (W),
      .M  (M),
      .TAG(TAG)
  ) u_core (
      .*
  );

  // The word that the stand-in of the data path makes of a pair.
  function automatic logic [15:0] word(verdict_t verdict);
    return {
      3'b0,
      verdict.axis,
      4'b0,
      verdict.degenerate_b,
      verdict.degenerate_a,
      verdict.coplanar,
      verdict.is_near
    };
  endfunction

  triaxis_stream_rules #(
      .Depth(Depth),
      .Latency(Latency),
      .ResultWidth(TAG + 16)
  ) u_rules (
      .clk_i,
      .rst_ni,
      .s_valid_i(s_axis_tvalid_i),
      .s_ready_i(s_axis_tready_o),
      .m_valid_i(m_axis_tvalid_o),
      .m_ready_i(m_axis_tready_i),
      .result_i({m_axis_tuser_o, m_axis_tdata_o}),
      .due_i({s_axis_tuser_i[M+:TAG], word(verdict_t'(s_axis_tdata_i[W-1:0]))}),
      .mark_i
  );

  logic following;
  count_t ahead, count;
  age_t age;
  assign following = u_rules.following_q;
  assign ahead = u_rules.ahead_q;
  assign count = u_rules.count_q;
  assign age = u_rules.age_q;

  `TRIAXIS_RESET_FIRST

  // Ghosts: each pair has a serial number, that of the queue's slot which it will take, in the
  // pointers' own width. The number of an empty stage is that of the next pair before it.
  count_t accepted_q, followed_q, serial_q[Stages];
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      accepted_q <= '0;
      serial_q   <= '{default: '0};
    end else begin
      accepted_q  <= accepted_q + count_t'(u_core.accept);
      serial_q[0] <= accepted_q;
      for (int i = 1; i < int'(Stages); i++) serial_q[i] <= serial_q[i-1];
    end
  end
  always_ff @(posedge clk_i) begin
    if (!following && u_core.accept && mark_i) followed_q <= accepted_q;
  end

  count_t read, written, queued, piped;
  assign read = u_core.u_results.read_q;
  assign written = u_core.u_results.write_q;
  assign queued = written - read;
  assign piped = accepted_q - written;

  logic chained, bounded;
  always_comb begin
    chained = accepted_q == serial_q[0] + count_t'(u_core.valid_q[0]);
    bounded = piped <= count_t'(Stages);
    for (int i = 1; i < int'(Stages); i++) begin
      chained &= serial_q[i-1] == serial_q[i] + count_t'(u_core.valid_q[i]);
    end
    for (int i = 0; i < int'(Stages); i++) begin
      bounded &= count_t'(serial_q[i] - written) < count_t'(int'(Stages) - i);
    end
    chained &= serial_q[Stages-1] == written;
  end

  function automatic result_t stored(logic [TAG-1:0] tag, verdict_t verdict);
    return {tag, word(verdict)};
  endfunction

  logic [TAG-1:0] tag_at[Stages];
  for (genvar i = 0; i < Stages; i++) begin : g_tag
    assign tag_at[i] = u_core.u_tag.g_regs.g_stage[i].stage_q;
  end

  always_comb begin
    if (rst_ni) begin
      Counted : assert (u_core.in_flight_q == count);
      Chained : assert (chained && bounded);
      Conserved : assert (count == piped + queued && count >= queued && count <= count_t'(Depth));
      NoPushIntoFull : assert (!u_core.u_results.push_i || queued != count_t'(Depth));
      AwakeKnown : assert (u_core.awake_q == u_rules.awake_q);
      EagerQueue : assert (!u_rules.eager_q || queued <= count_t'(1));
      Waited :
      assert (!u_rules.waited_q || (queued != '0 &&
          u_rules.result_q == {m_axis_tuser_o, m_axis_tdata_o}));
      if (following) begin
        AgeKnown : assert (age != '0 && age <= age_t'(Latency));
        AheadKnown : assert (ahead == followed_q - read && ahead < count);
        if (age < age_t'(Latency)) begin
          InPipe :
          assert (u_core.valid_q[age-1] && serial_q[age-1] == followed_q && ahead >= queued);
          Carried :
          assert (stored(tag_at[age-1], u_core.u_datapath.stage_q[age-1]) == u_rules.due_q);
        end else begin
          InQueue : assert (ahead < queued);
          Kept :
          assert (stored(
              u_core.u_results.memory_q[slot_t'(followed_q)].tag,
              u_core.u_results.memory_q[slot_t'(followed_q)].verdict
          ) == u_rules.due_q);
        end
      end
    end
  end

endmodule
