// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the real ones' headers, in the proof `engine_again`. What has no driver is anything at each
// clock.

// Any words, at any clocks.
module triaxis_mesh_store;

endmodule

// Any pairs of groups and triangles, at any clocks.
// verilog_lint: waive module-filename
module triaxis_group_rows;

endmodule

// verilog_lint: waive module-filename
module triaxis_group_words;

endmodule

// verilog_lint: waive module-filename
module triaxis_pair_boxes;

endmodule

// Any verdicts, at any clocks, of as many pairs at a time as it has places: `certified`.
// verilog_lint: waive module-filename
module triaxis_certified_core;

  localparam int unsigned Places = 2 ** $clog2(certified_latency(W, M));
  typedef logic [$clog2(Places):0] count_t;
  count_t held_q;
  logic free_ready, free_valid;

  assign s_axis_tready_o = free_ready && held_q != count_t'(Places);
  assign m_axis_tvalid_o = free_valid && held_q != '0;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) held_q <= '0;
    else
      held_q <= held_q + count_t'(s_axis_tvalid_i && s_axis_tready_o) -
          count_t'(m_axis_tvalid_o && m_axis_tready_i);
  end

endmodule
