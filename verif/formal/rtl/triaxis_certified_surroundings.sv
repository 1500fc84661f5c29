// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the ports of the real ones, for what decides in the certified core, in the proofs
// `certified` and `certified_upset`. Signals named free_* have no driver: the prover chooses them anew
// each clock, which allows more than any data path or certifier does.

// That the real one gives the verdict of a pair, datapath_latency(W, M) clocks later: `axes_*`.
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

  verdict_t free_verdict;
  assign verdict_o = free_verdict;

endmodule

// That the real one answers certifier_latency(W) clocks later, and what, is shown by `certificate`.
// verilog_lint: waive module-filename
module triaxis_certifier
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    input axis_t axis_i,
    output logic holds_o
);

  logic free_holds;
  assign holds_o = free_holds;

endmodule
