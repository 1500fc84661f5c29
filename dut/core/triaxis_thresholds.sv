// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: margin * |axis|1 for the 29 axes other than the boxes, each when its interval test needs
// it, numbered as the axes are: space_o for the normals and edge x edge, plane_o for edge x box.
// Zeros, and no logic, where M = 0.
// Widths: at most 4 L^2 margin, 2W+2+M bits, and 2 L margin, W+1+M bits, unsigned.
// Latency: counted from the operand register: normals and edge x edge axes arrive at area_latency(W),
// when plane_o leaves; space_o leaves prism_latency(W) + ProjectionLatency after them.

module triaxis_thresholds
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    input logic [margin_width(M)-1:0] margin_i,
    input logic signed [cross_width(W)-1:0] normal_a_i[3],
    input logic signed [cross_width(W)-1:0] normal_b_i[3],
    input logic signed [axis_width(W)-1:0] edge_edge_i[3][3][3],
    output logic [axis_threshold_width(W, M)-1:0] space_o[AxisNormalA:AxisEdgeBoxA-1],
    output logic [edge_threshold_width(W, M)-1:0] plane_o[AxisEdgeBoxA:NumAxes-1]
);

  if (M == 0) begin : g_none
    logic unused_clk;
    logic unused_a[3][3], unused_b[3][3], unused_normal[3], unused_edge[3][3][3];
    assign unused_clk = clk_i ^ (^margin_i);
    for (genvar k = 0; k < 3; k++) begin : g_unused
      assign unused_normal[k] = ^{normal_a_i[k], normal_b_i[k]};
      for (genvar i = 0; i < 3; i++) begin : g_vertex
        assign unused_a[i][k] = ^a_i[i][k];
        assign unused_b[i][k] = ^b_i[i][k];
        for (genvar j = 0; j < 3; j++) begin : g_edge
          assign unused_edge[i][j][k] = ^edge_edge_i[i][j][k];
        end
      end
    end
    assign space_o = '{default: '0};
    assign plane_o = '{default: '0};
  end else begin : g_margin
    localparam int unsigned SpaceDue = prism_latency(W) + ProjectionLatency;
    localparam int unsigned SpaceWait = SpaceDue - threshold_latency(3, axis_width(W), M);
    localparam int unsigned PlaneDue = area_latency(W);
    localparam int unsigned PlaneWait = PlaneDue - 1 - threshold_latency(2, diff_width(W), M);
    typedef logic signed [axis_width(W)-1:0] axis_comp_t;
    typedef logic [M-1:0] margin_t;
    typedef logic [axis_threshold_width(W, M)-1:0] space_t[AxisNormalA:AxisEdgeBoxA-1];
    typedef logic [edge_threshold_width(W, M)-1:0] plane_t[AxisEdgeBoxA:NumAxes-1];

    axis_comp_t axes[AxisNormalA:AxisEdgeBoxA-1][3];
    margin_t axis_margin;
    space_t space;
    plane_t plane;

    for (genvar k = 0; k < 3; k++) begin : g_axes
      assign axes[AxisNormalA][k] = axis_comp_t'(normal_a_i[k]);
      assign axes[AxisNormalB][k] = axis_comp_t'(normal_b_i[k]);
      for (genvar i = 0; i < 3; i++) begin : g_edge_a
        for (genvar j = 0; j < 3; j++) begin : g_edge_b
          assign axes[AxisEdgeEdge+3*i+j][k] = edge_edge_i[i][j][k];
        end
      end
    end

    triaxis_delay #(
        .T(margin_t),
        .Cycles(Comb ? 0 : PlaneDue)
    ) u_axis_margin (
        .clk_i,
        .d_i(margin_i),
        .q_o(axis_margin)
    );

    for (genvar n = AxisNormalA; n < AxisEdgeBoxA; n++) begin : g_space
      triaxis_threshold #(
          .M(M),
          .Components(3),
          .CWidth(axis_width(W)),
          .Comb(Comb)
      ) u_threshold (
          .clk_i,
          .axis_i(axes[n]),
          .margin_i(axis_margin),
          .threshold_o(space[n])
      );
    end

    triaxis_edges #(
        .W(W),
        .M(M),
        .Comb(Comb)
    ) u_edges_a (
        .clk_i,
        .vertex_i(a_i),
        .margin_i,
        .threshold_o(plane[AxisEdgeBoxA:AxisEdgeBoxB-1])
    );
    triaxis_edges #(
        .W(W),
        .M(M),
        .Comb(Comb)
    ) u_edges_b (
        .clk_i,
        .vertex_i(b_i),
        .margin_i,
        .threshold_o(plane[AxisEdgeBoxB:NumAxes-1])
    );

    triaxis_delay #(
        .T(space_t),
        .Cycles(Comb ? 0 : SpaceWait)
    ) u_space_wait (
        .clk_i,
        .d_i(space),
        .q_o(space_o)
    );
    triaxis_delay #(
        .T(plane_t),
        .Cycles(Comb ? 0 : PlaneWait)
    ) u_plane_wait (
        .clk_i,
        .d_i(plane),
        .q_o(plane_o)
    );
  end

endmodule
