// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A memory: a word that is read is the one that was written last at its address, whatever is written and read
// besides; it stays until the next read. Any one word is followed.

`include "triaxis_formal.svh"

module triaxis_ram_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Width = 144,
    parameter int unsigned Words = 4096,
    localparam int unsigned AddressWidth = address_width(Words)
) (
    input logic clk_i,
    input logic write_i,
    input logic [AddressWidth-1:0] write_address_i,
    input logic [Width-1:0] write_data_i,
    input logic read_i,
    input logic [AddressWidth-1:0] read_address_i,
    input logic mark_i
);

  logic [Width-1:0] read_data_o;

  triaxis_ram #(
      .Width(Width),
      .Words(Words)
  ) u_ram (
      .*
  );

  logic following_q = 1'b0;
  logic read_q = 1'b0;
  logic [AddressWidth-1:0] at_q;
  logic [Width-1:0] last_q, due_q;
  always_ff @(posedge clk_i) begin
    if (write_i && (mark_i || (following_q && write_address_i == at_q))) begin
      following_q <= 1'b1;
      at_q <= write_address_i;
      last_q <= write_data_i;
    end
    if (read_i) begin
      read_q <= following_q && read_address_i == at_q;
      due_q  <= last_q;
    end
  end

  always_comb begin
    Kept : assert (!following_q || u_ram.memory_q[at_q] == last_q);
    Read : assert (!read_q || read_data_o == due_q);
    SeenLater : cover (read_q && !read_i && write_i && write_address_i != at_q);
  end

endmodule
