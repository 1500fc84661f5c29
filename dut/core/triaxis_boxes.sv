// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the three box axes, and the operands of everything behind them. A pair that its boxes
// decide, or an empty slot, leaves the last operands in place, so that no multiplier toggles for it.
// Widths: coordinates W bits, margin M bits.
// Latency: BoxLatency + GateLatency.

`include "triaxis_stage.svh"

module triaxis_boxes
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Gating = 1'b1,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic valid_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    output logic [2:0] separated_o,
    output logic signed [W-1:0] operand_a_o[3][3],
    output logic signed [W-1:0] operand_b_o[3][3],
    output logic [margin_width(M)-1:0] operand_margin_o
);

  localparam int unsigned Wait = Comb ? 0 : BoxLatency;
  typedef logic signed [W-1:0] triangle_t[3][3];
  typedef logic [margin_width(M)-1:0] margin_t;

  logic [2:0] separated;
  logic valid, open;
  triangle_t a, b;
  margin_t margin;

  for (genvar k = 0; k < 3; k++) begin : g_box
    logic signed [W-1:0] a_points[3], b_points[3];
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      assign a_points[v] = a_i[v][k];
      assign b_points[v] = b_i[v][k];
    end
    triaxis_box #(
        .W(W),
        .M(M),
        .Comb(Comb)
    ) u_box (
        .clk_i,
        .a_i(a_points),
        .b_i(b_points),
        .margin_i,
        .separated_o(separated[k])
    );
  end

  triaxis_delay #(
      .Cycles(Wait)
  ) u_valid (
      .clk_i,
      .d_i(valid_i),
      .q_o(valid)
  );
  triaxis_delay #(
      .T(triangle_t),
      .Cycles(Wait)
  ) u_a (
      .clk_i,
      .d_i(a_i),
      .q_o(a)
  );
  triaxis_delay #(
      .T(triangle_t),
      .Cycles(Wait)
  ) u_b (
      .clk_i,
      .d_i(b_i),
      .q_o(b)
  );
  triaxis_delay #(
      .T(margin_t),
      .Cycles(Wait)
  ) u_margin (
      .clk_i,
      .d_i(margin_i),
      .q_o(margin)
  );

  `TRIAXIS_STAGE(separated_o, separated)

  assign open = valid && (!Gating || separated == '0);
  if (Comb) begin : g_wire
    logic unused_open;
    assign unused_open = open;
    assign operand_a_o = a;
    assign operand_b_o = b;
    assign operand_margin_o = margin;
  end else begin : g_gate
    always_ff @(posedge clk_i) begin
      if (open) begin
        operand_a_o <= a;
        operand_b_o <= b;
        operand_margin_o <= margin;
      end
    end
  end

endmodule
