// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: margin * (|c0| + |c1| ..), how far apart two projections on the axis c must be.
// Widths: components CWidth bits signed; their absolutes sum to less than 2^CWidth for every axis
// of triaxis_pkg (2^(2W+2) > 4 L^2 for edge x edge, 2^(W+1) > 2 L for edge x box), so CWidth bits
// unsigned, CWidth+1 signed. The product needs CWidth + M bits unsigned.
// Latency: threshold_latency(Components, CWidth, M).

`include "triaxis_stage.svh"

module triaxis_threshold
  import triaxis_pkg::*;
#(
    parameter int unsigned M = 8,
    parameter int unsigned Components = 3,
    parameter int unsigned CWidth = 34,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [CWidth-1:0] axis_i[Components],
    input logic [M-1:0] margin_i,
    output logic [CWidth+M-1:0] threshold_o
);

  localparam int unsigned NormLatency = 1 + sum_latency(Components);
  typedef logic signed [CWidth:0] norm_t;
  typedef logic [M-1:0] margin_t;

  norm_t abs_d[Components], abs_q[Components];
  norm_t norm;
  margin_t margin;
  logic signed [CWidth+M+1:0] product;

  for (genvar k = 0; k < Components; k++) begin : g_component
    assign abs_d[k] = (axis_i[k] < 0) ? -norm_t'(axis_i[k]) : norm_t'(axis_i[k]);
  end

  `TRIAXIS_STAGE(abs_q, abs_d)

  triaxis_sum #(
      .Terms(Components),
      .Width(CWidth + 1),
      .Comb (Comb)
  ) u_norm (
      .clk_i,
      .terms_i(abs_q),
      .sum_o  (norm)
  );

  triaxis_delay #(
      .T(margin_t),
      .Cycles(Comb ? 0 : NormLatency)
  ) u_margin (
      .clk_i,
      .d_i(margin_i),
      .q_o(margin)
  );

  triaxis_mul #(
      .AWidth(CWidth + 1),
      .BWidth(M + 1),
      .Comb  (Comb)
  ) u_mul (
      .clk_i,
      .a_i(norm),
      .b_i({1'b0, margin}),
      .product_o(product)
  );

  logic unused_sign;
  assign unused_sign = ^product[CWidth+M+1:CWidth+M];
  assign threshold_o = product[CWidth+M-1:0];

endmodule
