// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Skipping, from what a run asks for to the comparison of boxes, registers included, against its
// definition: a box of A, moved, is skipped exactly where one axis separates it from the box of B by
// more than the widest margin; boxes around these are skipped only where these are; A moved is refused
// exactly where it leaves the range. For all boxes, translations and margins.
//
// Each sum and each comparison by itself is that of whole numbers, so that no width cuts anything:
// what they come to together follows. Whole = 1 shows that too, for few bits.

`include "triaxis_formal.svh"

module triaxis_overlap_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter bit Whole = 1'b0
) (
    input logic clk_i,
    input logic rst_ni,
    input logic signed [6*W-1:0] a_i,
    input logic signed [6*W-1:0] b_i,
    input logic signed [6*W-1:0] around_a_i,
    input logic signed [6*W-1:0] around_b_i,
    input logic signed [6*W-1:0] object_i,
    input logic empty_a_i,
    input logic [3*move_width(W)-1:0] asked_i,
    input logic [Zones-1:0][M-1:0] margins_i
);

  typedef logic signed [W-1:0] coord_t;
  typedef logic signed [W+3:0] wide_t;
  typedef logic signed [move_width(W)-1:0] move_t;
  typedef logic signed [grown_width(W)-1:0] grown_t;

  localparam wide_t Limit = wide_t'(1) <<< (W - 1);

  // Corners of the boxes; A's two, B's two: the triangle's, and the group's around it.
  coord_t a[2][2][3], boxes[2][2][3], object[2][3];
  move_t asked[3], move[3];
  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign a[0][c][k] = a_i[(3*c+k)*W+:W];
      assign a[1][c][k] = around_a_i[(3*c+k)*W+:W];
      assign boxes[0][c][k] = b_i[(3*c+k)*W+:W];
      assign boxes[1][c][k] = around_b_i[(3*c+k)*W+:W];
      assign object[c][k] = object_i[(3*c+k)*W+:W];
    end
  end
  for (genvar k = 0; k < 3; k++) begin : g_asked
    assign asked[k] = asked_i[k*move_width(W)+:move_width(W)];
  end

  grown_t shift[2][3], grown[2][2][3];
  logic [Zones-1:0][M-1:0] margins;
  logic [M-1:0] margin;
  assign margin = margins[ZoneWarn];
  logic [1:0] overlap[2];

  // Nothing is accepted in the clocks that are looked at: what was asked for stays, and is free.
  triaxis_run_control #(
      .W(W),
      .MarginWidth(M),
      .CycleBits(2)
  ) u_control (
      .clk_i,
      .rst_ni,
      .s_axis_run_tvalid_i(1'b0),
      .s_axis_run_tready_o(),
      .move_i(asked),
      .margins_i,
      .mode_i('0),
      .abort_i(1'b0),
      .busy_o(),
      .settled_i(1'b0),
      .overfull_i(1'b0),
      .empty_a_i,
      .empty_i(1'b0),
      .object_a_i(object),
      .move_o(move),
      .shift_o(shift),
      .margins_o(margins),
      .mode_o(),
      .clear_o(),
      .start_o(),
      .drain_o(),
      .idle_i(1'b0),
      .first_i(1'b0),
      .m_axis_done_tvalid_o(),
      .m_axis_done_tready_i(1'b0),
      .status_o(),
      .cycles_o()
  );

  for (genvar g = 0; g < 2; g++) begin : g_grown
    triaxis_grow #(
        .W(W)
    ) u_grow (
        .clk_i,
        .enable_i(1'b1),
        .box_i(a[g]),
        .shift_i(shift),
        .grown_o(grown[g])
    );
    triaxis_overlap #(
        .W(W),
        .Lanes(2)
    ) u_overlap (
        .grown_i  (grown[g]),
        .boxes_i  (boxes),
        .overlap_o(overlap[g])
    );
  end

  `TRIAXIS_FULL_AFTER(3)

  // The boxes of A and what was asked for, a clock ago.
  coord_t a_q[2][2][3], object_q[2][3];
  move_t move_q[3];
  grown_t shift_q[2][3];
  logic [M-1:0] margin_q;
  logic empty_q;
  always_ff @(posedge clk_i) begin
    a_q <= a;
    object_q <= object;
    move_q <= move;
    margin_q <= margin;
    shift_q <= shift;
    empty_q <= empty_a_i;
  end

  wide_t moved_low, moved_high, wide_margin;
  logic [2:0] apart, beyond;
  logic around, grown_around, in_range, sums_exact;
  logic [2:0] grown_apart;
  always_comb begin
    wide_margin = wide_t'({4'b0, margin});
    apart = '0;
    beyond = '0;
    around = 1'b1;
    grown_around = 1'b1;
    sums_exact = 1'b1;
    grown_apart = '0;
    in_range = 1'b1;
    for (int k = 0; k < 3; k++) begin
      moved_low = wide_t'(a_q[0][0][k]) + wide_t'(move[k]);
      moved_high = wide_t'(a_q[0][1][k]) + wide_t'(move[k]);
      apart[k] = wide_t'(boxes[0][0][k]) - moved_high > wide_margin ||
          moved_low - wide_t'(boxes[0][1][k]) > wide_margin;
      for (int c = 0; c < 2; c++) begin
        for (int g = 0; g < 2; g++) begin
          in_range &= wide_t'(a_q[g][c][k]) + wide_t'(move[k]) >= -Limit &&
              wide_t'(a_q[g][c][k]) + wide_t'(move[k]) < Limit;
        end
        beyond[k] |= wide_t'(object_q[c][k]) + wide_t'(move[k]) < -Limit ||
            wide_t'(object_q[c][k]) + wide_t'(move[k]) >= Limit;
      end
      sums_exact &= wide_t'(shift[0][k]) == wide_t'(move_q[k]) - wide_t'({4'b0, margin_q}) &&
          wide_t'(shift[1][k]) == wide_t'(move_q[k]) + wide_t'({4'b0, margin_q});
      for (int c = 0; c < 2; c++) begin
        sums_exact &= !in_range ||
            wide_t'(grown[0][c][k]) == wide_t'(a_q[0][c][k]) + wide_t'(shift_q[c][k]);
      end
      grown_apart[k] = wide_t'(boxes[0][0][k]) > wide_t'(grown[0][1][k]) ||
          wide_t'(boxes[0][1][k]) < wide_t'(grown[0][0][k]);
      around &= a_q[1][0][k] <= a_q[0][0][k] && a_q[0][1][k] <= a_q[1][1][k] &&
          boxes[1][0][k] <= boxes[0][0][k] && boxes[0][1][k] <= boxes[1][1][k];
      grown_around &= grown[1][0][k] <= grown[0][0][k] && grown[0][1][k] <= grown[1][1][k] &&
          boxes[1][0][k] <= boxes[0][0][k] && boxes[0][1][k] <= boxes[1][1][k];
    end
    Ordered :
    assume (object[0][0] <= object[1][0] && object[0][1] <= object[1][1] &&
            object[0][2] <= object[1][2]);
    if (full) begin
      SumsAreExact : assert (sums_exact);
      ComparisonIsExact : assert (overlap[0][0] == (grown_apart == '0));
      SkipIsExact : assert (!Whole || !in_range || overlap[0][0] == (apart == '0));
      GrownAround : assert (!Whole || !in_range || !around || grown_around);
      OverlapAround :
      assert (!grown_around || !overlap[0][0] || (overlap[1][1] && overlap[1][0] && overlap[0][1]));
      OverflowIsExact : assert (u_control.overflow_q == (!empty_q && beyond != '0));
      SeenApart : cover (in_range && around && !overlap[1][1] && wide_margin > 1);
      SeenOnlyTriangles : cover (in_range && around && overlap[1][1] && !overlap[0][0]);
      SeenBeyond : cover (u_control.overflow_q);
    end
  end

endmodule
