// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A count that stops: each clock it grows by what happened in it, and stays at the largest number,
// for all counts.

`include "triaxis_formal.svh"

module triaxis_saturating_counter_formal #(
    parameter int unsigned Width = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic one_i,
    input logic other_i
);

  typedef logic [Width+1:0] wide_t;
  localparam wide_t Most = wide_t'((1 << Width) - 1);

  logic [Width-1:0] count_o;
  triaxis_saturating_counter #(.Width(Width)) u_count (.*);

  `TRIAXIS_RESET_FIRST

  wide_t due_q, next;
  assign next = wide_t'(count_o) + wide_t'(one_i) + wide_t'(other_i);
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) due_q <= '0;
    else due_q <= next > Most ? Most : next;
  end

  always_comb begin
    if (rst_ni) begin
      Counted : assert (wide_t'(count_o) == due_q);
      SeenFull : cover (wide_t'(count_o) == Most && (one_i || other_i));
    end
  end

endmodule
