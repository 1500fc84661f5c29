// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The two intakes of a mesh, as they are: they begin with different registers, and yet never show a
// difference, but where one is misread; and that is told at once.

`include "triaxis_formal.svh"

`define FIRST u_store.g_intake[0].u_intake
`define SECOND u_store.g_intake[1].u_intake

module triaxis_intakes_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 16,
    parameter int unsigned Group = 4,
    parameter int unsigned Lanes = 2
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    input logic trial_intake_i,
    input logic [4:0] which_i
);

  localparam int unsigned SeenWidth = intake_seen_width(W, Depth);
  typedef logic signed [W-1:0] coord_t;

  coord_t object_o[2][3], boxes_o[Lanes][2][3], group_boxes_o[Lanes][2][3];
  logic settled, differ;
  triaxis_mesh_store #(
      .W(W),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes)
  ) u_store (
      .count_o(),
      .overfull_o(),
      .settled_o(settled),
      .object_o,
      .signature_o(),
      .scrub_i(1'b0),
      .broken_o(),
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
      .trial_scrub_i(1'b0),
      .differ_o(differ),
      .*
  );

  `TRIAXIS_RESET_FIRST

  logic [SeenWidth-1:0] misread;
  for (genvar i = 0; i < SeenWidth; i++) begin : g_misread
    assign misread[i] = trial_intake_i && i % 32 == 32'(which_i);
  end

  // The oldest triangle that is under way, or the next one: where it is the first of a mesh, what is known of
  // groups and of the mesh does not count yet.
  logic [$clog2(Depth)-1:0] oldest;
  logic same_groups, same_objects;
  always_comb begin
    oldest = u_store.counts[0][$clog2(Depth)-1:0];
    if (`FIRST.valid_q[0]) oldest = `FIRST.index_q;
    if (`FIRST.valid_q[1]) oldest = `FIRST.u_index.g_regs.g_stage[0].stage_q;
    if (`FIRST.valid_q[2]) oldest = u_store.index;
    same_groups  = 1'b1;
    same_objects = 1'b1;
    for (int c = 0; c < 2; c++) begin
      for (int k = 0; k < 3; k++) begin
        same_groups &= `FIRST.group_q[c][k] == `SECOND.group_q[c][k];
        same_objects &= `FIRST.object_o[c][k] == `SECOND.object_o[c][k];
      end
    end
  end

  always_comb begin
    if (rst_ni) begin
      Alike : assert (differ == (misread != '0));
      SeenTold : cover (differ && !settled);
      // What makes it inductive.
      assert (u_store.counts[0] == u_store.counts[1] && ^u_store.overfull == 1'b0);
      assert (`FIRST.valid_q == `SECOND.valid_q);
      assert (same_groups || oldest == '0);
      assert (same_objects || (oldest == '0 && (!settled || u_store.counts[0] == '0)));
    end
  end

endmodule
