// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: one mesh in memory: its triangles, their boxes, the boxes of groups of Group consecutive
// triangles and the box of the whole. Boxes are computed here from the vertices, never handed in,
// for every skip rests on them. Boxes are kept in Lanes banks, so that one read yields a word of
// Lanes boxes: number i lies in lane i mod Lanes of word i / Lanes.
// Widths: coordinates W bits; a count of triangles has log2(Depth)+1 bits, for Depth itself. A
// triangle beyond Depth is dropped and reported: overfull_o, until the mesh is emptied.
// Latency: 4 from push_i until the triangle and its boxes can be read; settled_o says so. 1 from a
// read to its data.

module triaxis_mesh_store
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned WordWidth = address_width(Depth / Lanes),
    localparam int unsigned GroupWordWidth = address_width(Depth / Group / Lanes)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    output logic [IndexWidth:0] count_o,
    output logic overfull_o,
    output logic settled_o,
    output logic signed [W-1:0] object_o[2][3],

    input logic triangle_read_i,
    input logic [IndexWidth-1:0] triangle_index_i,
    output logic [9*W-1:0] triangle_o,

    input logic box_read_i,
    input logic [WordWidth-1:0] box_word_i,
    output logic signed [W-1:0] boxes_o[Lanes][2][3],

    input logic group_read_i,
    input logic [GroupWordWidth-1:0] group_word_i,
    output logic signed [W-1:0] group_boxes_o[Lanes][2][3]
);

  localparam int unsigned ExtentLatency = 2;
  localparam int unsigned LaneBits = $clog2(Lanes);
  localparam int unsigned GroupBits = $clog2(Group);
  localparam int unsigned BoxWidth = 6 * W;

  typedef logic signed [W-1:0] coord_t;
  typedef logic [9*W-1:0] triangle_t;
  typedef logic [1:0][2:0][W-1:0] box_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;

  localparam index_t LastLane = index_t'(Lanes - 1);

  // --- Count ----------------------------------------------------------------------------------------

  logic full, keep;
  count_t count_q;
  assign full = count_q == count_t'(Depth);
  assign keep = push_i && !full;
  assign count_o = count_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      overfull_o <= 1'b0;
    end else if (clear_i) begin
      count_q <= '0;
      overfull_o <= 1'b0;
    end else begin
      if (keep) count_q <= count_q + count_t'(1);
      if (push_i && full) overfull_o <= 1'b1;
    end
  end

  // --- The box of a triangle --------------------------------------------------------------------------

  triangle_t triangle_q, triangle;
  index_t index_q, index;
  logic [ExtentLatency:0] valid_q;
  coord_t box[2][3];

  always_ff @(posedge clk_i) begin
    triangle_q <= triangle_i;
    index_q <= count_q[IndexWidth-1:0];
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[ExtentLatency-1:0], keep};
  end
  assign settled_o = valid_q == '0;

  for (genvar k = 0; k < 3; k++) begin : g_extent
    coord_t points[3];
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      assign points[v] = triangle_q[(3*v+k)*W+:W];
    end
    triaxis_extent #(
        .W(W)
    ) u_extent (
        .clk_i,
        .points_i(points),
        .low_o(box[0][k]),
        .high_o(box[1][k])
    );
  end

  triaxis_delay #(
      .T(triangle_t),
      .Cycles(ExtentLatency)
  ) u_triangle (
      .clk_i,
      .d_i(triangle_q),
      .q_o(triangle)
  );
  triaxis_delay #(
      .T(index_t),
      .Cycles(ExtentLatency)
  ) u_index (
      .clk_i,
      .d_i(index_q),
      .q_o(index)
  );

  // --- The boxes of its group and of the mesh -----------------------------------------------------------

  logic write, first_in_group, first_in_mesh;
  coord_t object_d[2][3], group_d[2][3], group_q[2][3];
  assign write = valid_q[ExtentLatency];
  assign first_in_mesh = index == '0;
  assign first_in_group = (index & index_t'(Group - 1)) == '0;

  for (genvar k = 0; k < 3; k++) begin : g_union
    always_comb begin
      group_d[0][k]  = box[0][k];
      group_d[1][k]  = box[1][k];
      object_d[0][k] = box[0][k];
      object_d[1][k] = box[1][k];
      if (!first_in_group && group_q[0][k] < box[0][k]) group_d[0][k] = group_q[0][k];
      if (!first_in_group && group_q[1][k] > box[1][k]) group_d[1][k] = group_q[1][k];
      if (!first_in_mesh && object_o[0][k] < box[0][k]) object_d[0][k] = object_o[0][k];
      if (!first_in_mesh && object_o[1][k] > box[1][k]) object_d[1][k] = object_o[1][k];
    end
  end

  always_ff @(posedge clk_i) begin
    if (write) begin
      group_q  <= group_d;
      object_o <= object_d;
    end
  end

  // --- Memories -------------------------------------------------------------------------------------

  triaxis_ram #(
      .Width(9 * W),
      .Words(Depth)
  ) u_triangles (
      .clk_i,
      .write_i(write),
      .write_address_i(index),
      .write_data_i(triangle),
      .read_i(triangle_read_i),
      .read_address_i(triangle_index_i),
      .read_data_o(triangle_o)
  );

  box_t box_flat, group_flat;
  logic [WordWidth-1:0] box_write_word;
  logic [GroupWordWidth-1:0] group_write_word;
  for (genvar c = 0; c < 2; c++) begin : g_flat_corner
    for (genvar k = 0; k < 3; k++) begin : g_flat
      assign box_flat[c][k]   = box[c][k];
      assign group_flat[c][k] = group_d[c][k];
    end
  end
  assign box_write_word   = WordWidth'(index >> LaneBits);
  assign group_write_word = GroupWordWidth'(index >> (GroupBits + LaneBits));

  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    logic write_box, write_group;
    box_t box_read, group_read;

    assign write_box   = write && (index & LastLane) == index_t'(l);
    assign write_group = write && ((index >> GroupBits) & LastLane) == index_t'(l);

    triaxis_ram #(
        .Width(BoxWidth),
        .Words(Depth / Lanes)
    ) u_boxes (
        .clk_i,
        .write_i(write_box),
        .write_address_i(box_write_word),
        .write_data_i(box_flat),
        .read_i(box_read_i),
        .read_address_i(box_word_i),
        .read_data_o(box_read)
    );

    triaxis_ram #(
        .Width(BoxWidth),
        .Words(Depth / Group / Lanes)
    ) u_groups (
        .clk_i,
        .write_i(write_group),
        .write_address_i(group_write_word),
        .write_data_i(group_flat),
        .read_i(group_read_i),
        .read_address_i(group_word_i),
        .read_data_o(group_read)
    );

    for (genvar c = 0; c < 2; c++) begin : g_corner
      for (genvar k = 0; k < 3; k++) begin : g_axis
        assign boxes_o[l][c][k] = box_read[c][k];
        assign group_boxes_o[l][c][k] = group_read[c][k];
      end
    end
  end

endmodule
