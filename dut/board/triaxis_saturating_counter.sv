// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: how often, since reset; it stays at the largest number. Two may happen in one clock.
// Widths: Width bits.
// Latency: 1 clock.

module triaxis_saturating_counter #(
    parameter int unsigned Width = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic one_i,
    input logic other_i,
    output logic [Width-1:0] count_o
);

  logic [Width:0] sum;
  assign sum = {1'b0, count_o} + (Width + 1)'(one_i) + (Width + 1)'(other_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) count_o <= '0;
    else count_o <= sum[Width] ? '1 : sum[Width-1:0];
  end

endmodule
