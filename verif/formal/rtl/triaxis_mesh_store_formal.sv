// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mesh counts what it is given, and writes each triangle at its number, 3 clocks later.
// Boxes of groups and of the mesh as they are written: each holds the box of the triangle that is
// written and, but for the first of its group or mesh, the box so far; each of its faces is one of
// theirs. So by induction over the triangles a box is the smallest around all of them.
// Each memory is read where a run asks for it, and where none does, for the scrub: a triangle with its own
// box and that of its group, once all of the mesh is written.

`include "triaxis_formal.svh"

// What is stored is what the first intake makes of it.
`define FIRST u_store.g_intake[0].u_intake

module triaxis_mesh_store_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2,
    localparam int unsigned WordWidth = address_width(Depth / Lanes),
    localparam int unsigned GroupWordWidth = address_width(Depth / Group / Lanes)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    input logic scrub_i,
    input logic triangle_read_i,
    input logic [$clog2(Depth)-1:0] triangle_index_i,
    input logic box_read_i,
    input logic [WordWidth-1:0] box_word_i,
    input logic group_read_i,
    input logic [GroupWordWidth-1:0] group_word_i
);

  typedef logic signed [W-1:0] coord_t;

  typedef logic [$clog2(Depth):0] count_t;
  typedef logic [9*W-1:0] triangle_t;

  count_t count;
  coord_t object_o[2][3], boxes_o[Lanes][2][3], group_boxes_o[Lanes][2][3];
  triangle_t triangle_read;
  logic triangle_intact;
  logic [Lanes-1:0] boxes_intact, groups_intact;

  triaxis_mesh_store #(
      .W(W),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes)
  ) u_store (
      .clk_i,
      .rst_ni,
      .clear_i,
      .push_i,
      .triangle_i,
      .count_o(count),
      .overfull_o(),
      .settled_o(),
      .object_o,
      .signature_o(),
      .scrub_i,
      .broken_o(),
      .triangle_read_i,
      .triangle_index_i,
      .triangle_o(triangle_read),
      .triangle_intact_o(triangle_intact),
      .box_read_i,
      .box_word_i,
      .boxes_o,
      .boxes_intact_o(boxes_intact),
      .group_read_i,
      .group_word_i,
      .group_boxes_o,
      .groups_intact_o(groups_intact),
      .trial_triangles_i(1'b0),
      .trial_boxes_i(1'b0),
      .trial_groups_i(1'b0),
      .trial_intake_i(1'b0),
      .trial_scrub_i(1'b0),
      .which_i('0),
      .differ_o()
  );

  `TRIAXIS_PAST(count_t, counts, count, 3)
  `TRIAXIS_PAST(triangle_t, triangles, triangle_i, 3)
  `TRIAXIS_PAST(logic [2:0], pushes, {rst_ni && clear_i, rst_ni && push_i, rst_ni}, 1)
  logic cleared, pushed;
  assign {cleared, pushed} = pushes[0][2:1];

  `TRIAXIS_FULL_AFTER(3)
  always_comb begin
    if (full && rst_ni && pushes[0][0]) begin
      Counted :
      assert (count ==
              (cleared ? '0 : counts[0] + count_t'(pushed && counts[0] != count_t'(Depth))));
    end
    AtItsNumber :
    assert (!full || (u_store.index == counts[2][$clog2(
        Depth
    )-1:0] && u_store.triangles[0] == triangles[2]));
  end

  logic first_in_group, first_in_mesh;
  assign first_in_group = u_store.index % Group == 0;
  assign first_in_mesh  = u_store.index == '0;

  for (genvar k = 0; k < 3; k++) begin : g_axis
    coord_t low, high, group_low, group_high, group_low_d, group_high_d;
    coord_t mesh_low, mesh_high, mesh_low_d, mesh_high_d;
    assign low = u_store.boxes[0][0][k];
    assign high = u_store.boxes[0][1][k];
    assign group_low = `FIRST.group_q[0][k];
    assign group_high = `FIRST.group_q[1][k];
    assign group_low_d = u_store.groups[0][0][k];
    assign group_high_d = u_store.groups[0][1][k];
    assign mesh_low = object_o[0][k];
    assign mesh_high = object_o[1][k];
    assign mesh_low_d = `FIRST.object_d[0][k];
    assign mesh_high_d = `FIRST.object_d[1][k];

    always_comb begin
      if (full && u_store.write) begin
        HoldsTriangle : assert (group_low_d <= low && group_high_d >= high);
        assert (mesh_low_d <= low && mesh_high_d >= high);
        HoldsGroup :
        assert (first_in_group || (group_low_d <= group_low && group_high_d >= group_high));
        HoldsMesh : assert (first_in_mesh || (mesh_low_d <= mesh_low && mesh_high_d >= mesh_high));
        SmallestGroup :
        assert ((group_low_d == low || (!first_in_group && group_low_d == group_low)) &&
                (group_high_d == high || (!first_in_group && group_high_d == group_high)));
        SmallestMesh :
        assert ((mesh_low_d == low || (!first_in_mesh && mesh_low_d == mesh_low)) &&
                (mesh_high_d == high || (!first_in_mesh && mesh_high_d == mesh_high)));
        SeenFirst : cover (first_in_group && !first_in_mesh);
        SeenLater : cover (!first_in_group && group_low < low && group_high < high);
      end
    end
  end

  // --- What is read -----------------------------------------------------------------------------------------

  logic scrubs, scrubbed, run_reads;
  logic [31:0] number, box_lane, group_lane;
  assign scrubs = u_store.u_scrub.read_o;
  assign run_reads = triangle_read_i || box_read_i || group_read_i;
  `TRIAXIS_PAST(logic [32:0], scrubs_at, {scrubs, 32'(u_store.u_scrub.index_o)}, 1)
  assign {scrubbed, number} = scrubs_at[0];
  assign box_lane = number % Lanes;
  assign group_lane = number / Group % Lanes;

  always_comb begin
    // That none comes is shown by `engine_walk`.
    NoRun : assume (!scrub_i || !run_reads);
    OnlyThen : assert (!scrubs || (scrub_i && !u_store.write));
    Triangle :
    assert (u_store.u_triangles.read_i == (scrubs || triangle_read_i) &&
            (scrub_i || !triangle_read_i ||
             u_store.u_triangles.read_address_i == triangle_index_i));
    ScrubTriangle : assert (!scrubs || u_store.u_triangles.read_address_i == u_store.scrub_index);
    if (full && scrubbed) begin
      // It is handed just what was read.
      Handed :
      assert (u_store.u_scrub.triangle_read_i == triangle_read && u_store.u_scrub.intact_i ==
              (triangle_intact && boxes_intact[box_lane] && groups_intact[group_lane]));
      for (int c = 0; c < 2; c++) begin
        for (int k = 0; k < 3; k++) begin
          assert (u_store.u_scrub.box_i[c][k] == boxes_o[box_lane][c][k]);
          assert (u_store.u_scrub.group_i[c][k] == group_boxes_o[group_lane][c][k]);
        end
      end
    end
    assert (u_store.u_scrub.count_i == count && u_store.u_scrub.clear_i == clear_i &&
            u_store.u_scrub.push_i == push_i && u_store.u_scrub.triangle_i == triangle_i);
    SeenScrubbed : cover (scrubbed && box_lane != group_lane);
  end

  for (genvar l = 0; l < Lanes; l++) begin : g_read
    always_comb begin
      Boxes :
      assert (u_store.g_lane[l].u_boxes.read_i == (scrubs || box_read_i) &&
              (scrub_i || !box_read_i ||
               u_store.g_lane[l].u_boxes.read_address_i == box_word_i));
      Groups :
      assert (u_store.g_lane[l].u_groups.read_i == (scrubs || group_read_i) &&
              (scrub_i || !group_read_i ||
               u_store.g_lane[l].u_groups.read_address_i == group_word_i));
      ScrubBoxes :
      assert (!scrubs || (32'(u_store.g_lane[l].u_boxes.read_address_i) ==
              32'(u_store.scrub_index) / Lanes && 32'(u_store.g_lane[l].u_groups.read_address_i) ==
              32'(u_store.scrub_index) / Group / Lanes));
    end
  end

endmodule
