// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A stand-in for the core's data path where single mutants of the mesh engine are built: the exact
// checker of golden/ decides, as long after a pair as the data path does. It is compiled once, the
// data path would be each time. Whatever survives here is played with the real one as well.

module triaxis_datapath
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic valid_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    output verdict_t verdict_o
);

  // The lowest axis that separates; negative where none does.
  import "DPI-C" function int triaxis_claim(
    input bit [18*32-1:0] pair,
    input int unsigned margin
  );

  localparam int unsigned Latency = datapath_latency(W, M);

  bit [18*32-1:0] pair;
  for (genvar v = 0; v < 3; v++) begin : g_vertex
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign pair[32*(3*v+k)+:32]   = 32'(a_i[v][k]);
      assign pair[32*(9+3*v+k)+:32] = 32'(b_i[v][k]);
    end
  end

  int claim_q[Latency];
  always_ff @(posedge clk_i) begin
    claim_q[0] <= valid_i ? triaxis_claim(pair, 32'(margin_i)) : 0;
    for (int i = 1; i < int'(Latency); i++) claim_q[i] <= claim_q[i-1];
  end

  always_comb begin
    verdict_o = '0;
    verdict_o.is_near = claim_q[Latency-1] < 0;
    if (!verdict_o.is_near) verdict_o.axis = axis_t'(claim_q[Latency-1]);
  end

endmodule
