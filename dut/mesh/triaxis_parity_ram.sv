// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a memory of words of several pieces, each with a bit of parity; that of the lowest is over the
// word's address as well. intact_o says of the word read that no single bit of it, or of where it was read,
// has changed since it was written. What was never written is not intact, or is by chance. Parity, and no
// correction: a word that is broken stops the machine, so to find it is all that is needed.
// Widths: Words words of Pieces pieces of PieceWidth bits, and Pieces bits.
// Latency: 1 from read_i to read_data_o and intact_o.

module triaxis_parity_ram
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Pieces = 6,
    parameter int unsigned PieceWidth = 16,
    parameter int unsigned Words = 512,
    localparam int unsigned AddressWidth = address_width(Words)
) (
    input logic clk_i,
    input logic write_i,
    input logic [AddressWidth-1:0] write_address_i,
    input logic [Pieces-1:0][PieceWidth-1:0] write_data_i,
    input logic read_i,
    input logic [AddressWidth-1:0] read_address_i,
    input logic trial_i,  // the word read is taken as one with a wrong bit
    output logic [Pieces-1:0][PieceWidth-1:0] read_data_o,
    output logic intact_o
);

  typedef logic [AddressWidth-1:0] address_t;
  typedef logic [Pieces-1:0] parity_t;
  typedef struct packed {
    parity_t parity;
    logic [Pieces-1:0][PieceWidth-1:0] data;
  } word_t;

  word_t written, found;
  parity_t  due;
  address_t address_q;

  assign written.data = write_data_i;
  for (genvar i = 0; i < Pieces; i++) begin : g_piece
    if (i == 0) begin : g_with_address
      assign written.parity[i] = ^{write_address_i, write_data_i[i]};
      assign due[i] = ^{address_q, found.data[i], trial_i};
    end else begin : g_alone
      assign written.parity[i] = ^write_data_i[i];
      assign due[i] = ^found.data[i];
    end
  end

  triaxis_ram #(
      .Width($bits(word_t)),
      .Words(Words)
  ) u_words (
      .clk_i,
      .write_i,
      .write_address_i,
      .write_data_i(written),
      .read_i,
      .read_address_i,
      .read_data_o (found)
  );

  always_ff @(posedge clk_i) begin
    if (read_i) address_q <= read_address_i;
  end

  assign read_data_o = found.data;
  assign intact_o = found.parity == due;

endmodule
