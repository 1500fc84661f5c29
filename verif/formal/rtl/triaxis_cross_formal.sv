// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A cross product and a triple product of differences of four free vertices, multipliers included,
// against the determinants that they are by definition.

module triaxis_cross_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 2
) (
    input logic signed [W-1:0] vertex_i[4][3]
);

  localparam int unsigned Wide = 3 * W + 4;
  typedef logic signed [Wide-1:0] wide_t;
  typedef logic signed [diff_width(W)-1:0] diff_t;

  diff_t u[3], v[3], t[3];
  logic signed [cross_width(W)-1:0] cross_o[3];
  logic signed [  det_width(W)-1:0] dot_o;

  for (genvar k = 0; k < 3; k++) begin : g_difference
    assign u[k] = diff_t'(vertex_i[1][k]) - diff_t'(vertex_i[0][k]);
    assign v[k] = diff_t'(vertex_i[2][k]) - diff_t'(vertex_i[0][k]);
    assign t[k] = diff_t'(vertex_i[3][k]) - diff_t'(vertex_i[0][k]);
  end

  triaxis_cross #(
      .W(W),
      .Comb(1'b1)
  ) u_cross (
      .clk_i(1'b0),
      .a_i  (u),
      .b_i  (v),
      .cross_o
  );

  triaxis_dot #(
      .W(W),
      .Comb(1'b1)
  ) u_dot (
      .clk_i  (1'b0),
      .cross_i(cross_o),
      .diff_i (t),
      .dot_o
  );

  wide_t minors[3], volume;
  logic same;
  always_comb begin
    volume = '0;
    same   = 1'b1;
    for (int k = 0; k < 3; k++) begin
      minors[k] = wide_t'(u[(k+1)%3]) * wide_t'(v[(k+2)%3]) -
          wide_t'(u[(k+2)%3]) * wide_t'(v[(k+1)%3]);
      volume += minors[k] * wide_t'(t[k]);
      same &= wide_t'(cross_o[k]) == minors[k];
    end
    CrossProduct : assert (same);
    TripleProduct : assert (wide_t'(dot_o) == volume);
    SeenLargest : cover (volume == 2 * wide_t'((2 ** W - 1) * (2 ** W - 1) * (2 ** W - 1)));
  end

endmodule
