// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a box of A, moved by the translation and grown by the margin.
// Widths: see triaxis_mesh_pkg; shift_i is translation - margin, then translation + margin.
// Latency: 1, while enable_i is high.

module triaxis_grow
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16
) (
    input logic clk_i,
    input logic enable_i,
    input logic signed [W-1:0] box_i[2][3],
    input logic signed [grown_width(W)-1:0] shift_i[2][3],
    output logic signed [grown_width(W)-1:0] grown_o[2][3]
);

  typedef logic signed [grown_width(W)-1:0] grown_t;

  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      always_ff @(posedge clk_i) begin
        if (enable_i) grown_o[c][k] <= grown_t'(box_i[c][k]) + shift_i[c][k];
      end
    end
  end

endmodule
