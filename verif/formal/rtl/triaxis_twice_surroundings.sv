// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the ports of the real ones, in the proof `engine_twice`. Signals named free_* have no
// driver: the prover chooses them anew each clock.

// Any words.
module triaxis_parity_ram
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Pieces = 6,
    parameter int unsigned PieceWidth = 16,
    parameter int unsigned Words = 512,
    localparam int unsigned AddressWidth = address_width(Words)
) (
    input logic clk_i,
    input logic write_i,
    input logic [AddressWidth-1:0] write_address_i,
    input logic [Pieces-1:0][PieceWidth-1:0] write_data_i,
    input logic read_i,
    input logic [AddressWidth-1:0] read_address_i,
    input logic trial_i,  // the word read is taken as one with a wrong bit
    output logic [Pieces-1:0][PieceWidth-1:0] read_data_o,
    output logic intact_o
);

  logic [Pieces-1:0][PieceWidth-1:0] free_data;
  logic free_intact;
  assign read_data_o = free_data;
  assign intact_o = free_intact;

endmodule

// Any verdicts at any clocks.
// verilog_lint: waive module-filename
module triaxis_core
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,  // coordinate bits, 8..32
    parameter int unsigned M = 0,  // margin bits, 0..W; 0: collision only
    parameter int unsigned TAG = 16,  // tag bits, at least 1
    parameter bit EdgeBox = 1'b1,  // 0: coplanar pairs answer near (needs M = 0)
    parameter bit Gating = 1'b1,  // 0: flags also for pairs that their boxes decide
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_tvalid_i,
    output logic s_axis_tready_o,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [TAG+M-1:0] s_axis_tuser_i,

    output logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    output logic [15:0] m_axis_tdata_o,
    output logic [TAG-1:0] m_axis_tuser_o
);

  logic free_ready, free_valid;
  logic [15:0] free_verdict;
  logic [TAG-1:0] free_user;
  assign s_axis_tready_o = free_ready;
  assign m_axis_tvalid_o = free_valid;
  assign m_axis_tdata_o  = free_verdict;
  assign m_axis_tuser_o  = free_user;

endmodule
