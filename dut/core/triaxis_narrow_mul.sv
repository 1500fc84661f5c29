// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the signed product wide_i * narrow_i by additions, one row for each bit of narrow_i: the
// top row counts negative. For factors of so few bits that a DSP block would be wasted on them.
// Widths: the product fits WideWidth + NarrowWidth bits; sums may wrap on the way.
// Latency: 2, as for the pieces of triaxis_mul: pairs of rows, then their sum.

`include "triaxis_stage.svh"

module triaxis_narrow_mul #(
    parameter int unsigned WideWidth = 17,
    parameter int unsigned NarrowWidth = 3,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [WideWidth-1:0] wide_i,
    input logic signed [NarrowWidth-1:0] narrow_i,
    output logic signed [WideWidth+NarrowWidth-1:0] product_o
);

  typedef logic signed [WideWidth+NarrowWidth-1:0] product_t;

  product_t row[NarrowWidth];
  product_t pair_d[(NarrowWidth+1)/2], pair_q[(NarrowWidth+1)/2];
  product_t total[(NarrowWidth+1)/2], product_d;  // pairs 0 to n, and all

  for (genvar b = 0; b < NarrowWidth; b++) begin : g_row
    assign row[b] = narrow_i[b] ? product_t'(wide_i) <<< b : '0;
  end

  for (genvar n = 0; n < (NarrowWidth + 1) / 2; n++) begin : g_pair
    if (2 * n + 2 < NarrowWidth) begin : g_add
      assign pair_d[n] = row[2*n] + row[2*n+1];
    end else if (2 * n + 2 == NarrowWidth) begin : g_top
      assign pair_d[n] = row[2*n] - row[2*n+1];
    end else begin : g_top_alone
      assign pair_d[n] = -row[2*n];
    end
  end
  `TRIAXIS_STAGE(pair_q, pair_d)

  for (genvar n = 0; n < (NarrowWidth + 1) / 2; n++) begin : g_total
    if (n == 0) begin : g_first
      assign total[n] = pair_q[n];
    end else begin : g_next
      assign total[n] = total[n-1] + pair_q[n];
    end
  end
  assign product_d = total[(NarrowWidth+1)/2-1];
  `TRIAXIS_STAGE(product_o, product_d)

endmodule
