// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: near(A, B, m), the claimed axis and the flags of one pair per clock: box axes first,
// then, for pairs that their boxes leave undecided, the areas of triangles seen along each coordinate
// axis, the prisms under them, and the tests of the other 29 axes.
// Widths: see triaxis_pkg.
// Latency: datapath_latency(W, M); 0 with Comb = 1, which turns every register into a wire.

`include "triaxis_stage.svh"

module triaxis_datapath
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic valid_i,
    input logic signed [W-1:0] a_i[3][3],  // [vertex][coordinate]
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    output verdict_t verdict_o
);

  localparam int unsigned Stage = Comb ? 0 : 1;
  // Clocks after the operand register.
  localparam int unsigned TimeArea = area_latency(W);
  localparam int unsigned TimeFlat = TimeArea + prism_latency(W) + FlatLatency;
  localparam int unsigned TimePlane = TimeArea + interval_latency(M);
  localparam int unsigned TimeDecision = decision_latency(W, M);

  typedef logic signed [W-1:0] coord_t;
  typedef logic signed [cross_width(W)-1:0] cross_t;
  typedef logic signed [span_width(W)-1:0] span_t;
  typedef logic [margin_width(M)-1:0] margin_t;
  typedef logic [2:0] box_t;
  typedef logic [NumAxes-1:AxisEdgeBoxA] plane_bits_t;

  if (W < 8 || W > 32) begin : g_bad_w
    $fatal(1, "W must be 8..32");
  end
  if (M > W) begin : g_bad_m
    $fatal(1, "M must be at most W: no two points are further apart than 2^W - 1");
  end
  if (!EdgeBox && M != 0) begin : g_bad_edge_box
    $fatal(1, "EdgeBox = 0 needs M = 0: margins are only exact with the edge x box axes");
  end

  // --- Input register, box axes, operands -----------------------------------------------------

  logic valid_q;
  coord_t a_q[3][3], b_q[3][3], operand_a[3][3], operand_b[3][3];
  margin_t margin_q, operand_margin;
  box_t box_separated, box_decision;

  `TRIAXIS_STAGE(valid_q, valid_i)
  `TRIAXIS_STAGE(a_q, a_i)
  `TRIAXIS_STAGE(b_q, b_i)
  `TRIAXIS_STAGE(margin_q, margin_i)

  triaxis_boxes #(
      .W(W),
      .M(M),
      .Gating(Gating),
      .Comb(Comb)
  ) u_boxes (
      .clk_i,
      .valid_i(valid_q),
      .a_i(a_q),
      .b_i(b_q),
      .margin_i(margin_q),
      .separated_o(box_separated),
      .operand_a_o(operand_a),
      .operand_b_o(operand_b),
      .operand_margin_o(operand_margin)
  );

  triaxis_delay #(
      .T(box_t),
      .Cycles(TimeDecision * Stage)
  ) u_box_decision (
      .clk_i,
      .d_i(box_separated),
      .q_o(box_decision)
  );

  // --- Areas along each coordinate axis, prisms along z --------------------------------------------

  cross_t normal_a[3], normal_b[3], a_points[3][3][3], b_points[3][3][3];
  logic signed [axis_width(W)-1:0] edge_edge[3][3][3];
  span_t prism_a, prism_b, prism_aab[3][3], prism_abb[3][3];
  coord_t heights_a[3], heights_b[3];

  for (genvar k = 0; k < 3; k++) begin : g_along
    coord_t a[3][2], b[3][2];
    logic signed [axis_width(W)-1:0] edges[3][3];
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      assign a[v][0] = operand_a[v][(k+1)%3];
      assign a[v][1] = operand_a[v][(k+2)%3];
      assign b[v][0] = operand_b[v][(k+1)%3];
      assign b[v][1] = operand_b[v][(k+2)%3];
      for (genvar j = 0; j < 3; j++) begin : g_edge
        assign edge_edge[v][j][k] = edges[v][j];
      end
    end
    triaxis_areas #(
        .W(W),
        .Between(EdgeBox || k == 2),
        .Comb(Comb)
    ) u_areas (
        .clk_i,
        .a_i(a),
        .b_i(b),
        .normal_a_o(normal_a[k]),
        .normal_b_o(normal_b[k]),
        .a_points_o(a_points[k]),
        .b_points_o(b_points[k]),
        .edge_edge_o(edges)
    );
    assign heights_a[k] = operand_a[k][2];
    assign heights_b[k] = operand_b[k][2];
  end

  triaxis_prisms #(
      .W(W),
      .Comb(Comb)
  ) u_prisms (
      .clk_i,
      .a_heights_i(heights_a),
      .b_heights_i(heights_b),
      .normal_a_i(normal_a[2]),
      .normal_b_i(normal_b[2]),
      .a_points_i(a_points[2]),
      .b_points_i(b_points[2]),
      .a_o(prism_a),
      .b_o(prism_b),
      .aab_o(prism_aab),
      .abb_o(prism_abb)
  );

  // --- The axes, and the margins that they need -------------------------------------------------

  logic [NumAxes-1:0] separated;
  logic [axis_threshold_width(W, M)-1:0] space_threshold[AxisNormalA:AxisEdgeBoxA-1];
  logic [edge_threshold_width(W, M)-1:0] plane_threshold[AxisEdgeBoxA:NumAxes-1];
  span_t flat_a[3], flat_b[3], flat_edges[3][3];

  assign separated[AxisBox+:3] = box_decision;

  triaxis_space_axes #(
      .W(W),
      .M(M),
      .Comb(Comb)
  ) u_space_axes (
      .clk_i,
      .a_i(prism_a),
      .b_i(prism_b),
      .aab_i(prism_aab),
      .abb_i(prism_abb),
      .threshold_i(space_threshold),
      .flat_a_o(flat_a),
      .flat_b_o(flat_b),
      .flat_edges_o(flat_edges),
      .separated_o(separated[AxisEdgeBoxA-1:AxisNormalA])
  );

  if (EdgeBox) begin : g_edge_box
    plane_bits_t plane_separated;

    triaxis_plane_axes #(
        .W(W),
        .M(M),
        .Comb(Comb)
    ) u_plane_axes (
        .clk_i,
        .normal_a_i (normal_a),
        .normal_b_i (normal_b),
        .a_points_i (a_points),
        .b_points_i (b_points),
        .threshold_i(plane_threshold),
        .separated_o(plane_separated)
    );

    triaxis_delay #(
        .T(plane_bits_t),
        .Cycles((TimeDecision - TimePlane) * Stage)
    ) u_plane_separated (
        .clk_i,
        .d_i(plane_separated),
        .q_o(separated[NumAxes-1:AxisEdgeBoxA])
    );
  end else begin : g_no_edge_box
    logic unused_threshold;
    assign unused_threshold = ^plane_threshold[AxisEdgeBoxA];
    assign separated[NumAxes-1:AxisEdgeBoxA] = '0;
  end

  triaxis_thresholds #(
      .W(W),
      .M(M),
      .Comb(Comb)
  ) u_thresholds (
      .clk_i,
      .a_i(operand_a),
      .b_i(operand_b),
      .margin_i(operand_margin),
      .normal_a_i(normal_a),
      .normal_b_i(normal_b),
      .edge_edge_i(edge_edge),
      .space_o(space_threshold),
      .plane_o(plane_threshold)
  );

  // --- Flags and verdict --------------------------------------------------------------------------

  logic degenerate_a, degenerate_b, coplanar;

  triaxis_flags #(
      .W(W),
      .NormalWait((TimeDecision - TimeArea) * Stage),
      .DetWait((TimeDecision - TimeFlat) * Stage)
  ) u_flags (
      .clk_i,
      .normal_a_i(normal_a),
      .normal_b_i(normal_b),
      .flat_a_i(flat_a),
      .flat_b_i(flat_b),
      .flat_edges_i(flat_edges),
      .degenerate_a_o(degenerate_a),
      .degenerate_b_o(degenerate_b),
      .coplanar_o(coplanar)
  );

  triaxis_verdict #(
      .Comb(Comb)
  ) u_verdict (
      .clk_i,
      .separated_i(separated),
      .gated_i(Gating && !Comb && box_decision != '0),
      .coplanar_i(coplanar),
      .degenerate_a_i(degenerate_a),
      .degenerate_b_i(degenerate_b),
      .verdict_o(verdict_o)
  );

endmodule
