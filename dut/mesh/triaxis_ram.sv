// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a memory with one port to write and one to read, in block RAM where it is large. The
// word read stays until the next read. Reading a word while it is written is not done: meshes are
// loaded between runs.
// Widths: Words words of Width bits.
// Latency: 1 from read_i to read_data_o.

module triaxis_ram
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Width = 96,
    parameter int unsigned Words = 512,
    localparam int unsigned AddressWidth = address_width(Words)
) (
    input logic clk_i,
    input logic write_i,
    input logic [AddressWidth-1:0] write_address_i,
    input logic [Width-1:0] write_data_i,
    input logic read_i,
    input logic [AddressWidth-1:0] read_address_i,
    output logic [Width-1:0] read_data_o
);

  logic [Width-1:0] memory_q[Words];

  always_ff @(posedge clk_i) begin
    if (write_i) memory_q[write_address_i] <= write_data_i;
  end

  always_ff @(posedge clk_i) begin
    if (read_i) read_data_o <= memory_q[read_address_i];
  end

endmodule
