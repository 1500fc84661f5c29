// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the harnesses share. Modules that use it have a clock clk_i.

`ifndef TRIAXIS_FORMAL_SVH
`define TRIAXIS_FORMAL_SVH

// The first clock is one of reset; from then on rst_ni is free.
`define TRIAXIS_RESET_FIRST \
  logic started_q = 1'b0; \
  always_ff @(posedge clk_i) started_q <= 1'b1; \
  always_comb begin \
    Reset : assume (started_q || !rst_ni); \
  end

// full: so many clocks have passed that whatever the module began with has left it.
`define TRIAXIS_FULL_AFTER(clocks) \
  logic [$clog2((clocks)+1)-1:0] clocks_q = '0; \
  logic full; \
  assign full = clocks_q == ($clog2((clocks)+1))'(clocks); \
  always_ff @(posedge clk_i) if (!full) clocks_q <= clocks_q + ($clog2((clocks)+1))'(1);

// past[i]: what value was i + 1 clocks ago, for so many clocks.
`define TRIAXIS_PAST(value_t, past, value, clocks) \
  value_t past[clocks]; \
  always_ff @(posedge clk_i) begin \
    past[0] <= value; \
    for (int i = 1; i < int'(clocks); i++) past[i] <= past[i-1]; \
  end

`endif
