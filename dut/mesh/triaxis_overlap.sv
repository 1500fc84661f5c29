// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: for each of Lanes boxes whether no coordinate axis separates it from a box that has
// been grown by the margin. A zero is a proof: min B > max A + m or max B < min A - m on one axis,
// the very test of triaxis_box, so no pair within the margin is ever skipped.
// Widths: boxes W bits, [0] low, [1] high corner; the grown box grown_width(W), see
// triaxis_mesh_pkg.
// Latency: 0.

module triaxis_overlap
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Lanes = 8
) (
    input logic signed [grown_width(W)-1:0] grown_i[2][3],
    input logic signed [W-1:0] boxes_i[Lanes][2][3],
    output logic [Lanes-1:0] overlap_o
);

  typedef logic signed [grown_width(W)-1:0] grown_t;

  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    logic [2:0] apart;
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign apart[k] = grown_t'(boxes_i[l][0][k]) > grown_i[1][k] ||
          grown_t'(boxes_i[l][1][k]) < grown_i[0][k];
    end
    assign overlap_o[l] = apart == '0;
  end

endmodule
