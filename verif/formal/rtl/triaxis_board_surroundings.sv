// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the real ones' headers, for what surrounds the decision of go on the board,
// in the proof `board_go`. Signals named free_* have no driver: the prover chooses them anew each
// clock. What is not free is what another proof shows of the real module, named beside it.

// Whole frames, of any bytes, at any clocks. Frames stay as they are until they are released, have
// 13 to 256 bytes and a good CRC (`board_frame`). Of a frame one byte, of any place, reads the same
// each time; all others are free at each reading, which allows more than the real one does; and any
// byte that is shown may be told as broken.
module triaxis_receiver;

  logic free_arrives, free_broken, free_error;
  byte_t free_data, free_byte, byte_q;
  logic [$clog2(MaxFrameBytes)-1:0] free_place, place_q;
  logic [$clog2(MaxFrameBytes+1)-1:0] free_length;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) full_o <= 1'b0;
    else full_o <= full_o ? !release_i : free_arrives;
  end
  always_ff @(posedge clk_i) begin
    if (!full_o) begin
      length_o <= free_length[$clog2(MaxFrameBytes)-1:0];
      place_q  <= free_place;
      byte_q   <= free_byte;
    end
  end
  assign data_o   = address_i == place_q ? byte_q : free_data;
  assign broken_o = full_o && free_broken;
  assign error_o  = free_error;

  always_comb begin
    Length : assume (free_length >= 9'(HeaderBytes + CrcBytes) && free_length <= 9'(MaxFrameBytes));
  end

endmodule

// The engine: takes loads and runs, but none while a run is going on (`engine_control`), and says of a
// run, once, after it was accepted, whatever it likes: that it says complete only of a run that was
// neither aborted nor ended early, in whose last clock nothing was left to do, is `engine_control`;
// that what it says near_o and zones_o of are the verdicts of all pairs tested, and no zone is free that was not
// asked about, `engine_near`; that what was not tested is separated, `engine_skip`, `engine_skip_small` and
// `engine_boxes`; that none is lost between, `engine_walk`; that verdicts are right, the proofs of the core. A
// fault comes at any clock, and stays until it is acknowledged: `engine_checks`.
// Triangles get the next number of their mesh: `engine_boxes`.
module triaxis_mesh;

  logic free_ends, free_near_valid, free_fault;
  logic [2:0] free_status;
  logic [2*IndexWidth-1:0] free_near;
  logic [PairCountWidth-1:0] free_count;
  logic [Zones-1:1] free_zones;
  logic [31:0] free_signature_a, free_signature_b;
  logic load, running_q, awake_q;
  logic [IndexWidth:0] count_q[2];

  assign load = s_axis_load_tvalid_i && s_axis_load_tready_o;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      awake_q   <= 1'b0;
      running_q <= 1'b0;
      fault_o   <= 1'b0;
      count_q   <= '{default: '0};
    end else begin
      awake_q <= 1'b1;
      fault_o <= free_fault || (fault_o && !acknowledge_i);
      if (s_axis_run_tvalid_i && s_axis_run_tready_o) running_q <= 1'b1;
      else if (m_axis_done_tvalid_o && m_axis_done_tready_i) running_q <= 1'b0;
      for (int mesh = 0; mesh < 2; mesh++) begin
        if (load && s_axis_load_tuser_i == {1'b1, 1'(mesh)}) count_q[mesh] <= '0;
        else if (load && s_axis_load_tuser_i == {1'b0, 1'(mesh)})
          count_q[mesh] <= count_q[mesh] + (IndexWidth + 1)'(1);
      end
    end
  end

  assign s_axis_run_tready_o = awake_q && !running_q;
  assign s_axis_load_tready_o = s_axis_run_tready_o;
  assign busy_o = running_q;
  assign count_a_o = count_q[0];
  assign count_b_o = count_q[1];
  assign overfull_o = '0;  // asserted: nothing is loaded into a mesh that is full
  assign signature_a_o = free_signature_a;
  assign signature_b_o = free_signature_b;
  assign m_axis_near_tvalid_o = free_near_valid;
  assign m_axis_near_tdata_o = free_near;
  assign m_axis_done_tvalid_o = free_ends && running_q;
  assign status_o = status_e'(free_status);
  assign near_o = free_count;
  assign zones_o = free_zones;
  assign tested_o = '0;
  assign pairs_skipped_o = '0;
  assign group_pairs_skipped_o = '0;
  assign group_pairs_opened_o = '0;
  assign cycles_o = '0;

endmodule

// Replies leave at any pace; what they say has no part in go.
module triaxis_transmitter;

  logic free_ready;
  assign ready_o = free_ready;
  assign ring_number_o = '0;
  assign line_o = 1'b1;

endmodule

module triaxis_display;

  assign {seg_no, an_no} = '0;

endmodule

// Pairs for the host have no part in go; their numbers only decide which RESULTS are refused.
// verilog_lint: waive module-filename
module triaxis_near_ring;

  logic [31:0] free_freed, free_written;
  assign freed_o = free_freed;
  assign written_o = free_written;
  assign full_o = 1'b0;
  assign tready_o = 1'b1;
  assign data_o = '0;

endmodule
