// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: whole frames with a good CRC, held in a memory until they are released. Each frame that
// is not handed out is told by one pulse of error_o: bad CRC, fewer bytes than the shortest frame
// has, more than MaxFrameBytes, bad stuffing, a framing error, or a beginning before the last frame
// was released: a frame that has two of these is told twice. Empty frames are passed over. Each
// byte is kept with its parity, and broken_o tells of one that is shown, and has changed.
// Widths: 0 .. MaxFrameBytes bytes are counted.
// Latency: 1 clock from a frame's end to full_o; data_o shows address_i in the same clock.

module triaxis_frame_rx
  import triaxis_board_pkg::*;
(
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    input byte_t data_i,
    input logic end_i,
    input logic error_i,
    output logic full_o,
    output logic [$clog2(MaxFrameBytes)-1:0] length_o,  // with the CRC; 0 is the longest, 256
    input logic [$clog2(MaxFrameBytes)-1:0] address_i,
    output byte_t data_o,
    input logic release_i,
    input logic trial_i,  // what is shown is taken as broken
    output logic broken_o,
    output logic error_o
);

  typedef logic [$clog2(MaxFrameBytes+1)-1:0] length_t;
  localparam length_t Shortest = length_t'(HeaderBytes + CrcBytes);
  localparam length_t Longest = length_t'(MaxFrameBytes);

  logic [8:0] memory_q[MaxFrameBytes];
  length_t count_q;
  logic full_q, skip_q;
  logic [31:0] crc;

  logic over, refused, store, ended, good;
  // While a frame is held, the next one may not begin: its whole is passed over.
  assign refused = full_q || count_q == Longest;
  // Bytes of a frame that is passed over may be stored: nothing asks for them.
  assign store = valid_i && !refused;
  assign over = end_i || error_i;
  assign ended = end_i && !skip_q && count_q != '0;
  assign good = ended && count_q >= Shortest && crc == CrcResidue;

  triaxis_crc32 u_crc (
      .clk_i,
      .rst_ni,
      .start_i(over),
      .valid_i(store),
      .data_i,
      .crc_o  (crc)
  );

  always_ff @(posedge clk_i) begin
    if (store) memory_q[count_q[$clog2(MaxFrameBytes)-1:0]] <= {^data_i, data_i};
  end
  logic parity, shown;
  assign {parity, data_o} = memory_q[address_i];
  assign shown = full_q && (length_o == '0 || address_i < length_o);
  assign broken_o = shown && ((parity != ^data_o) || trial_i);

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      count_q <= '0;
      full_q  <= 1'b0;
      skip_q  <= 1'b0;
      error_o <= 1'b0;
    end else begin
      error_o <= error_i || (ended && !good) || (valid_i && !skip_q && refused);
      if (release_i) full_q <= 1'b0;
      if (over) begin
        count_q <= '0;
        skip_q  <= 1'b0;
      end else if (store) begin
        count_q <= count_q + length_t'(1);
      end else if (valid_i) begin
        skip_q <= 1'b1;
      end
      if (good) full_q <= 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (good) length_o <= count_q[$clog2(MaxFrameBytes)-1:0];
  end

  assign full_o = full_q;

endmodule
