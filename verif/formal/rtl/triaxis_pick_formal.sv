// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The engine's pick against a set from which elements are taken: each lane of an accepted mask comes
// once, the lowest first, with its word, without gaps; drain_i empties it.

`include "triaxis_formal.svh"

module triaxis_pick_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Width = 8,
    parameter int unsigned Lanes = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic drain_i,
    input logic valid_i,
    input logic [Width-1:0] payload_i,
    input logic [Lanes-1:0] mask_i,
    input logic ready_i
);

  typedef logic [Width-1:0] word_t;
  typedef logic [Lanes-1:0] mask_t;

  logic ready_o, valid_o;
  word_t payload_o;
  logic [address_width(Lanes)-1:0] lane_o;

  triaxis_pick #(
      .T(word_t),
      .Lanes(Lanes)
  ) u_pick (
      .*
  );

  `TRIAXIS_RESET_FIRST

  // Lanes that have not come yet, and their word.
  mask_t left_q, left;
  word_t word_q;
  logic lower, last;
  always_comb begin
    left  = left_q;
    lower = 1'b0;
    for (int l = 0; l < int'(Lanes); l++) begin
      if (l < int'(lane_o) && left_q[l]) lower = 1'b1;
      if (l == int'(lane_o) && valid_o && ready_i) left[l] = 1'b0;
    end
    last = left == '0;
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) left_q <= '0;
    else if (drain_i) left_q <= '0;
    else if (valid_i && ready_o) left_q <= mask_i;
    else left_q <= left;
  end
  always_ff @(posedge clk_i) begin
    if (valid_i && ready_o) word_q <= payload_i;
  end

  always_comb begin
    Masks : assume (!valid_i || mask_i != '0);
    if (rst_ni) begin
      Offered : assert (valid_o == (left_q != '0));
      InMask : assert (!valid_o || left_q[lane_o]);
      LowestFirst : assert (!valid_o || !lower);
      ItsWord : assert (!valid_o || payload_o == word_q);
      NoGap : assert (ready_o == (last || drain_i));
      SameMask : assert (u_pick.mask_q == left_q);
      SeenLast : cover (valid_o && ready_i && last && int'(lane_o) == int'(Lanes) - 1 && valid_i);
      SeenMany : cover (valid_o && left_q == mask_t'('1) && !drain_i);
      SeenDrained : cover (valid_o && drain_i);
    end
  end

endmodule
