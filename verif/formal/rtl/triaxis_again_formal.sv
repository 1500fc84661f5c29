// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Pairs that are asked again, in the engine as it ships: their queue takes each that comes, and no more are
// on their way to a verdict than are counted for. None is new while one waits to be asked again, so that both
// together are never more than were on their way. All but what counts is free, see triaxis_again_surroundings.

`include "triaxis_formal.svh"

`define WALK u_mesh.g_walk[0].u_walk

module triaxis_again_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic s_axis_run_tvalid_i,
    input logic [3*move_width(W)-1:0] s_axis_run_tdata_i,
    input logic [run_user_width(M)-1:0] s_axis_run_tuser_i,
    input logic abort_i,
    input logic m_axis_near_tready_i,
    input logic m_axis_done_tready_i
);

  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes),
      .Certify(1'b1)
  ) u_mesh (
      .s_axis_load_tvalid_i(1'b0),
      .s_axis_load_tready_o(),
      .s_axis_load_tdata_i('0),
      .s_axis_load_tuser_i('0),
      .count_a_o(),
      .count_b_o(),
      .overfull_o(),
      .signature_a_o(),
      .signature_b_o(),
      .s_axis_run_tready_o(),
      .busy_o(),
      .m_axis_near_tvalid_o(),
      .m_axis_near_tdata_o(),
      .m_axis_done_tvalid_o(),
      .status_o(),
      .cycles_o(),
      .group_pairs_skipped_o(),
      .group_pairs_opened_o(),
      .pairs_skipped_o(),
      .tested_o(),
      .near_o(),
      .zones_o(),
      .acknowledge_i(1'b0),
      .fault_o(),
      .*
  );

  `TRIAXIS_RESET_FIRST

  logic again, issue, fresh, awake_q;
  logic [31:0] held, waiting, on_way;
  assign again = `WALK.again;
  assign issue = `WALK.issue;
  assign fresh = issue && !`WALK.again_valid;
  assign held = 32'(u_mesh.g_core.u_core.held_q);
  assign waiting = 32'(`WALK.u_again.held_q);
  assign on_way = 32'(`WALK.u_near.in_flight_q);
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) awake_q <= 1'b0;
    else awake_q <= 1'b1;
  end

  always_comb begin
    if (rst_ni) begin
      AgainFits : assert (!again || `WALK.u_again.ready_o);
      AgainFirst :
      assert (!issue || waiting == '0 || (!fresh && {
        `WALK.triangle_b_index_o, `WALK.triangle_a_index_o
      } == `WALK.pair_again));
      OnTheirWay : assert (on_way <= u_mesh.InFlight);
      // One more that is issued is still counted.
      RoomToIssue : assert (!issue || on_way < u_mesh.InFlight);
      VerdictsAwaited : assert (!u_mesh.verdict_valid || on_way != '0);
      SeenAgain : cover (waiting > 32'd1 && issue && `WALK.pair_valid);
      SeenStalled : cover (waiting != '0 && !`WALK.fetch_ready);
      // What makes it inductive.
      assert (on_way == 32'(`WALK.u_fetch.read_valid_q) + 32'(`WALK.core_valid_o) + held);
      assert (held + 32'd2 <= u_mesh.InFlight);
      assert (on_way + waiting <= u_mesh.InFlight);
      assert (`WALK.u_again.held_q == `WALK.u_again.u_words.write_q - `WALK.u_again.u_words.read_q);
      assert (!awake_q || `WALK.u_again.ready_o == (waiting != `WALK.AgainDepth));
      assert (awake_q || on_way + waiting == '0);
    end
  end

endmodule
