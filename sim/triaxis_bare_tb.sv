// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A simulation with nothing in it: where what is under test is a library beside it, cocotb still needs a
// simulator to live in.

module triaxis_bare_tb (
    // cocotb finds no module without a signal.
    input logic unused_i
);

  logic unused;
  assign unused = unused_i;

endmodule
