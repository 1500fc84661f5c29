// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: for each of the twenty triangles with corners among the six vertices, the product of
// twice its area, seen along z, with the sum of its corners' heights: six times the volume of the
// prism under it. Those of the four faces of a tetrahedron add up to six times its volume
// (docs/theory.md, section 4).
//   a_o, b_o   A and B
//   aab_o[i][j]  edge i of A with vertex j of B
//   abb_o[i][j]  vertex i of A with edge j of B
// Widths: areas 2W+1 bits; the sum of two coordinates W+1 bits; that of three lies in -3 2^(W-1) ..
// 3 2^(W-1) - 3: W+2 bits signed; so 3W+3 bits.
// Latency: prism_latency(W) after the areas. Heights come with the operands, area_latency(W) before.

`include "triaxis_stage.svh"

module triaxis_prisms
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_heights_i[3],
    input logic signed [W-1:0] b_heights_i[3],
    input logic signed [cross_width(W)-1:0] normal_a_i,
    input logic signed [cross_width(W)-1:0] normal_b_i,
    input logic signed [cross_width(W)-1:0] a_points_i[3][3],
    input logic signed [cross_width(W)-1:0] b_points_i[3][3],
    output logic signed [span_width(W)-1:0] a_o,
    output logic signed [span_width(W)-1:0] b_o,
    output logic signed [span_width(W)-1:0] aab_o[3][3],
    output logic signed [span_width(W)-1:0] abb_o[3][3]
);

  localparam int unsigned Wait = Comb ? 0 : area_latency(W) - 1;
  localparam int unsigned PairWait = Comb ? 0 : Wait - 1;
  typedef logic signed [W-1:0] heights_t[3];
  typedef logic signed [W:0] pairs_t[3];
  typedef logic signed [height_width(W)-1:0] height_t;

  heights_t a, b;
  // The sums of two, along each edge, before the wait: three at a time would be the longest way of the core.
  pairs_t a_pair_d, a_pair_q, a_pair, b_pair_d, b_pair_q, b_pair;
  height_t a_d, a_q, b_d, b_q, aab_d[3][3], aab_q[3][3], abb_d[3][3], abb_q[3][3];

  triaxis_delay #(
      .T(heights_t),
      .Cycles(Wait)
  ) u_a_heights (
      .clk_i,
      .d_i(a_heights_i),
      .q_o(a)
  );
  triaxis_delay #(
      .T(heights_t),
      .Cycles(Wait)
  ) u_b_heights (
      .clk_i,
      .d_i(b_heights_i),
      .q_o(b)
  );

  for (genvar i = 0; i < 3; i++) begin : g_pair
    assign a_pair_d[i] = (W + 1)'(a_heights_i[i]) + (W + 1)'(a_heights_i[(i+1)%3]);
    assign b_pair_d[i] = (W + 1)'(b_heights_i[i]) + (W + 1)'(b_heights_i[(i+1)%3]);
  end
  `TRIAXIS_STAGE(a_pair_q, a_pair_d)
  `TRIAXIS_STAGE(b_pair_q, b_pair_d)

  triaxis_delay #(
      .T(pairs_t),
      .Cycles(PairWait)
  ) u_a_pairs (
      .clk_i,
      .d_i(a_pair_q),
      .q_o(a_pair)
  );
  triaxis_delay #(
      .T(pairs_t),
      .Cycles(PairWait)
  ) u_b_pairs (
      .clk_i,
      .d_i(b_pair_q),
      .q_o(b_pair)
  );

  assign a_d = height_t'(a_pair[0]) + height_t'(a[2]);
  assign b_d = height_t'(b_pair[0]) + height_t'(b[2]);
  `TRIAXIS_STAGE(a_q, a_d)
  `TRIAXIS_STAGE(b_q, b_d)
  `TRIAXIS_STAGE(aab_q, aab_d)
  `TRIAXIS_STAGE(abb_q, abb_d)

  triaxis_mul #(
      .AWidth(cross_width(W)),
      .BWidth(height_width(W)),
      .Comb  (Comb)
  ) u_a (
      .clk_i,
      .a_i(normal_a_i),
      .b_i(a_q),
      .product_o(a_o)
  );
  triaxis_mul #(
      .AWidth(cross_width(W)),
      .BWidth(height_width(W)),
      .Comb  (Comb)
  ) u_b (
      .clk_i,
      .a_i(normal_b_i),
      .b_i(b_q),
      .product_o(b_o)
  );

  for (genvar i = 0; i < 3; i++) begin : g_vertex_a
    for (genvar j = 0; j < 3; j++) begin : g_vertex_b
      assign aab_d[i][j] = height_t'(a_pair[i]) + height_t'(b[j]);
      assign abb_d[i][j] = height_t'(a[i]) + height_t'(b_pair[j]);
      triaxis_mul #(
          .AWidth(cross_width(W)),
          .BWidth(height_width(W)),
          .Comb  (Comb)
      ) u_aab (
          .clk_i,
          .a_i(a_points_i[i][j]),
          .b_i(aab_q[i][j]),
          .product_o(aab_o[i][j])
      );
      triaxis_mul #(
          .AWidth(cross_width(W)),
          .BWidth(height_width(W)),
          .Comb  (Comb)
      ) u_abb (
          .clk_i,
          .a_i(b_points_i[j][i]),
          .b_i(abb_q[i][j]),
          .product_o(abb_o[i][j])
      );
    end
  end

endmodule
