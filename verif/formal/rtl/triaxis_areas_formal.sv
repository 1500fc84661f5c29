// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// From six free vertices to areas, prisms and projections, multipliers included, against the
// determinants that they are by definition.

module triaxis_areas_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 1
) (
    input logic signed [W-1:0] vertex_i[6][3]  // those of A, then those of B
);

  localparam int unsigned Wide = 3 * W + 4;
  typedef logic signed [Wide-1:0] wide_t;
  typedef logic signed [W-1:0] coord_t;

  coord_t plane_a[3][2], plane_b[3][2], heights_a[3], heights_b[3];
  logic signed [cross_width(W)-1:0] normal_a, normal_b, a_points[3][3], b_points[3][3];
  logic signed [axis_width(W)-1:0] edge_edge[3][3];
  logic signed [span_width(W)-1:0] a, b, aab[3][3], abb[3][3];
  logic signed [span_width(W)-1:0] flat_a[3], flat_b[3], flat_edges[3][3];
  logic signed [span_width(W)-1:0] project_a[3], project_b[3], own[3], points[3][3][2];

  for (genvar v = 0; v < 3; v++) begin : g_vertex
    assign plane_a[v][0] = vertex_i[v][0];
    assign plane_a[v][1] = vertex_i[v][1];
    assign plane_b[v][0] = vertex_i[3+v][0];
    assign plane_b[v][1] = vertex_i[3+v][1];
    assign heights_a[v]  = vertex_i[v][2];
    assign heights_b[v]  = vertex_i[3+v][2];
  end

  triaxis_areas #(
      .W(W),
      .Comb(1'b1)
  ) u_areas (
      .clk_i(1'b0),
      .a_i(plane_a),
      .b_i(plane_b),
      .normal_a_o(normal_a),
      .normal_b_o(normal_b),
      .a_points_o(a_points),
      .b_points_o(b_points),
      .edge_edge_o(edge_edge)
  );

  triaxis_prisms #(
      .W(W),
      .Comb(1'b1)
  ) u_prisms (
      .clk_i(1'b0),
      .a_heights_i(heights_a),
      .b_heights_i(heights_b),
      .normal_a_i(normal_a),
      .normal_b_i(normal_b),
      .a_points_i(a_points),
      .b_points_i(b_points),
      .a_o(a),
      .b_o(b),
      .aab_o(aab),
      .abb_o(abb)
  );

  triaxis_projections #(
      .W(W),
      .Comb(1'b1)
  ) u_projections (
      .clk_i(1'b0),
      .a_i(a),
      .b_i(b),
      .aab_i(aab),
      .abb_i(abb),
      .flat_a_o(flat_a),
      .flat_b_o(flat_b),
      .flat_edges_o(flat_edges),
      .normal_a_o(project_a),
      .normal_b_o(project_b),
      .own_o(own),
      .points_o(points)
  );

  // Coordinate k of vertex n seen from vertex m.
  function automatic wide_t from (coord_t vertex[6][3], int m, int n, int k);
    return wide_t'(vertex[n][k]) - wide_t'(vertex[m][k]);
  endfunction

  // Twice the area of three vertices, seen along z.
  function automatic wide_t area(coord_t vertex[6][3], int m, int n, int o);
    return from (vertex, m, n, 0) * from (vertex, m, o, 1) -
        from (vertex, m, n, 1) * from (vertex, m, o, 0);
  endfunction

  // Six times the volume of four vertices.
  function automatic wide_t volume(coord_t vertex[6][3], int m, int n, int o, int p);
    wide_t sum;
    sum = '0;
    for (int k = 0; k < 3; k++) begin
      sum += from (vertex, m, p, k) *
          (from (vertex, m, n, (k + 1) % 3) * from (vertex, m, o, (k + 2) % 3) -
           from (vertex, m, n, (k + 2) % 3) * from (vertex, m, o, (k + 1) % 3));
    end
    return sum;
  endfunction

  always_comb begin
    NormalA : assert (wide_t'(normal_a) == area(vertex_i, 0, 1, 2));
    NormalB : assert (wide_t'(normal_b) == area(vertex_i, 3, 4, 5));
    PointOnA : assert (wide_t'(a_points[1][2]) == area(vertex_i, 1, 2, 5));
    PointOnB : assert (wide_t'(b_points[2][1]) == area(vertex_i, 5, 3, 1));
    EdgeEdge :
    assert (wide_t'(edge_edge[2][1]) == area(vertex_i, 2, 0, 5) - area(vertex_i, 2, 0, 4));
    OnNormalA : assert (wide_t'(project_a[1]) == volume(vertex_i, 0, 1, 2, 4));
    OnNormalB : assert (wide_t'(project_b[2]) == -volume(vertex_i, 3, 4, 5, 2));
    OnEdges : assert (wide_t'(points[1][2][0]) == volume(vertex_i, 1, 2, 5, 3));
    SeenLargest :
    cover (wide_t'(project_a[1]) == 2 * wide_t'((2 ** W - 1) * (2 ** W - 1) * (2 ** W - 1)));
  end

endmodule
