// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Bus-functional model of both streams of triaxis_core, for whole bursts: drives pairs and tready, and
// monitors both streams, calling C++ (burst_bfm.cpp) by DPI-C. Driver and monitors share nothing but
// the pins. Everything is sampled before the rising edge and driven after it, as the pin agents do.

module triaxis_burst_bfm #(
    parameter int unsigned DataWidth = 288,
    parameter int unsigned UserWidth = 16,
    parameter int unsigned TAG = 16
) (
    input logic clk_i,
    input logic rst_ni,

    output logic s_axis_tvalid_o,
    input logic s_axis_tready_i,
    output logic [DataWidth-1:0] s_axis_tdata_o,
    output logic [UserWidth-1:0] s_axis_tuser_o,

    input logic m_axis_tvalid_i,
    output logic m_axis_tready_o,
    input logic [15:0] m_axis_tdata_i,
    input logic [TAG-1:0] m_axis_tuser_i
);

  // One call for each clock in which the driver may change the pins: the next beat, or none.
  import "DPI-C" function bit triaxis_source_next(
    output bit [DataWidth-1:0] data,
    output bit [63:0] user
  );
  // The offered beat was accepted.
  import "DPI-C" function void triaxis_source_accepted();
  // Whether results are taken in the clock to come.
  import "DPI-C" function bit triaxis_sink_ready();
  // A clock of either stream, seen by its monitor.
  import "DPI-C" function void triaxis_input_beat(
    input bit [DataWidth-1:0] data,
    input bit [63:0] user,
    input bit ready
  );
  import "DPI-C" function void triaxis_output_beat(
    input bit [15:0] data,
    input bit [63:0] user,
    input bit ready
  );
  // A reset begins.
  import "DPI-C" function void triaxis_input_reset();
  import "DPI-C" function void triaxis_output_reset();

  initial begin
    s_axis_tvalid_o = 1'b0;
    m_axis_tready_o = 1'b0;
  end

  // --- Drivers --------------------------------------------------------------------------------------

  // A beat that was offered and not accepted when a reset strikes is offered again after it.
  logic waiting_q = 1'b0;

  always_ff @(posedge clk_i) begin
    bit [DataWidth-1:0] data;
    bit [63:0] user;
    if (!rst_ni) begin
      s_axis_tvalid_o <= 1'b0;
      waiting_q <= waiting_q || s_axis_tvalid_o;
    end else if (waiting_q) begin
      s_axis_tvalid_o <= 1'b1;
      waiting_q <= 1'b0;
    end else if (!s_axis_tvalid_o || s_axis_tready_i) begin
      if (s_axis_tvalid_o) triaxis_source_accepted();
      // Fills data and user, with zeros where there is no beat.
      s_axis_tvalid_o <= triaxis_source_next(data, user);
      s_axis_tdata_o  <= data;
      s_axis_tuser_o  <= user[UserWidth-1:0];
    end
  end

  always_ff @(posedge clk_i) m_axis_tready_o <= triaxis_sink_ready();

  // --- Monitors -------------------------------------------------------------------------------------

  logic input_reset_q = 1'b1, output_reset_q = 1'b1;

  always_ff @(posedge clk_i) begin
    input_reset_q <= !rst_ni;
    if (!rst_ni) begin
      if (!input_reset_q) triaxis_input_reset();
    end else if (s_axis_tvalid_o) begin
      triaxis_input_beat(s_axis_tdata_o, 64'(s_axis_tuser_o), s_axis_tready_i);
    end
  end

  always_ff @(posedge clk_i) begin
    output_reset_q <= !rst_ni;
    if (!rst_ni) begin
      if (!output_reset_q) triaxis_output_reset();
    end else if (m_axis_tvalid_i) begin
      triaxis_output_beat(m_axis_tdata_i, 64'(m_axis_tuser_i), m_axis_tready_o);
    end
  end

endmodule
