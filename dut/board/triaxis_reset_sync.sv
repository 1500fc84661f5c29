// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the board's reset from its button: asserted at once, released with the clock. In reset
// from power-up: the registers are configured as zeros.
// Latency: Stages clocks from the button's release.

module triaxis_reset_sync #(
    parameter int unsigned Stages = 3  // at least 3
) (
    input  logic clk_i,
    input  logic button_ni,
    output logic rst_no
);

  // The values at configuration count: no button is pressed at power-up.
  // verilator lint_off PROCASSINIT
  (* ASYNC_REG = "TRUE" *) logic [Stages-2:0] stage_q = '0;
  logic rst_nq = 1'b0;
  // verilator lint_on PROCASSINIT

  always_ff @(posedge clk_i or negedge button_ni) begin
    if (!button_ni) begin
      stage_q <= '0;
      rst_nq  <= 1'b0;
    end else begin
      stage_q <= {stage_q[Stages-3:0], 1'b1};
      rst_nq  <= stage_q[Stages-2];
    end
  end

  assign rst_no = rst_nq;

endmodule
