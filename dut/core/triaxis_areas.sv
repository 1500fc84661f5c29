// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes, seen along one coordinate axis, twice the signed areas of the triangles whose corners are
// vertices of A and B:
//   normal_a_o, normal_b_o  A and B themselves: a component of their normals
//   a_points_o[i][j]        edge i of A with vertex j of B
//   b_points_o[j][i]        edge j of B with vertex i of A
//   edge_edge_o[i][j]       (edge i of A) x (edge j of B), a component: a difference of two of these
// Each is made of three trapezoids, of which there are fifteen. Without Between there are the
// normals alone, and 0 for all else.
// Widths: a triangle lies inside a square of side L, so |.| <= L^2: 2W+1 bits signed; edge x edge
// 2W+2. Sums wrap on the way.
// Latency: area_latency(W): trapezoids, then two additions. A suffix _n marks the value after n of them.

`include "triaxis_stage.svh"

module triaxis_areas
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Between = 1'b1,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][2],  // [vertex][the other two coordinates]
    input logic signed [W-1:0] b_i[3][2],
    output logic signed [cross_width(W)-1:0] normal_a_o,
    output logic signed [cross_width(W)-1:0] normal_b_o,
    output logic signed [cross_width(W)-1:0] a_points_o[3][3],
    output logic signed [cross_width(W)-1:0] b_points_o[3][3],
    output logic signed [axis_width(W)-1:0] edge_edge_o[3][3]
);

  typedef logic signed [cross_width(W)-1:0] cross_t;
  typedef logic signed [axis_width(W)-1:0] area_t;

  // Trapezoids along the edges of A and of B.
  area_t a_0[3], a_1[3], b_0[3], b_1[3];
  area_t a_sum_d, a_sum_1, b_sum_d, b_sum_1;
  cross_t normal_a_d, normal_b_d;

  for (genvar i = 0; i < 3; i++) begin : g_edge
    triaxis_trapezoid #(
        .W(W),
        .Comb(Comb)
    ) u_a (
        .clk_i,
        .from_i(a_i[i]),
        .to_i  (a_i[(i+1)%3]),
        .area_o(a_0[i])
    );
    triaxis_trapezoid #(
        .W(W),
        .Comb(Comb)
    ) u_b (
        .clk_i,
        .from_i(b_i[i]),
        .to_i  (b_i[(i+1)%3]),
        .area_o(b_0[i])
    );
  end

  assign a_sum_d = a_0[0] + a_0[1];
  assign b_sum_d = b_0[0] + b_0[1];
  `TRIAXIS_STAGE(a_1, a_0)
  `TRIAXIS_STAGE(b_1, b_0)
  `TRIAXIS_STAGE(a_sum_1, a_sum_d)
  `TRIAXIS_STAGE(b_sum_1, b_sum_d)
  assign normal_a_d = cross_t'(a_sum_1 + a_1[2]);
  assign normal_b_d = cross_t'(b_sum_1 + b_1[2]);
  `TRIAXIS_STAGE(normal_a_o, normal_a_d)
  `TRIAXIS_STAGE(normal_b_o, normal_b_d)

  if (Between) begin : g_between
    area_t between[3][3];  // from vertex i of A to vertex j of B
    area_t across_a_d[3][3], across_a_1[3][3];  // both ends of edge i of A, and vertex j of B
    area_t across_b_d[3][3], across_b_1[3][3];  // vertex i of A, and both ends of edge j of B
    cross_t a_points_d[3][3], b_points_d[3][3];
    area_t edge_edge_d[3][3];

    for (genvar i = 0; i < 3; i++) begin : g_vertex_a
      for (genvar j = 0; j < 3; j++) begin : g_vertex_b
        triaxis_trapezoid #(
            .W(W),
            .Comb(Comb)
        ) u_between (
            .clk_i,
            .from_i(a_i[i]),
            .to_i  (b_i[j]),
            .area_o(between[i][j])
        );
        assign across_a_d[i][j]  = between[(i+1)%3][j] - between[i][j];
        assign across_b_d[i][j]  = between[i][j] - between[i][(j+1)%3];
        assign a_points_d[i][j]  = cross_t'(a_1[i] + across_a_1[i][j]);
        assign b_points_d[j][i]  = cross_t'(b_1[j] + across_b_1[i][j]);
        assign edge_edge_d[i][j] = across_a_1[i][(j+1)%3] - across_a_1[i][j];
      end
    end
    `TRIAXIS_STAGE(across_a_1, across_a_d)
    `TRIAXIS_STAGE(across_b_1, across_b_d)
    `TRIAXIS_STAGE(a_points_o, a_points_d)
    `TRIAXIS_STAGE(b_points_o, b_points_d)
    `TRIAXIS_STAGE(edge_edge_o, edge_edge_d)
  end else begin : g_normals_alone
    assign a_points_o  = '{default: '0};
    assign b_points_o  = '{default: '0};
    assign edge_edge_o = '{default: '0};
  end

endmodule
