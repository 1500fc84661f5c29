// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mesh counts what it is given, and writes each triangle at its number, 3 clocks later.
// Boxes of groups and of the mesh as they are written: each holds the box of the triangle that is
// written and, but for the first of its group or mesh, the box so far; each of its faces is one of
// theirs. So by induction over the triangles a box is the smallest around all of them.

`include "triaxis_formal.svh"

// What is stored is what the first intake makes of it.
`define FIRST u_store.g_intake[0].u_intake

module triaxis_mesh_store_formal #(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i
);

  typedef logic signed [W-1:0] coord_t;

  typedef logic [$clog2(Depth):0] count_t;
  typedef logic [9*W-1:0] triangle_t;

  count_t count;
  coord_t object_o[2][3], boxes_o[Lanes][2][3], group_boxes_o[Lanes][2][3];

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
      .triangle_read_i(1'b0),
      .triangle_index_i('0),
      .triangle_o(),
      .triangle_intact_o(),
      .box_read_i(1'b0),
      .box_word_i('0),
      .boxes_o,
      .boxes_intact_o(),
      .group_read_i(1'b0),
      .group_word_i('0),
      .group_boxes_o,
      .groups_intact_o(),
      .trial_triangles_i(1'b0),
      .trial_boxes_i(1'b0),
      .trial_groups_i(1'b0),
      .trial_intake_i(1'b0),
      .which_i('0),
      .differ_o()
  );

  `TRIAXIS_PAST(count_t, counts, count, 3)
  `TRIAXIS_PAST(triangle_t, triangles, triangle_i, 3)
  `TRIAXIS_PAST(logic [2:0], pushes, {rst_ni && clear_i, rst_ni && push_i, rst_ni}, 1)
  logic cleared, pushed;
  assign {cleared, pushed} = pushes[0][2:1];

  always_comb begin
    if (rst_ni && pushes[0][0]) begin
      Counted :
      assert (count ==
              (cleared ? '0 : counts[0] + count_t'(pushed && counts[0] != count_t'(Depth))));
    end
    AtItsNumber :
    assert (u_store.index == counts[2][$clog2(Depth)-1:0] && u_store.triangles[0] == triangles[2]);
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
      if (u_store.write) begin
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

endmodule
