// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: a run's near pairs, kept until the host frees them. A full ring stalls the engine, but
// for a run that is being aborted: what finds no place is dropped. Nothing is freed meanwhile (the
// abort is answered first), so the pairs held are always the first of the run. Pairs are numbered
// from the run's first; those from freed_o up to written_o are held. With free_i the host has those
// before number_i, the one that it asks for next.
// Widths: numbers of pairs 32 bits, above the engine's at most 31 (Depth <= 32,768). Entries is a
// power of two, so that the low bits of a pair's number are its address.
// Latency: 1 clock from number_i to data_o.

module triaxis_near_ring #(
    parameter int unsigned Width   = 24,
    parameter int unsigned Entries = 1024
) (
    input logic clk_i,
    input logic rst_ni,
    input logic clear_i,
    input logic drop_i,
    input logic free_i,
    output logic [31:0] freed_o,
    output logic [31:0] written_o,
    output logic full_o,

    input logic tvalid_i,
    output logic tready_o,
    input logic [Width-1:0] tdata_i,

    input logic [31:0] number_i,  // with free_i: freed_o .. written_o
    output logic [Width-1:0] data_o
);

  localparam int unsigned AddressWidth = $clog2(Entries);

  logic [31:0] written_q, freed_q;
  logic write;
  logic [AddressWidth:0] held;  // 0 .. Entries

  assign written_o = written_q;
  assign freed_o = freed_q;
  assign held = written_q[AddressWidth:0] - freed_q[AddressWidth:0];
  assign full_o = held[AddressWidth];
  assign tready_o = !full_o || drop_i;
  assign write = tvalid_i && !full_o;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      written_q <= '0;
      freed_q   <= '0;
    end else if (clear_i) begin
      written_q <= '0;
      freed_q   <= '0;
    end else begin
      if (write) written_q <= written_q + 32'd1;
      if (free_i) freed_q <= number_i;
    end
  end

  triaxis_ram #(
      .Width(Width),
      .Words(Entries)
  ) u_pairs (
      .clk_i,
      .write_i(write),
      .write_address_i(written_q[AddressWidth-1:0]),
      .write_data_i(tdata_i),
      .read_i(1'b1),
      .read_address_i(number_i[AddressWidth-1:0]),
      .read_data_o(data_o)
  );

  logic [31-AddressWidth:0] unused_number;
  assign unused_number = number_i[31:AddressWidth];

endmodule
