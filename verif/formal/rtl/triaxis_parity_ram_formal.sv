// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A memory with parity: a word that is read as it was written, at its address, is intact; with any one bit
// inverted of the word (so of the memory, of its parity, or of what was read), of the address that it was
// read at, or of the address that is remembered, it is not; nor is one on trial. Any one word is followed.
// The bits that are inverted are free, at each clock: see the edits of the proof `engine_parity`.

`include "triaxis_formal.svh"

module triaxis_parity_ram_formal
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned Pieces = 9,
    parameter int unsigned PieceWidth = 16,
    parameter int unsigned Words = 4096,
    localparam int unsigned AddressWidth = address_width(Words)
) (
    input logic clk_i,
    input logic write_i,
    input logic [AddressWidth-1:0] write_address_i,
    input logic [Pieces-1:0][PieceWidth-1:0] write_data_i,
    input logic read_i,
    input logic [AddressWidth-1:0] read_address_i,
    input logic trial_i,
    input logic mark_i
);

  typedef logic [AddressWidth-1:0] address_t;
  typedef logic [Pieces-1:0][PieceWidth-1:0] data_t;
  typedef logic [Pieces-1:0] parity_t;

  data_t read_data_o;
  logic  intact_o;
  triaxis_parity_ram #(
      .Pieces(Pieces),
      .PieceWidth(PieceWidth),
      .Words(Words)
  ) u_ram (
      .*
  );

  logic following_q = 1'b0;
  logic read_q = 1'b0;
  address_t at_q, due_at_q, missed_q;
  data_t last_q, due_q;
  always_ff @(posedge clk_i) begin
    if (write_i && (mark_i || (following_q && write_address_i == at_q))) begin
      following_q <= 1'b1;
      at_q <= write_address_i;
      last_q <= write_data_i;
    end
    if (read_i) begin
      read_q <= following_q && (read_address_i ^ u_ram.free_read) == at_q;
      due_q <= last_q;
      due_at_q <= at_q;
      missed_q <= u_ram.free_read;
    end
  end

  function automatic parity_t parity_of(data_t data, address_t address);
    for (int i = 0; i < int'(Pieces); i++) parity_of[i] = ^data[i];
    parity_of[0] = parity_of[0] ^ (^address);
  endfunction

  logic none, one;
  logic [$bits(data_t)+Pieces+2*AddressWidth-1:0] inverted;
  assign inverted = {u_ram.free_word, u_ram.free_late, missed_q};
  assign none = inverted == '0;
  assign one = !none && (inverted & (inverted - ($bits(inverted))'(1))) == '0;

  always_comb begin
    Intact : assert (!read_q || !none || (intact_o == !trial_i && read_data_o == due_q));
    Broken : assert (!read_q || !one || trial_i || !intact_o);
    SeenBroken : cover (read_q && one && missed_q != '0 && !read_i);
    SeenIntact : cover (read_q && none && intact_o && due_q != '0);
    // What makes it inductive.
    assert (!following_q || u_ram.u_words.memory_q[at_q] == {parity_of(last_q, at_q), last_q});
    assert (!read_q || (u_ram.address_q == (due_at_q ^ missed_q) && u_ram.kept == {parity_of(
        due_q, due_at_q
    ), due_q}));
  end

endmodule
