// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Top level of the burst simulation: the core, and the bus-functional model on its streams. main.cpp
// drives the clock; Python drives reset, and is woken by changes of wake_i.

module triaxis_burst_tb #(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter int unsigned TAG = 16,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic wake_i
);

  localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8);

  logic s_tvalid, s_tready, m_tvalid, m_tready;
  logic [DataWidth-1:0] s_tdata;
  logic [TAG+M-1:0] s_tuser;
  logic [15:0] m_tdata;
  logic [TAG-1:0] m_tuser;

  logic unused_wake;
  assign unused_wake = wake_i;

  triaxis_core #(
      .W(W),
      .M(M),
      .TAG(TAG),
      .EdgeBox(EdgeBox),
      .Gating(Gating)
  ) u_core (
      .clk_i,
      .rst_ni,
      .s_axis_tvalid_i(s_tvalid),
      .s_axis_tready_o(s_tready),
      .s_axis_tdata_i (s_tdata),
      .s_axis_tuser_i (s_tuser),
      .m_axis_tvalid_o(m_tvalid),
      .m_axis_tready_i(m_tready),
      .m_axis_tdata_o (m_tdata),
      .m_axis_tuser_o (m_tuser)
  );

  triaxis_burst_bfm #(
      .DataWidth(DataWidth),
      .UserWidth(TAG + M),
      .TAG(TAG)
  ) u_bfm (
      .clk_i,
      .rst_ni,
      .s_axis_tvalid_o(s_tvalid),
      .s_axis_tready_i(s_tready),
      .s_axis_tdata_o (s_tdata),
      .s_axis_tuser_o (s_tuser),
      .m_axis_tvalid_i(m_tvalid),
      .m_axis_tready_o(m_tready),
      .m_axis_tdata_i (m_tdata),
      .m_axis_tuser_i (m_tuser)
  );

endmodule
