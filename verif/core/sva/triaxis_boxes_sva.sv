// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Operand gating, bound from outside the RTL: a pair that its boxes decide, or an empty slot, moves
// no operand, so that no multiplier toggles for it.

module triaxis_boxes_sva #(
    parameter int unsigned W = 16,
    parameter int unsigned MarginWidth = 1,
    parameter bit Gating = 1'b1
) (
    input logic clk_i,
    input logic valid,
    input logic [2:0] separated,
    input logic signed [W-1:0] operand_a_o[3][3],
    input logic signed [W-1:0] operand_b_o[3][3],
    input logic [MarginWidth-1:0] operand_margin_o
);

  // Checked only once the pipeline before the gate holds known values.
  logic known_q = 1'b0;
  always_ff @(posedge clk_i) known_q <= known_q || valid;

  if (Gating) begin : g_gating
    MarginHeld :
    assert property (@(posedge clk_i) known_q && (!valid || separated != '0) |=> $stable(
        operand_margin_o
    ))
    else $error("a margin moved for a pair that its boxes decide");
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      for (genvar k = 0; k < 3; k++) begin : g_coordinate
        OperandHeld :
        assert property (@(posedge clk_i) known_q && (!valid || separated != '0) |=> $stable(
            operand_a_o[v][k]
        ) && $stable(
            operand_b_o[v][k]
        ))
        else $error("an operand moved for a pair that its boxes decide");
      end
    end
  end

endmodule

bind triaxis_boxes triaxis_boxes_sva #(
    .W(W),
    .MarginWidth(triaxis_pkg::margin_width(M)),
    .Gating(Gating)
) u_sva (
    .clk_i,
    .valid,
    .separated,
    .operand_a_o,
    .operand_b_o,
    .operand_margin_o
);
