// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: which groups of A can be near anything of B: the box of each, moved and grown, against
// the box of the whole of B, one group a clock. Those that overlap leave with their grown box;
// skip_o counts the others, each with all groups of B.
// Widths: see triaxis_mesh_pkg; groups_a_i is not zero.
// Latency: 4 from start_i to the first row that overlaps.

module triaxis_group_rows
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Groups = 512,
    localparam int unsigned GroupWidth = address_width(Groups),
    localparam int unsigned CountWidth = $clog2(Groups) + 1
) (
    input  logic clk_i,
    input  logic rst_ni,
    input  logic start_i,
    input  logic drain_i,
    output logic idle_o,

    input logic [CountWidth-1:0] groups_a_i,
    input logic signed [grown_width(W)-1:0] shift_i[2][3],
    input logic signed [W-1:0] object_b_i[2][3],

    output logic read_o,
    output logic [GroupWidth-1:0] group_o,
    input logic signed [W-1:0] box_i[2][3],

    output logic valid_o,
    input logic ready_i,
    output logic [GroupWidth-1:0] row_o,
    output logic signed [grown_width(W)-1:0] grown_o[2][3],
    output logic skip_o,
    output logic used_o  // the box of a group, in this clock
);

  localparam int unsigned QueueDepth = 4;
  localparam int unsigned GrownWidth = grown_width(W);

  typedef logic [GroupWidth-1:0] group_t;
  typedef logic [CountWidth-1:0] count_t;
  typedef struct packed {
    group_t row;
    logic [6*GrownWidth-1:0] grown;
  } row_t;

  // --- One group of A a clock ---------------------------------------------------------------------------

  logic enable, last, overlap;
  logic scanning_q, read_valid_q, grown_valid_q;
  group_t next_q, read_group_q, grown_group_q;
  logic signed [GrownWidth-1:0] grown[2][3];
  logic signed [W-1:0] whole[1][2][3];

  assign last = count_t'(next_q) + count_t'(1) == groups_a_i;
  assign read_o = scanning_q && enable;
  assign group_o = next_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      scanning_q <= 1'b0;
      read_valid_q <= 1'b0;
      grown_valid_q <= 1'b0;
    end else if (drain_i) begin
      scanning_q <= 1'b0;
      read_valid_q <= 1'b0;
      grown_valid_q <= 1'b0;
    end else if (start_i) begin
      scanning_q <= 1'b1;
    end else if (enable) begin
      scanning_q <= scanning_q && !last;
      read_valid_q <= scanning_q;
      grown_valid_q <= read_valid_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (start_i) begin
      next_q <= '0;
    end else if (enable) begin
      next_q <= next_q + group_t'(1);
      read_group_q <= next_q;
      grown_group_q <= read_group_q;
    end
  end

  triaxis_grow #(
      .W(W)
  ) u_grow (
      .clk_i,
      .enable_i(enable),
      .box_i,
      .shift_i,
      .grown_o (grown)
  );

  assign whole[0] = object_b_i;
  triaxis_overlap #(
      .W(W),
      .Lanes(1)
  ) u_overlap (
      .grown_i  (grown),
      .boxes_i  (whole),
      .overlap_o(overlap)
  );

  assign used_o = read_valid_q && enable;
  assign skip_o = grown_valid_q && enable && !overlap;

  // --- Rows that wait -------------------------------------------------------------------------------------

  row_t entering, waiting;
  logic entering_valid, waiting_valid, taken;
  assign entering_valid = grown_valid_q && overlap;
  assign taken = ready_i || drain_i;
  assign entering.row = grown_group_q;
  for (genvar c = 0; c < 2; c++) begin : g_corner
    for (genvar k = 0; k < 3; k++) begin : g_axis
      assign entering.grown[(3*c+k)*GrownWidth+:GrownWidth] = grown[c][k];
      assign grown_o[c][k] = waiting.grown[(3*c+k)*GrownWidth+:GrownWidth];
    end
  end

  triaxis_stream_fifo #(
      .T(row_t),
      .Depth(QueueDepth)
  ) u_waiting (
      .clk_i,
      .rst_ni,
      .valid_i(entering_valid),
      .ready_o(enable),
      .data_i (entering),
      .valid_o(waiting_valid),
      .ready_i(taken),
      .data_o (waiting)
  );

  assign valid_o = waiting_valid;
  assign row_o   = waiting.row;
  assign idle_o  = !scanning_q && !read_valid_q && !grown_valid_q && !waiting_valid;

endmodule
