// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// One register between two steps of the data path: q takes d at each clock edge. Modules that use
// it have a clock clk_i and a parameter Comb; Comb = 1 makes it a wire.

`ifndef TRIAXIS_STAGE_SVH
`define TRIAXIS_STAGE_SVH

`define TRIAXIS_STAGE(q, d) \
  if (Comb) begin : g_``q``_wire \
    logic unused_clk; \
    assign unused_clk = clk_i; \
    assign q = d; \
  end else begin : g_``q``_reg \
    always_ff @(posedge clk_i) q <= d; \
  end

`endif
