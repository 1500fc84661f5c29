// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A stand-in for the data path in the proof of the core's streams, with the ports of the real one: the
// verdict of a pair is the lowest nine bits of its first coordinate, datapath_latency(W, M) clocks later.
// The queue and the handshake only carry verdicts, never look at them, so what holds for verdicts
// that the input chooses freely holds for any others. That the real data path gives the verdict of a
// pair after just so many clocks, whatever pairs surround it, is what verif/formal/algebra.py proves.

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

  localparam int unsigned Latency = datapath_latency(W, M);

  verdict_t stage_q[Latency];
  always_ff @(posedge clk_i) begin
    stage_q[0] <= verdict_t'(a_i[0][0]);
    for (int i = 1; i < int'(Latency); i++) stage_q[i] <= stage_q[i-1];
  end
  assign verdict_o = stage_q[Latency-1];

endmodule
