// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The engine's queue between two streams: what its users may rely on, and what makes that inductive.
// One word is followed from the clock at which it is accepted to the one at which it is delivered:
// that for which mark_i is high, which is free.

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

  logic push, pop;
  assign push = valid_i && ready_o;
  assign pop  = valid_o && ready_i;

  // Words accepted and not delivered; the one that is followed, and how many are before it.
  count_t count_q, ahead_q, slot_q;
  logic following_q, awake_q, waited_q;
  word_t due_q, word_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      following_q <= 1'b0;
      ahead_q <= '0;
      awake_q <= 1'b0;
      waited_q <= 1'b0;
    end else begin
      count_q  <= count_q + count_t'(push) - count_t'(pop);
      awake_q  <= 1'b1;
      waited_q <= valid_o && !ready_i;
      if (following_q) begin
        ahead_q <= ahead_q - count_t'(pop);
        if (pop && ahead_q == '0) following_q <= 1'b0;
      end else if (push && mark_i) begin
        following_q <= 1'b1;
        ahead_q <= count_q - count_t'(pop);
      end
    end
  end
  always_ff @(posedge clk_i) begin
    word_q <= data_o;
    if (!following_q && push && mark_i) begin
      due_q  <= data_i;
      slot_q <= u_queue.u_words.write_q;
    end
  end

  always_comb begin
    if (rst_ni) begin
      // What users see.
      Occupied : assert (valid_o == (count_q != '0) && count_q <= count_t'(Depth));
      ReadyIfRoom : assert (!awake_q || ready_o == (count_q != count_t'(Depth)));
      Stable : assert (!waited_q || (valid_o && data_o == word_q));
      InOrder : assert (!following_q || ahead_q < count_q);
      RightWord : assert (!following_q || ahead_q != '0 || (valid_o && data_o == due_q));
      // What makes it inductive.
      Fresh : assert (awake_q || count_q == '0);
      Counted : assert (u_queue.held_q == count_q);
      Pointers : assert (u_queue.u_words.write_q - u_queue.u_words.read_q == count_q);
      Waited : assert (!waited_q || data_o == word_q);
      Place : assert (!following_q || slot_q - u_queue.u_words.read_q == ahead_q);
      Kept : assert (!following_q || u_queue.u_words.memory_q[slot_t'(slot_q)] == due_q);
      SeenFull : cover (count_q == count_t'(Depth) && waited_q);
      SeenFollowed :
      cover (following_q && ahead_q == '0 && pop && due_q != '0 && count_q > count_t'(1));
      SeenBoth : cover (push && pop && count_q == count_t'(Depth - 1));
    end
  end

endmodule
