// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: Y = A * B, signed, in the multiplier of the GW5A family, without its registers.
// Widths: 36 x 27 bits, whose product has 63.
// Latency: none.

module \$__MULTIPLIER (
    input  [35:0] A,
    input  [26:0] B,
    output [62:0] Y
);
  parameter A_SIGNED = 0;
  parameter B_SIGNED = 0;
  parameter A_WIDTH = 36;
  parameter B_WIDTH = 27;
  parameter Y_WIDTH = 63;

  MULT27X36 #(
      .P_SEL(1'b0)
  ) _TECHMAP_REPLACE_ (
      .A(B),
      .B(A),
      .D(26'b0),
      .CLK(2'b0),
      .CE(2'b0),
      .RESET(2'b0),
      .PSEL(1'b0),
      .PADDSUB(1'b0),
      .DOUT(Y)
  );
endmodule
