// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The ring of near pairs by two counts of 32 bits: what it takes, until it holds Entries of them, and what is
// freed. Any one pair is followed: while it is held, a read of its number gives it.

`include "triaxis_formal.svh"

module triaxis_near_ring_formal #(
    parameter int unsigned Width   = 24,
    parameter int unsigned Entries = 1024
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic drop_i,
    input logic free_i,
    input logic tvalid_i,
    input logic [Width-1:0] tdata_i,
    input logic [31:0] number_i,
    input logic mark_i
);

  logic [31:0] freed_o, written_o;
  logic full_o, tready_o;
  logic [Width-1:0] data_o;
  triaxis_near_ring #(
      .Width  (Width),
      .Entries(Entries)
  ) u_ring (
      .*
  );

  `TRIAXIS_RESET_FIRST

  // Counts of what was kept and freed, and a pair: whether it is followed, its number, what it is.
  logic [31:0] kept_q, freed_q, at_q;
  logic full, keep, frees, followed_q, read_q;
  logic [Width-1:0] pair_q, due_q;
  assign full  = kept_q - freed_q == Entries;
  assign keep  = tvalid_i && !full;
  assign frees = free_i && number_i - freed_q > at_q - freed_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {kept_q, freed_q, followed_q, read_q} <= '0;
    end else begin
      kept_q <= clear_i ? '0 : kept_q + 32'(keep);
      freed_q <= clear_i ? '0 : free_i ? number_i : freed_q;
      followed_q <= !clear_i && (followed_q ? !frees : keep && mark_i);
      read_q <= followed_q && number_i == at_q;
    end
  end
  always_ff @(posedge clk_i) begin
    if (keep && mark_i && !followed_q) begin
      at_q   <= kept_q;
      pair_q <= tdata_i;
    end
    due_q <= pair_q;
  end

  always_comb begin
    FreedAreHeld : assume (!free_i || number_i - freed_q <= kept_q - freed_q);
    if (rst_ni) begin
      Numbers : assert (written_o == kept_q && freed_o == freed_q);
      Bounded : assert (kept_q - freed_q <= Entries);
      Full : assert (full_o == full);
      Taken : assert (tready_o == (!full || drop_i));
      Read : assert (!read_q || data_o == due_q);
      SeenFull : cover (full_o && tvalid_i && !drop_i);
      SeenDropped : cover (full_o && tvalid_i && tready_o);
      SeenFreed : cover (full_o && free_i && number_i == kept_q);
      SeenRead : cover (read_q && data_o != '0);
      // What makes it inductive.
      assert (!followed_q || (at_q - freed_q < kept_q - freed_q &&
                              u_ring.u_pairs.memory_q[at_q[$clog2(
          Entries
      )-1:0]] == pair_q));
    end
  end

endmodule
