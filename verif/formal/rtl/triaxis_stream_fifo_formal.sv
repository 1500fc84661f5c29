// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The engine's queue between two streams: the rules of streams, and what makes them inductive.

`include "triaxis_formal.svh"

module triaxis_stream_fifo_formal #(
    parameter int unsigned Width = 8,
    parameter int unsigned Depth = 16
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    input logic [Width-1:0] data_i,
    input logic ready_i,
    input logic mark_i
);

  typedef logic [$clog2(Depth):0] count_t;
  typedef logic [$clog2(Depth)-1:0] slot_t;
  typedef logic [Width-1:0] word_t;

  logic ready_o, valid_o;
  word_t data_o;

  triaxis_stream_fifo #(
      .T(word_t),
      .Depth(Depth)
  ) u_queue (
      .*
  );

  `TRIAXIS_RESET_FIRST

  triaxis_stream_rules #(
      .Depth(Depth),
      .Latency(1),
      .ResultWidth(Width),
      .QuietInReset(1'b0)
  ) u_rules (
      .clk_i,
      .rst_ni,
      .s_valid_i(valid_i),
      .s_ready_i(ready_o),
      .m_valid_i(valid_o),
      .m_ready_i(ready_i),
      .result_i(data_o),
      .due_i(data_i),
      .mark_i
  );

  // The followed word's place in the queue.
  count_t count, ahead, slot_q;
  logic following;
  assign count = u_rules.count_q;
  assign ahead = u_rules.ahead_q;
  assign following = u_rules.following_q;
  always_ff @(posedge clk_i) begin
    if (!following && u_rules.accept && mark_i) slot_q <= u_queue.u_words.write_q;
  end

  always_comb begin
    if (rst_ni) begin
      Occupied : assert (valid_o == (count != '0) && count <= count_t'(Depth));
      ReadyIfRoom : assert (!u_rules.awake_q || ready_o == (count != count_t'(Depth)));
      Fresh : assert (u_rules.awake_q || count == '0);
      Counted : assert (u_queue.held_q == count);
      Pointers : assert (u_queue.u_words.write_q - u_queue.u_words.read_q == count);
      Waited : assert (!u_rules.waited_q || (valid_o && data_o == u_rules.result_q));
      EagerQueue : assert (!u_rules.eager_q || count <= count_t'(1));
      AgeKnown : assert (!following || u_rules.age_q == 2'd1);
      InOrder : assert (!following || ahead < count);
      Place : assert (!following || slot_q - u_queue.u_words.read_q == ahead);
      Kept : assert (!following || u_queue.u_words.memory_q[slot_t'(slot_q)] == u_rules.due_q);
    end
  end

endmodule
