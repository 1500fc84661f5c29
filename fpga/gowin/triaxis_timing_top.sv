// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: nothing of its own. It lets triaxis_core be routed alone: the core has hundreds of port
// bits, more than a part has pins. A shift register, filled by one pin, drives every input of the
// core; every output is captured by a register and shifted out by another pin. So nothing of the core
// can be removed, and each path of its ports begins or ends in a register.
// Widths: one register for each bit of the core's ports.
// Latency: not defined: this is for routing only, never for use.

module triaxis_timing_top #(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter int unsigned TAG = 16,
    parameter bit EdgeBox = 1'b1
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic serial_i,
    input  logic capture_i,
    output logic serial_o
);

  localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8);

  typedef struct packed {
    logic in_valid;
    logic out_ready;
    logic [TAG+M-1:0] user;
    logic [DataWidth-1:0] data;
  } inputs_t;
  typedef struct packed {
    logic in_ready;
    logic out_valid;
    logic [TAG-1:0] user;
    logic [15:0] data;
  } outputs_t;

  inputs_t inputs_q;
  outputs_t outputs, outputs_q, shift_q;
  logic serial_q, capture_q;

  always_ff @(posedge clk_i) begin
    serial_q  <= serial_i;
    capture_q <= capture_i;
    inputs_q  <= {inputs_q[$bits(inputs_t)-2:0], serial_q};
    outputs_q <= outputs;
    shift_q   <= capture_q ? outputs_q : outputs_t'(shift_q >> 1);
    serial_o  <= shift_q[0];
  end

  triaxis_core #(
      .W(W),
      .M(M),
      .TAG(TAG),
      .EdgeBox(EdgeBox)
  ) u_core (
      .clk_i,
      .rst_ni,
      .s_axis_tvalid_i(inputs_q.in_valid),
      .s_axis_tready_o(outputs.in_ready),
      .s_axis_tdata_i (inputs_q.data),
      .s_axis_tuser_i (inputs_q.user),
      .m_axis_tvalid_o(outputs.out_valid),
      .m_axis_tready_i(inputs_q.out_ready),
      .m_axis_tdata_o (outputs.data),
      .m_axis_tuser_o (outputs.user)
  );

endmodule
