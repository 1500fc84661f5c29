// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: near(A, B, m), the claimed axis and the flags of one pair per clock: box axes first,
// then, for pairs that their boxes leave undecided, cross products, ten triple products and the
// tests of the other 29 axes.
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
  localparam int unsigned TimeAxis = DiffLatency + cross_latency(W) + AxisLatency;
  localparam int unsigned TimeDet = DiffLatency + cross_latency(W) + dot_latency(W);
  localparam int unsigned TimePlane = TimeAxis + interval_latency(M);
  localparam int unsigned TimeDecision = decision_latency(W, M);

  typedef logic signed [W-1:0] coord_t;
  typedef logic signed [cross_width(W)-1:0] cross_vector_t[3];
  typedef logic signed [det_width(W)-1:0] det_t;
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

  // --- Cross products, triple products, normals -----------------------------------------------

  cross_vector_t normal_a_early, normal_a, normal_b, f[3], pr[3], rq[3];
  det_t pqr[3], pf[3], qf[3], rst;

  triaxis_products #(
      .W(W),
      .EdgeBox(EdgeBox),
      .Comb(Comb)
  ) u_products (
      .clk_i,
      .a_i(operand_a),
      .b_i(operand_b),
      .normal_a_o(normal_a_early),
      .f_o(f),
      .pr_o(pr),
      .rq_o(rq),
      .pqr_o(pqr),
      .pf_o(pf),
      .qf_o(qf),
      .rst_o(rst)
  );

  triaxis_delay #(
      .T(cross_vector_t),
      .Cycles(AxisLatency * Stage)
  ) u_normal_a (
      .clk_i,
      .d_i(normal_a_early),
      .q_o(normal_a)
  );

  // N_B is the sum of the f_j.
  for (genvar k = 0; k < 3; k++) begin : g_normal_b
    logic signed [cross_width(W)-1:0] terms[3];
    assign terms[0] = f[0][k];
    assign terms[1] = f[1][k];
    assign terms[2] = f[2][k];
    triaxis_sum #(
        .Terms(3),
        .Width(cross_width(W)),
        .Comb (Comb)
    ) u_normal_b (
        .clk_i,
        .terms_i(terms),
        .sum_o  (normal_b[k])
    );
  end

  // --- The axes, and the margins that they need -------------------------------------------------

  logic [NumAxes-1:0] separated;
  logic signed [axis_width(W)-1:0] edge_edge[3][3][3];
  logic [axis_threshold_width(W, M)-1:0] space_threshold[AxisNormalA:AxisEdgeBoxA-1];
  logic [edge_threshold_width(W, M)-1:0] plane_threshold[AxisEdgeBoxA:NumAxes-1];

  assign separated[AxisBox+:3] = box_decision;

  triaxis_space_axes #(
      .W(W),
      .M(M),
      .Comb(Comb)
  ) u_space_axes (
      .clk_i,
      .pqr_i(pqr),
      .pf_i(pf),
      .qf_i(qf),
      .rst_i(rst),
      .threshold_i(space_threshold),
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
        .normal_a_early_i(normal_a_early),
        .pr_i(pr),
        .rq_i(rq),
        .f_i(f),
        .normal_a_i(normal_a),
        .normal_b_i(normal_b),
        .threshold_i(plane_threshold),
        .edge_edge_o(edge_edge),
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
    logic unused[3];
    for (genvar k = 0; k < 3; k++) begin : g_unused
      assign unused[k] = ^{pr[k][0], pr[k][1], pr[k][2], rq[k][0], rq[k][1], rq[k][2]};
    end
    logic unused_threshold;
    assign unused_threshold = ^plane_threshold[AxisEdgeBoxA];
    assign edge_edge = '{default: '0};
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
      .NormalWait((TimeDecision - TimeAxis) * Stage),
      .DetWait((TimeDecision - TimeDet) * Stage)
  ) u_flags (
      .clk_i,
      .normal_a_i(normal_a),
      .normal_b_i(normal_b),
      .pqr_i(pqr),
      .pf_i(pf),
      .qf_i(qf),
      .rst_i(rst),
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
