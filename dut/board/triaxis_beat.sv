// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a square wave while go is said, low otherwise. The watchdog runs on the clock that it would
// have to guard: where the clock stands still, go stays as it is, and only the edges here end.
// Latency: Clocks clocks from go_i to the first edge; 1 clock from the end of go_i.

module triaxis_beat #(
    parameter int unsigned Clocks = 50_000  // between two edges, at least 2
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic go_i,
    output logic beat_o
);

  typedef logic [$clog2(Clocks)-1:0] count_t;
  count_t count_q;
  logic   beat_q;
  assign beat_o = beat_q;

  logic last;
  assign last = count_q == count_t'(Clocks - 1);

  // In reset nobody says go.
  always_ff @(posedge clk_i) begin
    if (!go_i || last) count_q <= '0;
    else count_q <= count_q + count_t'(1);
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) beat_q <= 1'b0;
    else if (!go_i) beat_q <= 1'b0;
    else if (last) beat_q <= !beat_q;
  end

endmodule
