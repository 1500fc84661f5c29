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

  // All that rested on a copy in the last clock, and nothing that may be anything.
  ShowsAll :
  assert property (@(posedge clk_i) disable iff (!rst_ni) seen == $past(due))
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

// verilog_lint: waive module-filename
module triaxis_scrub_sva #(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 4096
) (
    input logic clk_i,
    input logic rst_ni,
    input logic scrub_i,
    input logic load,
    input logic [$clog2(Depth):0] count_i,
    input logic read_o,
    input logic [$clog2(Depth)-1:0] index_o,
    input logic tries,
    input logic [3:0] which,
    input logic looks,
    input logic signed [W-1:0] vertices[3][3],
    input logic signed [W-1:0] box[2][3],
    input logic signed [W-1:0] group[2][3],
    input logic [23:0] outside,
    input logic [31:0] misread,
    input logic broken_o,
    input logic wrong
);

  // One after the other, all of them.
  logic [$clog2(Depth):0] due_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) due_q <= '0;
    else if (load) due_q <= '0;
    else if (read_o) due_q <= (32'(due_q) + 1) % 32'(count_i);
  end

  ReadsInOrder :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      read_o == (scrub_i && count_i != '0) && (!read_o || 32'(index_o) == 32'(due_q)))
  else $error("the scrub reads another triangle than is due");

  InReset :
  assert property (@(posedge clk_i) !rst_ni && !$past(rst_ni) |-> index_o == '0)
  else $error("the scrub does not begin anew with a reset");

  logic [23:0] beyond;
  logic [31:0] wrong_bits;
  always_comb begin
    for (int k = 0; k < 3; k++) begin
      for (int v = 0; v < 3; v++) begin
        // All bits inverted: -1 less the number.
        beyond[8*k+2*v] =
            vertices[v][k] < (tries && 32'(which) == 8 + k ? -1 - box[0][k] : box[0][k]);
        beyond[8*k+2*v+1] =
            vertices[v][k] > (tries && 32'(which) == 8 + k ? -1 - box[1][k] : box[1][k]);
      end
      beyond[8*k+6] = box[0][k] < (tries && 32'(which) == 11 + k ? -1 - group[0][k] : group[0][k]);
      beyond[8*k+7] = box[1][k] > (tries && 32'(which) == 11 + k ? -1 - group[1][k] : group[1][k]);
    end
    wrong_bits = '0;
    if (tries && 32'(which) < 8) wrong_bits = 32'h01010101 << which;
  end

  Bounds :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      looks |-> outside == beyond && misread == wrong_bits)
  else $error("the scrub compares other bounds, or misreads other bits, than it is to");

  Told :
  assert property (@(posedge clk_i) disable iff (!rst_ni) broken_o == ($past(
      read_o
  ) && $past(
      rst_ni
  ) && !$past(
      load
  ) && !load && wrong))
  else $error("what the scrub finds is not what it says");

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
      {18 * W + 2 * IndexWidth + 2{core_valid_o}} & {core_pair_o, core_a_o, core_b_o, core_zone_o},
      verdict_valid_i && verdict_ready_o,
      m_axis_near_tvalid_o,
      {2 * IndexWidth{m_axis_near_tvalid_o}} & m_axis_near_tdata_o,
      cycles_o,
      group_pairs_skipped_o,
      group_pairs_opened_o,
      pairs_skipped_o,
      tested_o,
      m_axis_done_tvalid_o,
      status_o,
      zones_o,
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

bind triaxis_mesh_scrub triaxis_scrub_sva #(
    .W(W),
    .Depth(Depth)
) u_scrub_sva (
    .clk_i,
    .rst_ni,
    .scrub_i,
    .load(clear_i || push_i),
    .count_i,
    .read_o,
    .index_o,
    .tries(trial_i),
    .which(which_i),
    .looks(reading_q),
    .vertices(
    '{
        '{triangle_read_i[0+:W], triangle_read_i[W+:W], triangle_read_i[2*W+:W]},
        '{triangle_read_i[3*W+:W], triangle_read_i[4*W+:W], triangle_read_i[5*W+:W]},
        '{triangle_read_i[6*W+:W], triangle_read_i[7*W+:W], triangle_read_i[8*W+:W]}
    }
    ),
    .box(box_i),
    .group(group_i),
    .outside,
    .misread,
    .broken_o,
    .wrong(!intact_i || outside != '0 || (index_read_o == IndexWidth'(count_i - 1'b1) &&
        (crc_d ^ misread) != came_q))
);
