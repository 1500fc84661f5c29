// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which lanes of a word hold one of count_i numbered things, Lanes to a word.
// Widths: a count of up to Words * Lanes has log2(Words * Lanes) + 1 bits.
// Latency: 0.

module triaxis_lane_mask
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Words = 64,
    parameter int unsigned Lanes = 8,
    localparam int unsigned CountWidth = $clog2(Words * Lanes) + 1
) (
    input logic [CountWidth-1:0] count_i,
    input logic [address_width(Words)-1:0] word_i,
    output logic [Lanes-1:0] mask_o
);

  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    assign mask_o[l] = CountWidth'(word_i) * CountWidth'(Lanes) + CountWidth'(l) < count_i;
  end

endmodule
