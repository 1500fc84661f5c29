// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether the claimed axis separates a pair by more than its margin: the axis as one cross product,
// whatever its number, five projections on it, one comparison. What holds is a certificate: no vertex of A
// and none of B, and so no point of theirs, come within the margin. It looks for nothing: of a pair that is
// near, nothing that it can be given holds.
// Widths: differences of vertices W+1 bits, axes 2W+2, projections of differences 3W+3, all signed: see
// triaxis_pkg. Products of a component are at most 2 L^2 * L and fit on the way as well.
// Latency: certifier_latency(W).

`include "triaxis_stage.svh"

module triaxis_certifier
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][3],  // [vertex][coordinate]
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    input axis_t axis_i,
    output logic holds_o
);

  localparam int unsigned AxisLatency = mul_latency(diff_width(W), diff_width(W)) + 1;
  localparam int unsigned Stage = Comb ? 0 : 1;
  typedef logic signed [diff_width(W)-1:0] diff_t;
  typedef logic signed [axis_width(W)-1:0] axis_comp_t;
  typedef logic signed [span_width(W)-1:0] span_t;
  typedef logic [margin_width(M)-1:0] margin_t;
  typedef logic [3:0] select_t;

  // What axes are products of, by number: edges of A, of B, unit vectors.
  localparam select_t EdgeA = 1;
  localparam select_t EdgeB = 4;
  localparam select_t Unit = 7;

  // --- The two vectors of the axis, and the vertices from the first of A ---------------------------

  diff_t edges_a_d[3][3], edges_b_d[3][3], points_d[5][3];
  diff_t edges_a_q[3][3], edges_b_q[3][3], points_q[5][3];
  for (genvar k = 0; k < 3; k++) begin : g_component
    for (genvar i = 0; i < 3; i++) begin : g_vector
      assign edges_a_d[i][k] = a_i[(i+1)%3][k] - a_i[i][k];
      assign edges_b_d[i][k] = b_i[(i+1)%3][k] - b_i[i][k];
    end
    assign points_d[0][k] = a_i[1][k] - a_i[0][k];
    assign points_d[1][k] = a_i[2][k] - a_i[0][k];
    assign points_d[2][k] = b_i[0][k] - a_i[0][k];
    assign points_d[3][k] = b_i[1][k] - a_i[0][k];
    assign points_d[4][k] = b_i[2][k] - a_i[0][k];
  end
  `TRIAXIS_STAGE(edges_a_q, edges_a_d)
  `TRIAXIS_STAGE(edges_b_q, edges_b_d)
  `TRIAXIS_STAGE(points_q, points_d)

  // By number, each known at elaboration: so a choice is a table, and no arithmetic on the claim.
  select_t firsts[2**$bits(axis_t)], seconds[2**$bits(axis_t)];
  for (genvar i = 0; i < 2 ** $bits(axis_t); i++) begin : g_choice
    select_t offset, row, column;
    always_comb begin
      if (i >= AxisEdgeBoxB) offset = select_t'(i - AxisEdgeBoxB);
      else if (i >= AxisEdgeBoxA) offset = select_t'(i - AxisEdgeBoxA);
      else offset = select_t'(i - AxisEdgeEdge);
      row = offset / 3;
      column = offset % 3;
      if (i >= AxisEdgeBoxB) begin
        firsts[i]  = EdgeB + row;
        seconds[i] = Unit + column;
      end else if (i >= AxisEdgeBoxA) begin
        firsts[i]  = EdgeA + row;
        seconds[i] = Unit + column;
      end else if (i >= AxisEdgeEdge) begin
        firsts[i]  = EdgeA + row;
        seconds[i] = EdgeB + column;
      end else if (i == AxisNormalB) begin
        firsts[i]  = EdgeB;
        seconds[i] = EdgeB + 1;
      end else if (i == AxisNormalA) begin
        firsts[i]  = EdgeA;
        seconds[i] = EdgeA + 1;
      end else begin
        // A coordinate's own axis is the product of the other two, up to its sign.
        firsts[i]  = (i == AxisBox) ? Unit + 1 : Unit;
        seconds[i] = (i == AxisNormalA - 1) ? Unit + 1 : Unit + 2;
      end
    end
  end

  select_t first_d, first_q, second_d, second_q;
  assign first_d  = firsts[axis_i];
  assign second_d = seconds[axis_i];
  `TRIAXIS_STAGE(first_q, first_d)
  `TRIAXIS_STAGE(second_q, second_d)

  diff_t u_d[3], u_q[3], v_d[3], v_q[3];
  for (genvar k = 0; k < 3; k++) begin : g_selected
    diff_t vectors[EdgeA:Unit-1];
    for (genvar i = 0; i < 3; i++) begin : g_vector
      assign vectors[EdgeA+i] = edges_a_q[i][k];
      assign vectors[EdgeB+i] = edges_b_q[i][k];
    end
    assign u_d[k] = (first_q < Unit) ? vectors[first_q] : diff_t'(first_q == Unit + select_t'(k));
    assign v_d[k] = (second_q < Unit) ? vectors[second_q] :
        diff_t'(second_q == Unit + select_t'(k));
  end
  `TRIAXIS_STAGE(u_q, u_d)
  `TRIAXIS_STAGE(v_q, v_d)

  // --- The axis, and the projections on it -----------------------------------------------------------

  axis_comp_t axis_d[3], axis_q[3];
  for (genvar k = 0; k < 3; k++) begin : g_axis
    axis_comp_t plus, minus;
    triaxis_mul #(
        .AWidth(diff_width(W)),
        .BWidth(diff_width(W)),
        .Comb  (Comb)
    ) u_plus (
        .clk_i,
        .a_i(u_q[(k+1)%3]),
        .b_i(v_q[(k+2)%3]),
        .product_o(plus)
    );
    triaxis_mul #(
        .AWidth(diff_width(W)),
        .BWidth(diff_width(W)),
        .Comb  (Comb)
    ) u_minus (
        .clk_i,
        .a_i(u_q[(k+2)%3]),
        .b_i(v_q[(k+1)%3]),
        .product_o(minus)
    );
    assign axis_d[k] = plus - minus;
  end
  `TRIAXIS_STAGE(axis_q, axis_d)

  span_t on_a[2], on_b[3];
  for (genvar i = 0; i < 5; i++) begin : g_projection
    span_t term[3], two_d, two_q, last_d, last_q, all_d, all_q;
    for (genvar k = 0; k < 3; k++) begin : g_term
      diff_t point;
      triaxis_delay #(
          .T(diff_t),
          .Cycles((1 + AxisLatency) * Stage)
      ) u_point (
          .clk_i,
          .d_i(points_q[i][k]),
          .q_o(point)
      );
      triaxis_mul #(
          .AWidth(axis_width(W)),
          .BWidth(diff_width(W)),
          .Comb  (Comb)
      ) u_mul (
          .clk_i,
          .a_i(axis_q[k]),
          .b_i(point),
          .product_o(term[k])
      );
    end
    assign two_d  = term[0] + term[1];
    assign last_d = term[2];
    assign all_d  = two_q + last_q;
    `TRIAXIS_STAGE(two_q, two_d)
    `TRIAXIS_STAGE(last_q, last_d)
    `TRIAXIS_STAGE(all_q, all_d)
    if (i < 2) begin : g_a
      assign on_a[i] = all_q;
    end else begin : g_b
      assign on_b[i-2] = all_q;
    end
  end

  // --- Their distance ----------------------------------------------------------------------------------

  logic [axis_threshold_width(W, M)-1:0] reach;
  if (M == 0) begin : g_no_margin
    logic unused_margin;
    assign unused_margin = ^margin_i;
    assign reach = '0;
  end else begin : g_margin
    typedef logic [axis_width(W)+M-1:0] reach_t;
    margin_t margin;
    reach_t  early;
    triaxis_delay #(
        .T(margin_t),
        .Cycles((2 + AxisLatency) * Stage)
    ) u_margin (
        .clk_i,
        .d_i(margin_i),
        .q_o(margin)
    );
    triaxis_reach #(
        .W(W),
        .M(M),
        .Comb(Comb)
    ) u_reach (
        .clk_i,
        .axis_i  (axis_q),
        .margin_i(margin),
        .reach_o (early)
    );
    triaxis_delay #(
        .T(reach_t),
        .Cycles((inner_latency(W) + ApartLatency - 1 - reach_latency(W, M)) * Stage)
    ) u_wait (
        .clk_i,
        .d_i(early),
        .q_o(reach)
    );
  end

  triaxis_apart #(
      .W(W),
      .M(M),
      .Comb(Comb)
  ) u_apart (
      .clk_i,
      .a_i(on_a),
      .b_i(on_b),
      .reach_i(reach),
      .apart_o(holds_o)
  );

endmodule
