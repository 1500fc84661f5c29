// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: from a stream of words with a mask, one word with a lane number for each bit set,
// lowest lane first, one a clock without gaps. drain_i drops what is held and what comes.
// Widths: payload of type T, masks of Lanes bits, not zero.
// Latency: 1 from the accepting edge to the first lane.

module triaxis_pick
  import triaxis_mesh_pkg::*;
#(
    parameter type T = logic,
    parameter int unsigned Lanes = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic drain_i,
    input logic valid_i,
    output logic ready_o,
    input T payload_i,
    input logic [Lanes-1:0] mask_i,
    output logic valid_o,
    input logic ready_i,
    output T payload_o,
    output logic [address_width(Lanes)-1:0] lane_o
);

  typedef logic [Lanes-1:0] mask_t;
  typedef logic [address_width(Lanes)-1:0] lane_t;

  mask_t mask_q, rest;
  T payload_q;

  assign rest = mask_q & (mask_q - mask_t'(1));
  assign valid_o = mask_q != '0;
  assign ready_o = drain_i || mask_q == '0 || (ready_i && rest == '0);
  assign payload_o = payload_q;

  always_comb begin
    lane_o = lane_t'(Lanes - 1);
    for (int l = int'(Lanes) - 2; l >= 0; l--) begin
      if (mask_q[l]) lane_o = lane_t'(l);
    end
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) mask_q <= '0;
    else if (drain_i) mask_q <= '0;
    else if (valid_i && ready_o) mask_q <= mask_i;
    else if (ready_i) mask_q <= rest;
  end

  always_ff @(posedge clk_i) begin
    if (ready_o) payload_q <= payload_i;
  end

endmodule
