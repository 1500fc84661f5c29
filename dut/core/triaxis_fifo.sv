// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a first-in first-out queue with the oldest word shown ahead of pop_i. The user never
// pushes into a full queue nor pops an empty one; assertions bound from outside check that.
// Widths: words of type T; Depth is a power of two, so the pointers wrap by themselves.
// Latency: FifoLatency = 1 from push to valid.

module triaxis_fifo #(
    parameter type T = logic,
    parameter int unsigned Depth = 32
) (
    input logic clk_i,
    input logic rst_ni,
    input logic push_i,
    input T data_i,
    input logic pop_i,
    output logic valid_o,
    output T data_o
);

  localparam int unsigned PtrWidth = $clog2(Depth);
  // One bit more than the address tells a full queue from an empty one.
  typedef logic [PtrWidth:0] ptr_t;

  T memory_q[Depth];
  ptr_t write_q, read_q;

  always_ff @(posedge clk_i) begin
    if (push_i) memory_q[write_q[PtrWidth-1:0]] <= data_i;
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      write_q <= '0;
      read_q  <= '0;
    end else begin
      if (push_i) write_q <= write_q + ptr_t'(1);
      if (pop_i) read_q <= read_q + ptr_t'(1);
    end
  end

  assign valid_o = write_q != read_q;
  assign data_o  = memory_q[read_q[PtrWidth-1:0]];

endmodule
