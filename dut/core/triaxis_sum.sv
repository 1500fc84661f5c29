// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the sum of Terms numbers, in a tree with one addition between registers.
// Widths: Width bits in and out; exact whenever the sum itself fits Width bits signed.
// Latency: sum_latency(Terms) = ceil(log2(Terms)).

`include "triaxis_stage.svh"

module triaxis_sum #(
    parameter int unsigned Terms = 2,
    parameter int unsigned Width = 8,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [Width-1:0] terms_i[Terms],
    output logic signed [Width-1:0] sum_o
);

  typedef logic signed [Width-1:0] term_t;

  if (Terms == 1) begin : g_done
    logic unused_clk;
    assign unused_clk = clk_i;
    assign sum_o = terms_i[0];
  end else begin : g_level
    localparam int unsigned Half = (Terms + 1) / 2;
    term_t half_d[Half], half_q[Half];

    for (genvar i = 0; i < Half; i++) begin : g_pair
      if (2 * i + 1 < Terms) begin : g_add
        assign half_d[i] = terms_i[2*i] + terms_i[2*i+1];
      end else begin : g_pass
        assign half_d[i] = terms_i[2*i];
      end
    end

    `TRIAXIS_STAGE(half_q, half_d)

    triaxis_sum #(
        .Terms(Half),
        .Width(Width),
        .Comb (Comb)
    ) u_rest (
        .clk_i,
        .terms_i(half_q),
        .sum_o
    );
  end

endmodule
