// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: one mesh in memory: its triangles, their boxes, the boxes of groups of Group consecutive
// triangles and the box of the whole, see triaxis_mesh_intake. Boxes are kept in Lanes banks, so that one
// read yields a word of Lanes boxes: number i lies in lane i mod Lanes of word i / Lanes. All that is kept
// has parity, and is looked at again while scrub_i, see triaxis_mesh_scrub; what is to be kept is made twice, by
// two intakes, and differ_o says that they did in the last clock.
// Widths: coordinates W bits; a count of triangles has log2(Depth)+1 bits, for Depth itself.
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
    output logic [31:0] signature_o,

    input  logic scrub_i,  // no run is going on: none of the reads below comes
    output logic broken_o,

    input logic triangle_read_i,
    input logic [IndexWidth-1:0] triangle_index_i,
    output logic [9*W-1:0] triangle_o,
    output logic triangle_intact_o,

    input logic box_read_i,
    input logic [WordWidth-1:0] box_word_i,
    output logic signed [W-1:0] boxes_o[Lanes][2][3],
    output logic [Lanes-1:0] boxes_intact_o,

    input logic group_read_i,
    input logic [GroupWordWidth-1:0] group_word_i,
    output logic signed [W-1:0] group_boxes_o[Lanes][2][3],
    output logic [Lanes-1:0] groups_intact_o,

    // What is tried: words of a memory are taken as broken; the second intake is misread, in each 32nd bit.
    input logic trial_triangles_i,
    input logic trial_boxes_i,
    input logic trial_groups_i,
    input logic trial_intake_i,
    input logic trial_scrub_i,
    input logic [4:0] which_i,
    output logic differ_o
);

  localparam int unsigned LaneBits = $clog2(Lanes);
  localparam int unsigned LaneWidth = address_width(Lanes);
  localparam int unsigned GroupBits = $clog2(Group);
  localparam int unsigned SeenWidth = intake_seen_width(W, Depth);

  typedef logic signed [W-1:0] coord_t;
  typedef logic [9*W-1:0] triangle_t;
  typedef logic [5:0][W-1:0] box_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;
  typedef logic [SeenWidth-1:0] seen_t;

  localparam index_t LastLane = index_t'(Lanes - 1);

  // --- What comes, twice ----------------------------------------------------------------------------

  count_t counts[2];
  logic [1:0] overfull, settled, writes;
  coord_t objects[2][2][3], boxes[2][2][3], groups[2][2][3];
  index_t indices[2];
  triangle_t triangles[2];
  seen_t seen[2];
  for (genvar i = 0; i < 2; i++) begin : g_intake
    // Never to be made one, as they are the same.
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_mesh_intake #(
        .W(W),
        .Depth(Depth),
        .Group(Group)
    ) u_intake (
        .clk_i,
        .rst_ni,
        .clear_i,
        .push_i,
        .triangle_i,
        .count_o(counts[i]),
        .overfull_o(overfull[i]),
        .settled_o(settled[i]),
        .object_o(objects[i]),
        .write_o(writes[i]),
        .index_o(indices[i]),
        .triangle_o(triangles[i]),
        .box_o(boxes[i]),
        .group_o(groups[i]),
        .seen_o(seen[i])
    );
  end

  // Of the second only what it shows is looked at.
  logic unused_second;
  assign unused_second = ^{counts[1], overfull[1], settled[1], writes[1], indices[1], triangles[1]};
  for (genvar c = 0; c < 2; c++) begin : g_unused_corner
    for (genvar k = 0; k < 3; k++) begin : g_unused
      logic unused_boxes;
      assign unused_boxes = ^{objects[1][c][k], boxes[1][c][k], groups[1][c][k]};
    end
  end

  seen_t misread, second;
  for (genvar i = 0; i < SeenWidth; i++) begin : g_misread
    assign misread[i] = trial_intake_i && 5'(i) == which_i;
  end
  assign second   = seen[1] ^ misread;
  // In a reset they do not.
  assign differ_o = seen[0] != second;

  logic   write;
  index_t index;
  assign count_o = counts[0];
  assign overfull_o = overfull[0];
  assign settled_o = settled[0];
  assign object_o = objects[0];
  assign write = writes[0];
  assign index = indices[0];

  // --- What is there, again ---------------------------------------------------------------------------

  logic scrub, scrub_read, scrub_intact;
  index_t scrub_index, scrubbed;
  coord_t scrub_box[2][3], scrub_group[2][3];
  assign scrub = scrub_i && settled_o;

  triaxis_mesh_scrub #(
      .W(W),
      .Depth(Depth)
  ) u_scrub (
      .clk_i,
      .rst_ni,
      .clear_i,
      .push_i,
      .triangle_i,
      .count_i(count_o),
      .signature_o,
      .scrub_i(scrub),
      .read_o(scrub_read),
      .index_o(scrub_index),
      .index_read_o(scrubbed),
      .triangle_read_i(triangle_o),
      .box_i(scrub_box),
      .group_i(scrub_group),
      .intact_i(scrub_intact),
      .broken_o,
      .trial_i(trial_scrub_i),
      .which_i(which_i[3:0])
  );

  // --- Memories -------------------------------------------------------------------------------------

  logic read_triangle, read_box, read_group;
  index_t triangle_index;
  logic [WordWidth-1:0] box_word;
  logic [GroupWordWidth-1:0] group_word;
  assign read_triangle = scrub_read || triangle_read_i;
  assign read_box = scrub_read || box_read_i;
  assign read_group = scrub_read || group_read_i;
  assign triangle_index = scrub_read ? scrub_index : triangle_index_i;
  assign box_word = scrub_read ? WordWidth'(scrub_index >> LaneBits) : box_word_i;
  assign group_word =
      scrub_read ? GroupWordWidth'(scrub_index >> (GroupBits + LaneBits)) : group_word_i;

  triaxis_parity_ram #(
      .Pieces(9),
      .PieceWidth(W),
      .Words(Depth)
  ) u_triangles (
      .clk_i,
      .write_i(write),
      .write_address_i(index),
      .write_data_i(triangles[0]),
      .read_i(read_triangle),
      .read_address_i(triangle_index),
      .trial_i(trial_triangles_i),
      .read_data_o(triangle_o),
      .intact_o(triangle_intact_o)
  );

  box_t box_flat, group_flat;
  logic [WordWidth-1:0] box_write_word;
  logic [GroupWordWidth-1:0] group_write_word;
  for (genvar c = 0; c < 2; c++) begin : g_flat_corner
    for (genvar k = 0; k < 3; k++) begin : g_flat
      assign box_flat[3*c+k]   = boxes[0][c][k];
      assign group_flat[3*c+k] = groups[0][c][k];
    end
  end
  assign box_write_word   = WordWidth'(index >> LaneBits);
  assign group_write_word = GroupWordWidth'(index >> (GroupBits + LaneBits));

  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    logic write_box, write_group;
    box_t box_read, group_read;

    assign write_box   = write && (index & LastLane) == index_t'(l);
    assign write_group = write && ((index >> GroupBits) & LastLane) == index_t'(l);

    triaxis_parity_ram #(
        .Pieces(6),
        .PieceWidth(W),
        .Words(Depth / Lanes)
    ) u_boxes (
        .clk_i,
        .write_i(write_box),
        .write_address_i(box_write_word),
        .write_data_i(box_flat),
        .read_i(read_box),
        .read_address_i(box_word),
        .trial_i(trial_boxes_i),
        .read_data_o(box_read),
        .intact_o(boxes_intact_o[l])
    );

    triaxis_parity_ram #(
        .Pieces(6),
        .PieceWidth(W),
        .Words(Depth / Group / Lanes)
    ) u_groups (
        .clk_i,
        .write_i(write_group),
        .write_address_i(group_write_word),
        .write_data_i(group_flat),
        .read_i(read_group),
        .read_address_i(group_word),
        .trial_i(trial_groups_i),
        .read_data_o(group_read),
        .intact_o(groups_intact_o[l])
    );

    for (genvar c = 0; c < 2; c++) begin : g_corner
      for (genvar k = 0; k < 3; k++) begin : g_axis
        assign boxes_o[l][c][k] = box_read[3*c+k];
        assign group_boxes_o[l][c][k] = group_read[3*c+k];
      end
    end
  end

  logic [LaneWidth-1:0] box_lane, group_lane;
  assign box_lane = LaneWidth'(scrubbed & LastLane);
  assign group_lane = LaneWidth'((scrubbed >> GroupBits) & LastLane);
  assign scrub_box = boxes_o[box_lane];
  assign scrub_group = group_boxes_o[group_lane];
  assign scrub_intact =
      triangle_intact_o && boxes_intact_o[box_lane] && groups_intact_o[group_lane];

endmodule
