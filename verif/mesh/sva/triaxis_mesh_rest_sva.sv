// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// At rest, and from a reset on, nothing is under way in the mesh engine, and no memory is read.

module triaxis_mesh_rest_sva (
    input logic clk_i,
    input logic rst_ni,
    input logic busy_o,
    input logic idle,
    input logic settled,
    input logic first,
    input logic summary,
    input logic reads,
    input logic scrubs,
    input logic answers,
    input logic core_as_asked
);

  NoReadAtRest :
  assert property (@(posedge clk_i) disable iff (!rst_ni) !busy_o |-> !reads)
  else $error("a memory was read although no run is under way");

  NoScrubInRun :
  assert property (@(posedge clk_i) disable iff (!rst_ni) scrubs |-> !busy_o)
  else $error("a memory was scrubbed during a run");

  IdleAtRest :
  assert property (@(posedge clk_i) disable iff (!rst_ni) !busy_o |-> idle)
  else $error("something is under way although no run is");

  NothingAfterReset :
  assert property (@(posedge clk_i) $rose(rst_ni) |-> settled && !first && !summary)
  else $error("something of before a reset is left after it");

  // The engine wakes in the clock after the reset.
  QuietInReset :
  assert property (@(posedge clk_i) !rst_ni || $rose(rst_ni) |-> !answers)
  else $error("in a reset, or right after it, something is accepted, offered or held");

  CoreAsAsked :
  assert property (@(posedge clk_i) core_as_asked)
  else $error("the core in the engine has other options than the engine was asked for");

endmodule

bind triaxis_mesh triaxis_mesh_rest_sva u_rest_sva (
    .clk_i,
    .rst_ni,
    .busy_o,
    .idle(g_walk[0].u_walk.idle),
    .settled,
    .first(g_walk[0].u_walk.first),
    .summary(status_o != triaxis_mesh_pkg::StatusNone || {
      cycles_o,
      group_pairs_skipped_o,
      group_pairs_opened_o,
      pairs_skipped_o,
      tested_o,
      near_o,
      zones_o
    } != '0),
    .reads({row_read, word_read, box_a_read, box_b_read, triangle_read} != '0),
    .scrubs(u_store_a.scrub_read || u_store_b.scrub_read),
    .answers({
      s_axis_load_tready_o,
      s_axis_run_tready_o,
      busy_o,
      m_axis_near_tvalid_o,
      m_axis_done_tvalid_o,
      count_a_o,
      count_b_o,
      overfull_o,
      fault_o
    } != '0),
    .core_as_asked(g_core.u_core.Gating == Gating && g_core.u_core.EdgeBox == EdgeBox)
);
