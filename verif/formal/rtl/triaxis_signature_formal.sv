// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What a triangle makes of a CRC, of what is pushed as of what is read again, from any CRC on. A CRC is the
// remainder of a division, bit by bit, highest power first. A step of that is linear, so all the steps of a
// triangle are: what these make of anything is the sum of what they make of each of its bits alone, and that is
// worked out here by the division.

`include "triaxis_formal.svh"

module triaxis_signature_formal #(
    parameter int unsigned W = 12,
    parameter int unsigned Depth = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    input logic [$clog2(Depth):0] count_i,
    input logic [9*W-1:0] triangle_read_i,
    input logic [1:0][31:0] remainders_i,
    input logic [1:0] next_i
);

  typedef logic [31:0] crc_t;
  typedef logic [9*W-1:0] triangle_t;
  typedef logic [9*W+31:0] sources_t;
  typedef logic [31:0][9*W+31:0] sums_t;

  localparam int unsigned CoordWidth = 8 * ((W + 7) / 8);
  localparam crc_t Polynomial = 32'h04C1_1DB7;

  crc_t signature_o;
  triaxis_mesh_scrub #(
      .W(W),
      .Depth(Depth)
  ) u_scrub (
      .scrub_i(1'b0),
      .read_o(),
      .index_o(),
      .index_read_o(),
      .box_i('{default: '0}),
      .group_i('{default: '0}),
      .intact_i(1'b1),
      .broken_o(),
      .trial_i(1'b0),
      .which_i('0),
      .*
  );

  function automatic crc_t divided(crc_t remainder, logic next);
    return {remainder[30:0], 1'b0} ^ (remainder[31] ^ next ? Polynomial : '0);
  endfunction

  // The register has the highest power lowest. Of a triangle come nine coordinates with their signs, of each
  // the lowest bit first.
  function automatic crc_t after_division(crc_t crc, triangle_t triangle);
    crc_t remainder;
    for (int i = 0; i < 32; i++) remainder[i] = crc[31-i];
    for (int k = 0; k < 9; k++) begin
      for (int i = 0; i < int'(CoordWidth); i++)
      remainder = divided(remainder, triangle[k*W+(i<int'(W)?i : W-1)]);
    end
    for (int i = 0; i < 32; i++) after_division[i] = remainder[31-i];
  endfunction

  // Of each bit: the bits of the triangle, and of the CRC before it, whose sum it is.
  function automatic sums_t sums_of();
    sources_t alone;
    crc_t after_alone;
    for (int i = 0; i < 9 * int'(W) + 32; i++) begin
      alone = sources_t'(1) << i;
      after_alone = after_division(alone[31:0], alone[32+:9*W]);
      for (int b = 0; b < 32; b++) sums_of[b][i] = after_alone[b];
    end
  endfunction
  localparam sums_t Sums = sums_of();

  function automatic crc_t after(crc_t crc, triangle_t triangle);
    sources_t sources;
    sources = {triangle, crc};
    for (int i = 0; i < 32; i++) after[i] = ^(Sums[i] & sources);
  endfunction

  crc_t came, came_q, due;
  logic keep, keep_q;
  assign came = ~signature_o;
  assign keep = push_i && !clear_i && 32'(count_i) != Depth;
  // Of what is pushed, as what is read in that clock counts no more.
  assign due  = after(push_i ? came : u_scrub.crc_q, push_i ? triangle_i : triangle_read_i);
  always_ff @(posedge clk_i) begin
    keep_q <= rst_ni && keep;
    came_q <= !rst_ni || clear_i ? '1 : keep ? due : came;
  end

  `TRIAXIS_FULL_AFTER(1)
  always_comb begin
    Linear :
    assert (divided(
        remainders_i[0] ^ remainders_i[1], ^next_i
    ) == (divided(
        remainders_i[0], next_i[0]
    ) ^ divided(
        remainders_i[1], next_i[1]
    )));
    Came : assert (!full || came == (rst_ni ? came_q : '1));
    Read : assert (u_scrub.crc_d == due);
    SeenKept : cover (full && keep_q && rst_ni && came != '1);
  end

endmodule
