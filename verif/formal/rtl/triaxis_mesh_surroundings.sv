// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins in the proof of the engine's walk, with the real ones' headers.

// A mesh in memory: what is known of it is one triangle, whichever number it has: its vertices, its
// box, that of its group, that of the mesh. Whatever else is read is anything, and so is what is not
// intact: that no other word is changed is shown by `engine_memory` and `engine_parity`. All of it is
// new while the mesh is changed, and stays once it has settled: what the boxes are is shown by
// `engine_boxes`.
module triaxis_mesh_store;

  // A box: lowest corner, highest corner.
  typedef logic [1:0][2:0][W-1:0] box_t;
  typedef logic [IndexWidth:0] count_t;

  logic [IndexWidth-1:0] number_q, triangle_at_q, free_triangle_at;
  logic [WordWidth-1:0] box_at_q, free_box_at;
  logic [GroupWordWidth-1:0] group_at_q, free_group_at;
  logic [9*W-1:0] triangle_q;
  box_t object_q, group_q, box_q;
  count_t count_q;
  logic changed, settled_q;

  // No drivers: anything at each clock.
  logic free_settled, free_overfull, free_triangle_intact, free_differ, free_broken;
  logic [Lanes-1:0] free_boxes_intact, free_groups_intact;
  logic [9*W-1:0] free_triangle, other_triangle;
  box_t free_object, free_group, free_box, other_boxes[Lanes], other_groups[Lanes];

  assign changed = clear_i || push_i;
  assign settled_o = settled_q || free_settled;
  assign overfull_o = free_overfull;
  assign triangle_intact_o = free_triangle_intact;
  assign boxes_intact_o = free_boxes_intact;
  assign groups_intact_o = free_groups_intact;
  assign differ_o = free_differ;
  assign broken_o = free_broken;
  assign count_o = count_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q   <= '0;
      settled_q <= 1'b0;
    end else begin
      if (clear_i) count_q <= '0;
      else if (push_i && count_q != count_t'(Depth)) count_q <= count_q + count_t'(1);
      settled_q <= settled_o && !changed;
    end
  end

  always_ff @(posedge clk_i) begin
    number_q <= number_q;
    if (!settled_o || changed) begin
      triangle_q <= free_triangle;
      object_q   <= free_object;
      group_q    <= free_group;
      box_q      <= free_box;
    end
    // Where it is scrubbed any words are read: what the walk reads meanwhile, or has read, is lost.
    if (scrub_i) begin
      triangle_at_q <= free_triangle_at;
      box_at_q <= free_box_at;
      group_at_q <= free_group_at;
    end else begin
      if (triangle_read_i) triangle_at_q <= triangle_index_i;
      if (box_read_i) box_at_q <= box_word_i;
      if (group_read_i) group_at_q <= group_word_i;
    end
  end

  box_t boxes[Lanes], groups[Lanes];
  assign triangle_o = triangle_at_q == number_q && triangle_intact_o ? triangle_q : other_triangle;
  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    assign boxes[l] = 32'(box_at_q) * Lanes + l == 32'(number_q) && boxes_intact_o[l] ? box_q :
        other_boxes[l];
    assign groups[l] = 32'(group_at_q) * Lanes + l == 32'(number_q) / Group && groups_intact_o[l] ?
        group_q : other_groups[l];
    for (genvar c = 0; c < 2; c++) begin : g_corner
      for (genvar k = 0; k < 3; k++) begin : g_axis
        assign boxes_o[l][c][k] = boxes[l][c][k];
        assign group_boxes_o[l][c][k] = groups[l][c][k];
      end
    end
  end
  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign object_o[c][k] = object_q[c][k];
    end
  end

  // Boxes are not empty, and lie within one another: shown by `engine_boxes`.
  always_comb begin
    for (int k = 0; k < 3; k++) begin
      assume ($signed(object_q[0][k]) <= $signed(group_q[0][k]));
      assume ($signed(group_q[0][k]) <= $signed(box_q[0][k]));
      assume ($signed(box_q[0][k]) <= $signed(box_q[1][k]));
      assume ($signed(box_q[1][k]) <= $signed(group_q[1][k]));
      assume ($signed(group_q[1][k]) <= $signed(object_q[1][k]));
    end
  end

endmodule

// The core: takes pairs, and gives as many verdicts, at any clocks, of as many pairs at a time as its
// queue has places, few here; a pair a clock as long as each verdict was taken at once since it was empty:
// shown by `streams` and `certified`. Verdicts are anything. One pair, whichever it is, is followed: a verdict
// of it, with the zone that it was asked in, comes where it is inside; in any order, which allows more than the
// real one does, but that zones only get narrower, as those of the pairs do (`InOrder`). Were it twice inside,
// verdicts would be of any pair.
// verilog_lint: waive module-filename
module triaxis_core;

  localparam int unsigned Places = 2;
  typedef logic [$clog2(Places):0] count_t;
  count_t held_q, held_d;
  logic free_ready, free_valid, free_turn;
  logic [15:0] free_verdict;
  logic [TAG-1:0] free_user;
  logic [TAG-3:0] followed_q;
  logic [1:0] zone_q;
  logic comes, turn, here_q, twice_q, awake_q, eager_q;
  // Of the pair that came last, and of the verdict that was last on offer since it was empty.
  logic [1:0] zone, told, latest_q, told_q;

  assign zone = s_axis_tuser_i[M+TAG-2+:2];
  assign told = m_axis_tuser_o[TAG-1-:2];
  assign s_axis_tready_o = awake_q && (free_ready || eager_q) && held_q != count_t'(Places);
  assign m_axis_tvalid_o = free_valid && held_q != '0;
  assign m_axis_tdata_o = free_verdict;
  assign m_axis_tuser_o = turn ? {zone_q, followed_q} : free_user;
  assign comes = s_axis_tvalid_i && s_axis_tready_o && s_axis_tuser_i[M+:TAG-2] == followed_q;
  assign turn = here_q && !twice_q && (free_turn || held_q == count_t'(1));
  assign held_d = held_q + count_t'(s_axis_tvalid_i && s_axis_tready_o) -
      count_t'(m_axis_tvalid_o && m_axis_tready_i);
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      held_q <= '0;
      {here_q, twice_q, awake_q} <= '0;
      eager_q <= 1'b1;
      told_q <= '1;
    end else begin
      held_q  <= held_d;
      awake_q <= 1'b1;
      eager_q <= held_d == '0 || (eager_q && !(m_axis_tvalid_o && !m_axis_tready_i));
      if (held_d == '0) told_q <= '1;
      else if (m_axis_tvalid_o) told_q <= told;
      here_q <= held_d != '0 &&
          (comes || (here_q && !(turn && m_axis_tvalid_o && m_axis_tready_i)));
      twice_q <= held_d != '0 && (twice_q || (comes && here_q));
    end
  end
  always_ff @(posedge clk_i) begin
    followed_q <= followed_q;
    if (comes) zone_q <= zone;
    if (s_axis_tvalid_i && s_axis_tready_o) latest_q <= zone;
  end
  always_comb begin
    OfWhatIsInside : assume (turn || twice_q || free_user[TAG-3:0] != followed_q);
    OnItsWay : assume (!eager_q || held_q != count_t'(Places));
    NoWiderThanBefore : assume (!m_axis_tvalid_o || told <= told_q);
    InOrder : assert (!rst_ni || !s_axis_tvalid_i || held_q == '0 || zone <= latest_q);
  end

endmodule
