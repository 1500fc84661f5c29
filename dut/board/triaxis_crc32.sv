// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the CRC-32 of IEEE 802.3 over the bytes since the last start: reflected, begun with
// ones. crc_o is the register; a frame carries its complement, lowest byte first.
// Latency: 1 clock, a byte a clock.

module triaxis_crc32
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::CrcPolynomial;
(
    input logic clk_i,
    input logic rst_ni,
    input logic start_i,  // forget what came before; a byte in the same clock is not taken
    input logic valid_i,
    input byte_t data_i,
    output logic [31:0] crc_o
);

  function automatic logic [31:0] after_byte(logic [31:0] crc, byte_t data);
    logic [31:0] value;
    value = crc ^ {24'd0, data};
    for (int unsigned i = 0; i < 8; i++) begin
      value = {1'b0, value[31:1]} ^ (value[0] ? CrcPolynomial : 32'd0);
    end
    return value;
  endfunction

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) crc_o <= '1;
    else if (start_i) crc_o <= '1;
    else if (valid_i) crc_o <= after_byte(crc_o, data_i);
  end

endmodule
