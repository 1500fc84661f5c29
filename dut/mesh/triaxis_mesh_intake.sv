// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what is to be stored of a mesh whose triangles come one after another: each at its number, with
// its box, and the box of its group so far; and the box of the whole. Boxes are computed here from the
// vertices, never handed in, for every skip rests on them.
// Widths: coordinates W bits; a count of triangles has log2(Depth)+1 bits, for Depth itself. A triangle
// beyond Depth is dropped and reported: overfull_o, until the mesh is emptied.
// Latency: 3 from push_i to write_o; settled_o says that nothing is under way.

module triaxis_mesh_intake
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    localparam int unsigned IndexWidth = $clog2(Depth),
    localparam int unsigned SeenWidth = intake_seen_width(W, Depth)
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

    output logic write_o,
    output logic [IndexWidth-1:0] index_o,
    output logic [9*W-1:0] triangle_o,
    output logic signed [W-1:0] box_o[2][3],
    output logic signed [W-1:0] group_o[2][3],

    output logic [SeenWidth-1:0] seen_o  // of the last clock
);

  localparam int unsigned ExtentLatency = 2;

  typedef logic signed [W-1:0] coord_t;
  typedef logic [9*W-1:0] triangle_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;
  typedef logic [1:0][2:0][W-1:0] box_t;
  typedef struct packed {
    count_t count;
    logic overfull;
    logic [ExtentLatency:0] valid;
    index_t index;
    triangle_t triangle;
    box_t box;
    box_t group;
    box_t object;
  } seen_t;

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

  triangle_t triangle_q;
  index_t index_q;
  logic [ExtentLatency:0] valid_q;

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
        .low_o(box_o[0][k]),
        .high_o(box_o[1][k])
    );
  end

  triaxis_delay #(
      .T(triangle_t),
      .Cycles(ExtentLatency)
  ) u_triangle (
      .clk_i,
      .d_i(triangle_q),
      .q_o(triangle_o)
  );
  triaxis_delay #(
      .T(index_t),
      .Cycles(ExtentLatency)
  ) u_index (
      .clk_i,
      .d_i(index_q),
      .q_o(index_o)
  );

  // --- The boxes of its group and of the mesh -----------------------------------------------------------

  logic first_in_group, first_in_mesh;
  coord_t object_d[2][3], group_q[2][3];
  assign write_o = valid_q[ExtentLatency];
  assign first_in_mesh = index_o == '0;
  assign first_in_group = (index_o & index_t'(Group - 1)) == '0;

  for (genvar k = 0; k < 3; k++) begin : g_union
    always_comb begin
      group_o[0][k]  = box_o[0][k];
      group_o[1][k]  = box_o[1][k];
      object_d[0][k] = box_o[0][k];
      object_d[1][k] = box_o[1][k];
      if (!first_in_group && group_q[0][k] < box_o[0][k]) group_o[0][k] = group_q[0][k];
      if (!first_in_group && group_q[1][k] > box_o[1][k]) group_o[1][k] = group_q[1][k];
      if (!first_in_mesh && object_o[0][k] < box_o[0][k]) object_d[0][k] = object_o[0][k];
      if (!first_in_mesh && object_o[1][k] > box_o[1][k]) object_d[1][k] = object_o[1][k];
    end
  end

  always_ff @(posedge clk_i) begin
    if (write_o) begin
      group_q  <= group_o;
      object_o <= object_d;
    end
  end

  // --- What two intakes of the same triangles must have alike ---------------------------------------------

  // Each at the clocks at which something rests on it: 0 at others, for which a register needs no logic.
  logic known, used;
  seen_t seen;
  assign known = settled_o && count_q != '0;
  assign used  = write_o && !first_in_group;
  always_comb begin
    seen.count = count_q;
    seen.overfull = overfull_o;
    seen.valid = valid_q;
    seen.index = write_o ? index_o : '0;
    seen.triangle = write_o ? triangle_o : '0;
    for (int c = 0; c < 2; c++) begin
      for (int k = 0; k < 3; k++) begin
        seen.box[c][k] = write_o ? box_o[c][k] : '0;
        seen.group[c][k] = used ? group_q[c][k] : '0;
        seen.object[c][k] = known || (write_o && !first_in_mesh) ? object_o[c][k] : '0;
      end
    end
  end
  always_ff @(posedge clk_i) seen_o <= seen;

endmodule
