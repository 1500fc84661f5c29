// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: with the origin at A1, p and q the other vertices of A and r_0..r_2 those of B,
//   normal_a_o = p x q,  f_o[j] = r_j x r_{j+1}                               at TimeCross
//   pr_o[j] = p x r_j,  rq_o[j] = r_j x q (zero without the edge x box axes)   at TimeCross
//   the ten triple products pqr[j] = (p x q) . r_j, pf[j] = p . f_j, qf[j] = q . f_j and
//   rst = r_0 . f_1                                                           at TimeDet
// Widths: differences W+1, cross products 2W+1, triple products 3W+2 bits signed.
// Latency: TimeCross = DiffLatency + cross_latency(W); TimeDet = TimeCross + dot_latency(W).

module triaxis_products
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter bit EdgeBox = 1'b1,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [W-1:0] a_i[3][3],
    input logic signed [W-1:0] b_i[3][3],
    output logic signed [cross_width(W)-1:0] normal_a_o[3],
    output logic signed [cross_width(W)-1:0] f_o[3][3],
    output logic signed [cross_width(W)-1:0] pr_o[3][3],
    output logic signed [cross_width(W)-1:0] rq_o[3][3],
    output logic signed [det_width(W)-1:0] pqr_o[3],
    output logic signed [det_width(W)-1:0] pf_o[3],
    output logic signed [det_width(W)-1:0] qf_o[3],
    output logic signed [det_width(W)-1:0] rst_o
);

  localparam int unsigned Wait = Comb ? 0 : cross_latency(W);
  typedef logic signed [diff_width(W)-1:0] vector_t[3];
  typedef vector_t vectors_t[3];

  vector_t p, q, p_late, q_late;
  vectors_t r, r_late;

  triaxis_differences #(
      .W(W),
      .Comb(Comb)
  ) u_differences (
      .clk_i,
      .a_i,
      .b_i,
      .p_o(p),
      .q_o(q),
      .r_o(r)
  );

  // The differences again, due with the cross products.
  triaxis_delay #(
      .T(vector_t),
      .Cycles(Wait)
  ) u_p_late (
      .clk_i,
      .d_i(p),
      .q_o(p_late)
  );
  triaxis_delay #(
      .T(vector_t),
      .Cycles(Wait)
  ) u_q_late (
      .clk_i,
      .d_i(q),
      .q_o(q_late)
  );
  triaxis_delay #(
      .T(vectors_t),
      .Cycles(Wait)
  ) u_r_late (
      .clk_i,
      .d_i(r),
      .q_o(r_late)
  );

  triaxis_cross #(
      .W(W),
      .Comb(Comb)
  ) u_normal_a (
      .clk_i,
      .a_i(p),
      .b_i(q),
      .cross_o(normal_a_o)
  );

  for (genvar j = 0; j < 3; j++) begin : g_vertex
    triaxis_cross #(
        .W(W),
        .Comb(Comb)
    ) u_f (
        .clk_i,
        .a_i(r[j]),
        .b_i(r[(j+1)%3]),
        .cross_o(f_o[j])
    );
    triaxis_dot #(
        .W(W),
        .Comb(Comb)
    ) u_pqr (
        .clk_i,
        .cross_i(normal_a_o),
        .diff_i (r_late[j]),
        .dot_o  (pqr_o[j])
    );
    triaxis_dot #(
        .W(W),
        .Comb(Comb)
    ) u_pf (
        .clk_i,
        .cross_i(f_o[j]),
        .diff_i (p_late),
        .dot_o  (pf_o[j])
    );
    triaxis_dot #(
        .W(W),
        .Comb(Comb)
    ) u_qf (
        .clk_i,
        .cross_i(f_o[j]),
        .diff_i (q_late),
        .dot_o  (qf_o[j])
    );
    if (EdgeBox) begin : g_edge_box
      triaxis_cross #(
          .W(W),
          .Comb(Comb)
      ) u_pr (
          .clk_i,
          .a_i(p),
          .b_i(r[j]),
          .cross_o(pr_o[j])
      );
      triaxis_cross #(
          .W(W),
          .Comb(Comb)
      ) u_rq (
          .clk_i,
          .a_i(r[j]),
          .b_i(q),
          .cross_o(rq_o[j])
      );
    end else begin : g_no_edge_box
      assign pr_o[j] = '{default: '0};
      assign rq_o[j] = '{default: '0};
    end
  end

  triaxis_dot #(
      .W(W),
      .Comb(Comb)
  ) u_rst (
      .clk_i,
      .cross_i(f_o[1]),
      .diff_i (r_late[0]),
      .dot_o  (rst_o)
  );

endmodule
