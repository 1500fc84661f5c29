// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the checks of the mesh engine look at, bound from outside the RTL. Without an upset two copies are
// alike whatever they show of themselves, so no answer tells what is compared: these rules do.

module triaxis_shown_sva #(
    parameter int unsigned Width = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Width-1:0] seen,
    input logic [Width-1:0] due
);

  // All that rests on a copy in this clock, and nothing that may be anything.
  ShowsAll :
  assert property (@(posedge clk_i) disable iff (!rst_ni) seen == due)
  else $error("what is compared of a copy is not all that rests on it");

endmodule

// verilog_lint: waive module-filename
module triaxis_misread_sva #(
    parameter int unsigned Width = 1
) (
    input logic clk_i,
    input logic rst_ni,
    input logic tries,
    input logic [4:0] which,
    input logic [Width-1:0] seen,
    input logic [Width-1:0] second
);

  logic [Width-1:0] wrong;
  always_comb begin
    wrong = '0;
    for (int unsigned i = 32'(which); i < Width; i += 32) wrong[i] = tries;
  end

  MisreadAsAsked :
  assert property (@(posedge clk_i) disable iff (!rst_ni) second == (seen ^ wrong))
  else $error("other bits of the second copy are misread than the run tries");

endmodule

bind triaxis_walk triaxis_shown_sva #(
    .Width(SeenWidth)
) u_shown_sva (
    .clk_i,
    .rst_ni,
    .seen(seen_o),
    .due(SeenWidth'({
      M == 0 ? '0 : {$bits(core_margin_o) {core_valid_o}} & core_margin_o,
      s_axis_run_tready_o,
      busy_o,
      u_control.drain_o,
      row_read_o,
      {GroupWidth{row_read_o}} & row_group_o,
      word_read_o,
      {GroupWordWidth{word_read_o}} & word_index_o,
      box_a_read_o,
      {IndexWidth{box_a_read_o}} & box_a_index_o,
      box_b_read_o,
      {WordWidth{box_b_read_o}} & box_b_word_o,
      triangle_read_o,
      {2 * IndexWidth{triangle_read_o}} & {triangle_a_index_o, triangle_b_index_o},
      core_valid_o,
      {18 * W + 2 * IndexWidth{core_valid_o}} & {core_pair_o, core_a_o, core_b_o},
      verdict_ready_o,
      m_axis_near_tvalid_o,
      {2 * IndexWidth{m_axis_near_tvalid_o}} & m_axis_near_tdata_o,
      cycles_o,
      group_pairs_skipped_o,
      group_pairs_opened_o,
      pairs_skipped_o,
      tested_o,
      m_axis_done_tvalid_o,
      status_o,
      near_o
    }))
);

// Faces of boxes in the order of the RTL's box_t: the highest coordinate of the highest corner first.
bind triaxis_mesh_intake triaxis_shown_sva #(
    .Width(SeenWidth)
) u_shown_sva (
    .clk_i,
    .rst_ni,
    .seen(seen_o),
    .due({
      count_o,
      overfull_o,
      valid_q,
      {IndexWidth{write_o}} & index_o,
      {9 * W{write_o}} & triangle_o,
      {6 * W{write_o}} & {
        box_o[1][2], box_o[1][1], box_o[1][0], box_o[0][2], box_o[0][1], box_o[0][0]
      },
      {6 * W{write_o && index_o % Group != 0}} & {
        group_q[1][2], group_q[1][1], group_q[1][0], group_q[0][2], group_q[0][1], group_q[0][0]
      },
      {6 * W{(valid_q == '0 && count_o != '0) || (write_o && index_o != '0)}} & {
        object_o[1][2],
        object_o[1][1],
        object_o[1][0],
        object_o[0][2],
        object_o[0][1],
        object_o[0][0]
      }
    })
);

bind triaxis_mesh triaxis_misread_sva #(
    .Width(SeenWidth)
) u_misread_sva (
    .clk_i,
    .rst_ni,
    .tries(busy_o && trial_q.kind == triaxis_mesh_pkg::TrialWalk),
    .which(trial_q.which),
    .seen (seen[1]),
    .second
);

bind triaxis_mesh_store triaxis_misread_sva #(
    .Width(SeenWidth)
) u_misread_sva (
    .clk_i,
    .rst_ni,
    .tries(trial_intake_i),
    .which(which_i),
    .seen (seen[1]),
    .second
);
