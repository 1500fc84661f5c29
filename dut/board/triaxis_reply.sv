// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the bytes of a reply: what it is given at once, its body again with every bit inverted,
// then near pairs out of the ring, then the CRC over all. The body to be inverted has a register of its
// own: a fault in either shows.
// Widths: at most 10 + 2 * 56 + 32 * 4 + 4 = 254 bytes of the 256 that a frame may have.
// Latency: 1 clock to the first byte; a byte a clock but for one before the inverted body, a near
// pair and the CRC. The line takes longer for a byte: in that clock none is taken.

module triaxis_reply
  import triaxis_board_pkg::*;
#(
    parameter int unsigned IndexWidth = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    output logic ready_o,
    input reply_t reply_i,
    input body_bytes_t body_bytes_i,
    input near_pairs_t pairs_i,
    input logic [31:0] first_pair_i,
    // The ring: data of the number a clock before.
    output logic [31:0] ring_number_o,
    input logic [2*IndexWidth-1:0] ring_data_i,  // {index in B, index in A}
    // The frame.
    output logic valid_o,
    input logic taken_i,  // only while valid_o
    output byte_t data_o,
    output logic last_o
);

  typedef logic [$clog2(ReplyHeadBytes+BodyBytes+1)-1:0] left_t;
  typedef logic [8*ReplyHeadBytes+BodyBits-1:0] bytes_t;

  typedef enum logic [1:0] {
    Idle,
    Bytes,
    Next,
    Crc
  } state_e;

  state_e state_q;
  bytes_t bytes_q;
  logic [BodyBits-1:0] again_q;
  left_t left_q;
  body_bytes_t again_bytes_q;  // not yet handed to bytes_q
  near_pairs_t pairs_q;
  logic [31:0] number_q, crc;
  logic idle, last_byte;

  assign idle = state_q == Idle;
  assign ready_o = idle;
  assign valid_o = state_q == Bytes || state_q == Crc;
  assign data_o = bytes_q[7:0];
  assign last_byte = left_q == left_t'(1);
  assign last_o = state_q == Crc && last_byte;
  assign ring_number_o = number_q;

  triaxis_crc32 u_crc (
      .clk_i,
      .rst_ni,
      .start_i(idle),
      .valid_i(taken_i),
      .data_i (data_o),
      .crc_o  (crc)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= Idle;
    end else begin
      case (state_q)
        Idle: if (valid_i) state_q <= Bytes;
        Bytes: if (taken_i && last_byte) state_q <= Next;
        Next: state_q <= again_bytes_q == '0 && pairs_q == '0 ? Crc : Bytes;
        default: if (taken_i && last_byte) state_q <= Idle;
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    case (state_q)
      Idle: begin
        bytes_q <= reply_i;
        again_q <= reply_i.body;
        left_q <= left_t'(ReplyHeadBytes) + left_t'(body_bytes_i);
        again_bytes_q <= body_bytes_i;
        pairs_q <= pairs_i;
        number_q <= first_pair_i;
      end
      Next: begin
        again_bytes_q <= '0;
        // Beyond what is sent it may be anything.
        bytes_q <= ~bytes_t'(again_q);
        if (again_bytes_q != '0) begin
          left_q <= left_t'(again_bytes_q);
        end else if (pairs_q != '0) begin
          bytes_q[31:0] <= {
            16'(ring_data_i[IndexWidth+:IndexWidth]), 16'(ring_data_i[IndexWidth-1:0])
          };
          left_q <= left_t'(NearPairBytes);
          pairs_q <= pairs_q - near_pairs_t'(1);
          number_q <= number_q + 32'd1;
        end else begin
          bytes_q[31:0] <= ~crc;
          left_q <= left_t'(CrcBytes);
        end
      end
      default:
      if (taken_i) begin
        bytes_q <= bytes_q >> 8;
        left_q  <= left_q - left_t'(1);
      end
    endcase
  end

endmodule
