// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the signed product a_i * b_i, split into pieces that each fill one DSP48E1.
// Widths: |a b| <= 2^(AWidth-1) * 2^(BWidth-1) = 2^(AWidth+BWidth-2), which fits
// AWidth + BWidth bits signed.
// Pieces of at most NarrowBits bits take no DSP block.
// Latency: mul_latency(AWidth, BWidth): one clock for the operands, two for the products, all in
// registers that the DSP block has, then the sum of the pieces.

`include "triaxis_stage.svh"

module triaxis_mul
  import triaxis_pkg::*;
#(
    parameter int unsigned AWidth = 17,
    parameter int unsigned BWidth = 17,
    parameter bit Comb = 1'b0
) (
    input logic clk_i,
    input logic signed [AWidth-1:0] a_i,
    input logic signed [BWidth-1:0] b_i,
    output logic signed [AWidth+BWidth-1:0] product_o
);

  // x goes to the 25-bit ports, y to the 18-bit ports.
  localparam bit FirstOnA = mul_first_on_a(AWidth, BWidth);
  localparam int unsigned XWidth = FirstOnA ? AWidth : BWidth;
  localparam int unsigned YWidth = FirstOnA ? BWidth : AWidth;
  localparam int unsigned XPieces = mul_pieces(XWidth, DspPortA);
  localparam int unsigned YPieces = mul_pieces(YWidth, DspPortB);
  localparam int unsigned XStep = DspPortA - 1;
  localparam int unsigned YStep = DspPortB - 1;
  localparam int unsigned Products = XPieces * YPieces;

  typedef logic signed [AWidth+BWidth-1:0] product_t;

  logic signed [AWidth-1:0] a_q;
  logic signed [BWidth-1:0] b_q;
  `TRIAXIS_STAGE(a_q, a_i)
  `TRIAXIS_STAGE(b_q, b_i)

  logic signed [XWidth-1:0] x;
  logic signed [YWidth-1:0] y;
  if (FirstOnA) begin : g_straight
    assign x = a_q;
    assign y = b_q;
  end else begin : g_swapped
    assign x = b_q;
    assign y = a_q;
  end

  logic signed [DspPortA-1:0] x_piece[XPieces];
  logic signed [DspPortB-1:0] y_piece[YPieces];
  for (genvar i = 0; i < XPieces; i++) begin : g_x
    if (i == XPieces - 1) begin : g_top
      assign x_piece[i] = DspPortA'(signed'(x[XWidth-1:i*XStep]));
    end else begin : g_low
      assign x_piece[i] = {1'b0, x[i*XStep+:XStep]};
    end
  end
  for (genvar j = 0; j < YPieces; j++) begin : g_y
    if (j == YPieces - 1) begin : g_top
      assign y_piece[j] = DspPortB'(signed'(y[YWidth-1:j*YStep]));
    end else begin : g_low
      assign y_piece[j] = {1'b0, y[j*YStep+:YStep]};
    end
  end

  product_t term[Products];
  for (genvar i = 0; i < XPieces; i++) begin : g_products
    for (genvar j = 0; j < YPieces; j++) begin : g_product
      // The top pieces are narrower than their ports: keep only the bits that a piece can have.
      localparam int unsigned XBits = (i == XPieces - 1) ? XWidth - i * XStep : DspPortA;
      localparam int unsigned YBits = (j == YPieces - 1) ? YWidth - j * YStep : DspPortB;
      logic signed [XBits+YBits-1:0] piece;
      if (XBits <= NarrowBits) begin : g_narrow_x
        triaxis_narrow_mul #(
            .WideWidth(YBits),
            .NarrowWidth(XBits),
            .Comb(Comb)
        ) u_mul (
            .clk_i,
            .wide_i(y_piece[j][YBits-1:0]),
            .narrow_i(x_piece[i][XBits-1:0]),
            .product_o(piece)
        );
      end else if (YBits <= NarrowBits) begin : g_narrow_y
        triaxis_narrow_mul #(
            .WideWidth(XBits),
            .NarrowWidth(YBits),
            .Comb(Comb)
        ) u_mul (
            .clk_i,
            .wide_i(x_piece[i][XBits-1:0]),
            .narrow_i(y_piece[j][YBits-1:0]),
            .product_o(piece)
        );
      end else begin : g_wide
        logic signed [XBits+YBits-1:0] piece_d, piece_q;
        assign piece_d = XBits'(x_piece[i]) * YBits'(y_piece[j]);
        `TRIAXIS_STAGE(piece_q, piece_d)
        `TRIAXIS_STAGE(piece, piece_q)
      end
      assign term[i*YPieces+j] = (AWidth + BWidth)'(piece) <<< (i * XStep + j * YStep);
    end
  end

  triaxis_sum #(
      .Terms(Products),
      .Width(AWidth + BWidth),
      .Comb (Comb)
  ) u_sum (
      .clk_i,
      .terms_i(term),
      .sum_o  (product_o)
  );

endmodule
