// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whether two triangles collide, touching included, as a combinational function behind
// the port list of the design that this core replaces. The normals are accepted and not trusted:
// they are computed from the vertices.
// Widths: coordinates W bits signed; see triaxis_pkg for the rest.
// Latency: 0, combinational.

module CollisionDetector
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16
) (
    input logic signed [W-1:0] A1_x,
    input logic signed [W-1:0] A1_y,
    input logic signed [W-1:0] A1_z,
    input logic signed [W-1:0] A2_x,
    input logic signed [W-1:0] A2_y,
    input logic signed [W-1:0] A2_z,
    input logic signed [W-1:0] A3_x,
    input logic signed [W-1:0] A3_y,
    input logic signed [W-1:0] A3_z,
    input logic signed [W-1:0] B1_x,
    input logic signed [W-1:0] B1_y,
    input logic signed [W-1:0] B1_z,
    input logic signed [W-1:0] B2_x,
    input logic signed [W-1:0] B2_y,
    input logic signed [W-1:0] B2_z,
    input logic signed [W-1:0] B3_x,
    input logic signed [W-1:0] B3_y,
    input logic signed [W-1:0] B3_z,
    input logic signed [W-1:0] NA_x,
    input logic signed [W-1:0] NA_y,
    input logic signed [W-1:0] NA_z,
    input logic signed [W-1:0] NB_x,
    input logic signed [W-1:0] NB_y,
    input logic signed [W-1:0] NB_z,
    output logic CollisionOccurs
);

  typedef logic signed [W-1:0] coord_t;
  coord_t a[3][3], b[3][3];
  verdict_t verdict;

  assign a[0] = '{A1_x, A1_y, A1_z};
  assign a[1] = '{A2_x, A2_y, A2_z};
  assign a[2] = '{A3_x, A3_y, A3_z};
  assign b[0] = '{B1_x, B1_y, B1_z};
  assign b[1] = '{B2_x, B2_y, B2_z};
  assign b[2] = '{B3_x, B3_y, B3_z};

  triaxis_datapath #(
      .W(W),
      .M(0),
      .Comb(1'b1)
  ) u_datapath (
      .clk_i(1'b0),
      .valid_i(1'b1),
      .a_i(a),
      .b_i(b),
      .margin_i('0),
      .verdict_o(verdict)
  );

  logic unused;
  assign unused = ^{NA_x, NA_y, NA_z, NB_x, NB_y, NB_z, verdict};
  assign CollisionOccurs = verdict.is_near;

endmodule
