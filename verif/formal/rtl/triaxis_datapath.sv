// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A stand-in for the data path in the proof of the core's streams, with the real one's header: the
// verdict of a pair is the lowest nine bits of its first coordinate, datapath_latency(W, M) clocks later.
// The queue and the handshake only carry verdicts, never look at them, so what holds for verdicts
// that the input chooses freely holds for any others. That the real data path gives the verdict of a
// pair after just so many clocks, whatever pairs surround it: `axes_*`.

module triaxis_datapath;

  localparam int unsigned Latency = datapath_latency(W, M);

  verdict_t stage_q[Latency];
  always_ff @(posedge clk_i) begin
    stage_q[0] <= verdict_t'(a_i[0][0]);
    for (int i = 1; i < int'(Latency); i++) stage_q[i] <= stage_q[i-1];
  end
  assign verdict_o = stage_q[Latency-1];

endmodule
