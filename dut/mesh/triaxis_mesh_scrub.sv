// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether a mesh in memory is still the one that was loaded. signature_o is the CRC-32 of what came:
// the coordinates in the order of LOAD, each of ceil(W / 8) bytes, sign-extended, lowest byte first; a host
// computes it too. While scrub_i the mesh is read, a triangle a clock, over and over: its words must be
// intact, the triangle within its box, the box within that of its group, and at the end of the mesh the CRC-32
// of what was read that of what came. So a write that was lost is found as well, which parity does not
// show: of a triangle all but one in some 2^32, of a box where it leaves one that is too small.
// Widths: coordinates W bits; a count of triangles has log2(Depth)+1 bits, for Depth itself.
// Latency: a fault is found Depth + 1 clocks of scrub_i after it came, or sooner, where nothing is loaded; one
// that only the CRC-32 shows up to 2 Depth + 1, as the mesh must be read whole.

module triaxis_mesh_scrub
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    localparam int unsigned IndexWidth = $clog2(Depth)
) (
    input logic clk_i,
    input logic rst_ni,

    // What is loaded, and how much was before.
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    input logic [IndexWidth:0] count_i,
    output logic [31:0] signature_o,

    input logic scrub_i,  // nothing is under way, and no one else reads
    output logic read_o,
    output logic [IndexWidth-1:0] index_o,

    // In the clock after read_o.
    output logic [IndexWidth-1:0] index_read_o,
    input logic [9*W-1:0] triangle_read_i,
    input logic signed [W-1:0] box_i[2][3],
    input logic signed [W-1:0] group_i[2][3],
    input logic intact_i,
    output logic broken_o,

    // What is tried: each eighth bit of the signature is misread, from which_i on; or, from 8 on, the bounds on
    // one of three axes of boxes, and then of groups, are inverted: nothing lies within such bounds.
    input logic trial_i,
    input logic [3:0] which_i
);

  localparam int unsigned CoordWidth = 8 * ((W + 7) / 8);

  typedef logic signed [W-1:0] coord_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;

  // A CRC is linear: each bit of what it is after a triangle is a sum of bits of the triangle and of what it was
  // before. These sums, bit by bit of the bytes, so that no chain of shifts is left to be optimised.
  typedef logic [9*W+31:0] sources_t;  // {triangle, before}
  typedef logic [31:0][9*W+31:0] sums_t;
  function automatic sums_t sums_after();
    sums_t sums;
    sources_t first;
    for (int unsigned i = 0; i < 32; i++) sums[i] = sources_t'(1) << i;
    for (int unsigned i = 0; i < 9; i++) begin
      for (int unsigned bit_index = 0; bit_index < CoordWidth; bit_index++) begin
        first = sums[0] ^ sources_t'(1) << 32 + i * W + (bit_index < W ? bit_index : W - 1);
        for (int unsigned b = 0; b < 31; b++) sums[b] = sums[b+1] ^ (CrcPolynomial[b] ? first : '0);
        sums[31] = first;
      end
    end
    return sums;
  endfunction
  localparam sums_t SumsAfter = sums_after();

  function automatic logic [31:0] after_triangle(logic [31:0] crc, logic [9*W-1:0] triangle);
    sources_t sources;
    sources = {triangle, crc};
    for (int unsigned i = 0; i < 32; i++) after_triangle[i] = ^(SumsAfter[i] & sources);
  endfunction

  // --- What came ------------------------------------------------------------------------------------

  logic keep;
  logic [31:0] came_q, crc_q, crc_d;
  assign keep = push_i && count_i != count_t'(Depth);
  assign signature_o = ~came_q;

  // Of what comes or, in other clocks, of what is read: the sums are most of this module. What comes out for the
  // former a host looks at.
  assign crc_d = after_triangle(push_i ? came_q : crc_q, push_i ? triangle_i : triangle_read_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) came_q <= '1;
    else if (clear_i) came_q <= '1;
    else if (keep) came_q <= crc_d;
  end

  // --- What is there --------------------------------------------------------------------------------

  index_t index_q;
  logic   last;
  assign read_o  = scrub_i && count_i != '0;
  assign index_o = index_q;
  assign last    = count_t'(index_q) + count_t'(1) == count_i;

  // What is loaded begins it anew: a word that is read just then counts no more.
  logic load, reading_q, last_q;
  assign load = clear_i || push_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      index_q <= '0;
      reading_q <= 1'b0;
      crc_q <= '1;
    end else if (load) begin
      index_q <= '0;
      reading_q <= 1'b0;
      crc_q <= '1;
    end else begin
      if (read_o) index_q <= last ? '0 : index_q + index_t'(1);
      reading_q <= read_o;
      if (reading_q) crc_q <= last_q ? '1 : crc_d;
    end
  end

  always_ff @(posedge clk_i) begin
    if (read_o) begin
      index_read_o <= index_o;
      last_q <= last;
    end
  end

  logic [31:0] misread;
  logic [2:0] axes_inverted[2];
  logic [2:0][7:0] outside;
  logic unlike;
  for (genvar i = 0; i < 32; i++) begin : g_misread
    assign misread[i] = trial_i && which_i == 4'(i % 8);
  end
  assign unlike = last_q && (crc_d ^ misread) != came_q;

  for (genvar k = 0; k < 3; k++) begin : g_axis
    coord_t box[2], group[2];
    assign axes_inverted[0][k] = trial_i && which_i == 4'(8 + k);
    assign axes_inverted[1][k] = trial_i && which_i == 4'(11 + k);
    for (genvar c = 0; c < 2; c++) begin : g_corner
      assign box[c]   = box_i[c][k] ^ {W{axes_inverted[0][k]}};
      assign group[c] = group_i[c][k] ^ {W{axes_inverted[1][k]}};
    end
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      coord_t vertex;
      assign vertex = triangle_read_i[(3*v+k)*W+:W];
      assign outside[k][2*v] = vertex < box[0];
      assign outside[k][2*v+1] = vertex > box[1];
    end
    assign outside[k][6] = box_i[0][k] < group[0];
    assign outside[k][7] = box_i[1][k] > group[1];
  end

  assign broken_o = reading_q && !load && (!intact_i || unlike || outside != '0);

endmodule
