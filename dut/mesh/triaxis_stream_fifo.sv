// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a queue between two streams with valid and ready on both sides; ready comes from a
// register.
// Widths: words of type T; Depth, a power of two, words.
// Latency: 1 from the accepting edge to valid.

module triaxis_stream_fifo #(
    parameter type T = logic,
    parameter int unsigned Depth = 4
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    output logic ready_o,
    input T data_i,
    output logic valid_o,
    input logic ready_i,
    output T data_o
);

  typedef logic [$clog2(Depth):0] count_t;

  count_t held_q, held_d;
  logic push, pop, ready_q;

  assign push = valid_i && ready_o;
  assign pop = valid_o && ready_i;
  assign held_d = held_q + count_t'(push) - count_t'(pop);
  assign ready_o = ready_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      held_q  <= '0;
      ready_q <= 1'b0;
    end else begin
      held_q  <= held_d;
      ready_q <= held_d != count_t'(Depth);
    end
  end

  triaxis_fifo #(
      .T(T),
      .Depth(Depth)
  ) u_words (
      .clk_i,
      .rst_ni,
      .push_i(push),
      .data_i,
      .pop_i (pop),
      .valid_o,
      .data_o
  );

endmodule
