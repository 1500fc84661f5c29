// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: one of the two copies of what a frame asks with, and whether a run begins by it. Both copies are
// given the same bytes: two that differ begin two runs that differ. Each is a module of its own, as tools merge
// registers that are always alike, but not what lies in two modules that they are to keep.
// Widths: HeaderBytes + FieldBytes bytes, the first of a frame in the lowest bits.
// Latency: one clock.

module triaxis_request
  import triaxis_board_pkg::*;
(
    input logic clk_i,
    input logic gather_i,  // the next byte comes
    input byte_t data_i,
    input logic execute_i,
    output logic run_o,
    output request_t request_o
);

  // Fields that a frame does not have are anything: nothing is made of them.
  request_t request_q;
  always_ff @(posedge clk_i) begin
    if (gather_i) request_q <= {data_i, request_q[$bits(request_t)-1:8]};
  end
  assign request_o = request_q;
  assign run_o = execute_i && request_q.command == CmdRun;

endmodule
