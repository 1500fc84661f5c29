// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the real ones' headers, in the proof `engine_twice`. Signals named free_* have no
// driver: the prover chooses them anew each clock.

// Any words.
module triaxis_parity_ram;

  logic [Pieces-1:0][PieceWidth-1:0] free_data;
  logic free_intact;
  assign read_data_o = free_data;
  assign intact_o = free_intact;

endmodule

// Any verdicts at any clocks.
// verilog_lint: waive module-filename
module triaxis_core;

  logic free_ready, free_valid;
  logic [15:0] free_verdict;
  logic [TAG-1:0] free_user;
  assign s_axis_tready_o = free_ready;
  assign m_axis_tvalid_o = free_valid;
  assign m_axis_tdata_o  = free_verdict;
  assign m_axis_tuser_o  = free_user;

endmodule
