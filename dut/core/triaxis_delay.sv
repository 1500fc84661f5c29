// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: q_o = d_i, Cycles clocks later, for values that wait for others. Cycles = 0 is a wire.
// Widths: that of the type T. Latency: Cycles.

module triaxis_delay #(
    parameter type T = logic,
    parameter int unsigned Cycles = 1
) (
    input logic clk_i,
    input T d_i,
    output T q_o
);

  if (Cycles == 0) begin : g_wire
    logic unused_clk;
    assign unused_clk = clk_i;
    assign q_o = d_i;
  end else begin : g_regs
    for (genvar i = 0; i < Cycles; i++) begin : g_stage
      // A shift register of look-up tables takes long to give its bit: the last stage is a flip-flop.
      (* srl_style = "srl_reg" *) T stage_q;
      if (i == 0) begin : g_first
        always_ff @(posedge clk_i) stage_q <= d_i;
      end else begin : g_next
        always_ff @(posedge clk_i) stage_q <= g_stage[i-1].stage_q;
      end
    end
    assign q_o = g_stage[Cycles-1].stage_q;
  end

endmodule
