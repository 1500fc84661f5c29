// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mesh that is looked at again: what is read of it, and what is said of what was read. Words that are read, and
// boxes, are anything, at each clock; what was pushed is kept here, so that a word can be held against it.
//
// Of a CRC a triangle makes anything here, but the same of the same: see the edits of the proof `engine_scrub`.
// A pass is one reading of the mesh, from its first triangle to its last. That nothing is found without a reason
// rests on this: of each beginning of a mesh the CRC is kept, as it was when that was all that had been pushed.
// As long as words are as pushed, that of what was read is the one of so many triangles.

`include "triaxis_formal.svh"

module triaxis_scrub_formal #(
    parameter int unsigned W = 16,
    parameter int unsigned Depth = 8,
    localparam int unsigned IndexWidth = $clog2(Depth)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic push_i,
    input logic [9*W-1:0] triangle_i,
    input logic scrub_i,
    input logic [9*W-1:0] triangle_read_i,
    input logic [1:0][2:0][W-1:0] box_found_i,
    input logic [1:0][2:0][W-1:0] group_found_i,
    input logic intact_i,
    input logic trial_i,
    input logic [3:0] which_i
);

  typedef logic [31:0] crc_t;
  typedef logic [9*W-1:0] triangle_t;
  typedef logic [IndexWidth-1:0] index_t;
  typedef logic [IndexWidth:0] count_t;
  typedef logic signed [W+1:0] wide_t;

  crc_t signature_o;
  logic read_o, broken_o;
  index_t index_o, index_read_o;
  logic signed [W-1:0] box_i[2][3], group_i[2][3];
  count_t count_q;
  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign box_i[c][k]   = box_found_i[c][k];
      assign group_i[c][k] = group_found_i[c][k];
    end
  end

  triaxis_mesh_scrub #(
      .W(W),
      .Depth(Depth)
  ) u_scrub (
      .count_i(count_q),
      .*
  );

  `TRIAXIS_RESET_FIRST

  // --- What is pushed -------------------------------------------------------------------------------------

  // A mesh counts what it is given, as `engine_boxes` shows.
  // Triangles, and the CRC before each; that of each beginning of the mesh, and of the whole.
  logic load, keep;
  crc_t came, prefix_q[Depth], beginnings[Depth+1];
  triangle_t held_q[Depth];
  assign load = clear_i || push_i;
  assign keep = push_i && !clear_i && count_q != count_t'(Depth);
  assign came = ~signature_o;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) count_q <= '0;
    else if (clear_i) count_q <= '0;
    else if (keep) count_q <= count_q + count_t'(1);
  end
  always_ff @(posedge clk_i) begin
    if (keep) begin
      held_q[index_t'(count_q)]   <= triangle_i;
      prefix_q[index_t'(count_q)] <= came;
    end
  end
  always_comb begin
    for (int i = 0; i <= int'(Depth); i++)
    beginnings[i] = count_t'(i) < count_q ? prefix_q[i%Depth] : came;
  end

  // --- What is read -------------------------------------------------------------------------------------

  // The next one; the one in hand; the CRC of what this pass read before, and whether that was as pushed.
  logic reads, read_q, last, alike, same, same_q;
  count_t due_q, at_q;
  crc_t pass_d, pass_q;
  assign reads  = scrub_i && count_q != '0;
  assign last   = at_q + count_t'(1) == count_q;
  assign pass_d = u_scrub.crc_d;
  assign alike  = triangle_read_i == held_q[index_t'(at_q)];
  assign same   = same_q && alike;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      due_q  <= '0;
      read_q <= 1'b0;
      pass_q <= '1;
      same_q <= 1'b1;
    end else if (load) begin
      due_q  <= '0;
      read_q <= 1'b0;
      pass_q <= '1;
      same_q <= 1'b1;
    end else begin
      read_q <= reads;
      if (reads) due_q <= (due_q + count_t'(1)) % count_q;
      if (read_q) begin
        pass_q <= last ? '1 : pass_d;
        same_q <= last || same;
      end
    end
  end
  always_ff @(posedge clk_i) if (reads) at_q <= due_q;

  // Clocks of scrub_i since a triangle, any, was read, or all of them since something was loaded.
  count_t number_q, since_q;
  logic round_q;
  always_ff @(posedge clk_i) number_q <= number_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {since_q, round_q} <= '0;
    else if (load) {since_q, round_q} <= '0;
    else if (reads) begin
      since_q <= due_q == number_q ? '0 : since_q + count_t'(1);
      round_q <= round_q || due_q == number_q;
    end
  end

  // --- What is to be said of it ---------------------------------------------------------------------------

  // Beyond a bound on an axis: a vertex its box, the box that of its group; and with what is tried: with all
  // bits of the bounds inverted, so -1 less each.
  logic [2:0] beyond_box, beyond_group, found_box, found_group;
  for (genvar k = 0; k < 3; k++) begin : g_beyond
    wide_t vertex[3], lowest, highest, low, high, group_low, group_high;
    logic inverts_box, inverts_group;
    for (genvar v = 0; v < 3; v++) begin : g_vertex
      assign vertex[v] = wide_t'($signed(triangle_read_i[(3*v+k)*W+:W]));
    end
    assign lowest = vertex[0] < vertex[1] ? (vertex[0] < vertex[2] ? vertex[0] : vertex[2]) :
        (vertex[1] < vertex[2] ? vertex[1] : vertex[2]);
    assign highest = vertex[0] > vertex[1] ? (vertex[0] > vertex[2] ? vertex[0] : vertex[2]) :
        (vertex[1] > vertex[2] ? vertex[1] : vertex[2]);
    assign low = wide_t'(box_i[0][k]);
    assign high = wide_t'(box_i[1][k]);
    assign group_low = wide_t'(group_i[0][k]);
    assign group_high = wide_t'(group_i[1][k]);
    assign inverts_box = trial_i && 32'(which_i) == 8 + k;
    assign inverts_group = trial_i && 32'(which_i) == 11 + k;
    assign beyond_box[k] = !(low <= lowest && highest <= high);
    assign beyond_group[k] = !(group_low <= low && high <= group_high);
    assign found_box[k] = inverts_box ? !(-1 - low <= lowest && highest <= -1 - high) :
        beyond_box[k];
    assign found_group[k] = inverts_group ?
        !(-1 - group_low <= low && high <= -1 - group_high) : beyond_group[k];
  end

  logic looks, tries_crc, tries_box, tries_group, bounded, unlike;
  crc_t inverted;
  assign looks = read_q && !load;
  assign tries_crc = trial_i && which_i < 4'd8;
  assign tries_box = trial_i && which_i inside {[4'd8 : 4'd10]};
  assign tries_group = trial_i && which_i inside {[4'd11 : 4'd13]};
  assign bounded = {beyond_box, beyond_group} == '0;
  assign inverted = tries_crc ? 32'h0101_0101 << which_i : '0;
  assign unlike = last && (pass_d ^ came) != inverted;

  always_comb begin
    Same :
    assume (!looks || pass_q != beginnings[at_q] || !alike ||
            pass_d == beginnings[at_q+count_t'(1)]);
    if (rst_ni) begin
      // Reads in order, all over again, at each clock of scrub_i and at no other.
      Reads : assert (read_o == reads && (!reads || count_t'(index_o) == due_q));
      InTime : assert (number_q >= count_q || since_q < count_q);
      InTurn :
      assert (number_q >= count_q || !scrub_i || since_q + count_t'(1) != count_q ||
              (read_o && count_t'(index_o) == number_q));
      InHand : assert (!looks || count_t'(index_read_o) == at_q);
      // What is found, in the clock after it was read.
      Found :
      assert (broken_o == (looks && (!intact_i || found_box != '0 || found_group != '0 || unlike)));
      // Without a trial, of a mesh as it was pushed, within its boxes, nothing is.
      NoFalseAlarm :
      assert (!broken_o || tries_crc || tries_box || tries_group || !intact_i || !bounded ||
              (last && !same));
      // What is tried of a mesh that is right is found: bounds at any triangle, the CRC at its end.
      TriedBounds : assert (!looks || !(tries_box || tries_group) || !bounded || broken_o);
      TriedCrc : assert (!looks || !tries_crc || !last || !same || broken_o);

      SeenWhole : cover (looks && last && same && !broken_o && count_q == count_t'(3));
      SeenBroken : cover (broken_o && !trial_i && !intact_i && bounded && !unlike);
      SeenVertex : cover (broken_o && !trial_i && intact_i && beyond_box == 3'd4 && !last);
      SeenBox : cover (broken_o && !trial_i && intact_i && beyond_box == '0 && !last);
      SeenUnlike : cover (broken_o && !trial_i && intact_i && bounded && !same_q && alike);
      SeenTriedBox : cover (broken_o && tries_box && intact_i && bounded && !last);
      SeenTriedGroup : cover (broken_o && tries_group && intact_i && bounded && !last);
      SeenTriedCrc : cover (broken_o && tries_crc && intact_i && bounded && same);
      SeenPause : cover (looks && !reads && round_q && at_q == count_t'(1));

      // What makes it inductive.
      assert (count_q <= count_t'(Depth) && (due_q < count_q || due_q == '0));
      assert (beginnings[0] == '1);
      assert (!read_q || (at_q < count_q && due_q == (last ? '0 : at_q + count_t'(1))));
      assert (!same_q || pass_q == beginnings[read_q?at_q : due_q]);
      assert (number_q >= count_q || since_q == (due_q > number_q ?
              due_q - number_q - count_t'(1) :
              due_q + (round_q ? count_q - number_q - count_t'(1) : '0)));
      assert (number_q >= count_q || round_q || due_q <= number_q);
      // Where the scrub's own registers agree.
      assert (u_scrub.reading_q == read_q);
      // Of an empty mesh nothing is read, and a load begins it anew.
      assert (count_q == '0 || (u_scrub.crc_q == pass_q && count_t'(u_scrub.index_q) == due_q));
      assert (!read_q || u_scrub.last_q == last);
    end
  end

endmodule
