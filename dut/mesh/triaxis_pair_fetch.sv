// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the vertices of a pair from its numbers, A moved by the translation, as the core takes
// them. Pairs that come while drain_i is high are dropped; one that is already on its way stays.
// Widths: A moved stays within W bits: runs in which it would not are refused before they start.
// Latency: 2 from a pair's numbers to its offer.

module triaxis_pair_fetch
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    localparam int unsigned IndexWidth = $clog2(Depth)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic drain_i,

    input logic signed [move_width(W)-1:0] move_i[3],

    input logic valid_i,
    output logic ready_o,
    input logic [IndexWidth-1:0] index_a_i,
    input logic [IndexWidth-1:0] index_b_i,
    input zone_e zone_i,

    output logic read_o,
    output logic used_o,  // the triangles, in this clock
    input logic [9*W-1:0] triangle_a_i,
    input logic [9*W-1:0] triangle_b_i,

    output logic valid_o,
    input logic ready_i,
    output logic [18*W-1:0] pair_o,
    output logic [IndexWidth-1:0] index_a_o,
    output logic [IndexWidth-1:0] index_b_o,
    output zone_e zone_o
);

  typedef logic [IndexWidth-1:0] index_t;

  logic enable, read_valid_q;
  index_t read_a_q, read_b_q;
  zone_e read_zone_q;
  logic [9*W-1:0] moved;

  assign enable  = !valid_o || ready_i;
  assign ready_o = enable;
  assign read_o  = valid_i && enable;
  assign used_o  = read_valid_q && enable;

  for (genvar i = 0; i < 9; i++) begin : g_move
    assign moved[i*W+:W] = triangle_a_i[i*W+:W] + move_i[i%3][W-1:0];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      read_valid_q <= 1'b0;
      valid_o <= 1'b0;
    end else if (enable) begin
      read_valid_q <= valid_i && !drain_i;
      valid_o <= read_valid_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (enable) begin
      read_a_q <= index_a_i;
      read_b_q <= index_b_i;
      read_zone_q <= zone_i;
      index_a_o <= read_a_q;
      index_b_o <= read_b_q;
      zone_o <= read_zone_q;
      pair_o[0+:9*W] <= moved;
      pair_o[9*W+:9*W] <= triangle_b_i;
    end
  end

  // The sign of a translation matters where boxes are compared; here two's complement has no need
  // of it.
  logic unused_sign;
  assign unused_sign = ^{move_i[0][W], move_i[1][W], move_i[2][W]};
endmodule
