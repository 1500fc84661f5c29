// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What a request is answered with: the head and the payload that the protocol gives that answer,
// the payload again inverted, the near pairs of the ring from the number asked for, the CRC-32 over
// all of it (that of the definition: shown by `board_frame`), and nothing else. One byte of the head
// and payload, of any place, and one near pair, of any number, chosen once by the prover, are
// followed. And a byte is offered in every clock, or in the one after it, until all are sent.

`include "triaxis_formal.svh"

module triaxis_reply_formal
  import triaxis_board_pkg::*;
#(
    parameter int unsigned IndexWidth = 12
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    input logic taken_i,
    input request_t request_i,
    input code_e code_i,
    input sequence_t expected_i,
    input status_block_t status_i,
    input logic [1:0][31:0] signatures_i,
    input hold_t hold_i,
    input logic [31:0] written_i,
    input logic [2*IndexWidth-1:0] ring_data_i
);

  // No two bytes of it are the same.
  localparam hello_block_t Hello = 112'h07_3132_2A2B_2C2D_17_18_0C0D_05_06_01;
  typedef logic [8:0] count_t;
  typedef logic [6:0] place_t;

  reply_t reply;
  body_bytes_t body_bytes;
  near_pairs_t pairs;
  logic [31:0] first_pair, ring_number_o;
  logic ready_o, valid_o, last_o;
  byte_t data_o;

  triaxis_answer #(
      .Hello(Hello)
  ) u_answer (
      .reply_o(reply),
      .body_bytes_o(body_bytes),
      .pairs_o(pairs),
      .first_pair_o(first_pair),
      .*
  );

  triaxis_reply #(
      .IndexWidth(IndexWidth)
  ) u_reply (
      .reply_i(reply),
      .body_bytes_i(body_bytes),
      .pairs_i(pairs),
      .first_pair_i(first_pair),
      .*
  );

  `TRIAXIS_RESET_FIRST

  // --- What the protocol has the reply be -----------------------------------------------------------

  logic paid, all_taken;
  count_t due_pairs, due_bytes;
  logic [31:0] from, held;
  assign from = request_i.fields[31:0];
  assign held = written_i - from;
  assign paid = code_i == CodeOk || (code_i == CodePlace && request_i.command == CmdLoad);
  assign due_pairs = (request_i.command != CmdResults) ? '0 : (held > 32'd32) ? 9'd32 : 9'(held);

  always_comb begin
    due_bytes = '0;
    if (code_i == CodeSequence) due_bytes = 9'd4;
    else if (paid)
      case (request_i.command)
        CmdHello: due_bytes = 9'd14;
        CmdLoad: due_bytes = 9'd6;
        CmdRun: due_bytes = 9'd3;
        CmdResults: due_bytes = 9'd56;
        default: due_bytes = 9'd51;
      endcase
  end

  function automatic byte_t byte_of(logic [31:0] number, place_t place);
    return number[8*place[1:0]+:8];
  endfunction

  function automatic byte_t status_byte(place_t place);
    case (place)
      7'd0: return status_i.run_number;
      7'd1: return status_i.state;
      7'd2: return status_i.engine_status;
      7'd3: return status_i.flags;
      7'd4: return status_i.mode;
      7'd45, 7'd46: return byte_of(32'(status_i.errors), place - 7'd45);
      7'd47, 7'd48: return byte_of(32'(status_i.count_a), place - 7'd47);
      7'd49, 7'd50: return byte_of(32'(status_i.count_b), place - 7'd49);
      7'd55: return byte_t'(due_pairs);
      default: ;
    endcase
    if (place < 7'd17) begin
      return byte_of(status_i.pose[(place<7'd9)?0 : (place<7'd13)?1 : 2], place - 7'd5);
    end
    if (place < 7'd21) return byte_of(status_i.margin, place - 7'd17);
    if (place < 7'd25) return byte_of(status_i.summary.cycles, place - 7'd21);
    if (place < 7'd29) return byte_of(status_i.summary.groups_skipped, place - 7'd25);
    if (place < 7'd33) return byte_of(status_i.summary.groups_opened, place - 7'd29);
    if (place < 7'd37) return byte_of(status_i.summary.pairs_skipped, place - 7'd33);
    if (place < 7'd41) return byte_of(status_i.summary.tested, place - 7'd37);
    if (place < 7'd45) return byte_of(status_i.summary.near_count, place - 7'd41);
    return byte_of(from, place - 7'd51);
  endfunction

  function automatic byte_t payload_byte(place_t place);
    if (code_i == CodeSequence) return byte_of(expected_i, place);
    case (request_i.command)
      CmdHello: return Hello[8*place+:8];
      CmdLoad: begin
        if (place < 7'd2)
          return byte_of(32'(request_i.fields[0] ? status_i.count_b : status_i.count_a), place);
        return byte_of(request_i.fields[0] ? signatures_i[1] : signatures_i[0], place - 7'd2);
      end
      CmdRun:   return place == 7'd0 ? status_i.run_number : byte_of(32'(hold_i), place - 7'd1);
      default:  return status_byte(place);
    endcase
  endfunction

  function automatic byte_t first_byte(place_t place);
    if (place == 7'd0) return {1'b1, request_i.command[6:0]};
    if (place < 7'd5) return byte_of(request_i.sequence_number, place - 7'd1);
    if (place < 7'd9) return byte_of(request_i.session, place - 7'd5);
    if (place == 7'd9) return code_i;
    return payload_byte(place - 7'd10);
  endfunction

  // --- What was sent --------------------------------------------------------------------------------

  place_t place_q;  // of the byte that is followed, in head and payload
  logic [31:0] number_q, past_number_q;  // of the near pair that is
  logic [2*IndexWidth-1:0] pair_q;
  always_ff @(posedge clk_i) begin
    place_q <= place_q;
    number_q <= number_q;
    pair_q <= pair_q;
    past_number_q <= ring_number_o;
  end

  count_t sent_q, bytes_q, pairs_q;
  logic [31:0] first_q;
  byte_t followed_q;
  count_t inverted_from, pairs_from, crc_from, whole;
  assign inverted_from = 9'(ReplyHeadBytes) + bytes_q;
  assign pairs_from = inverted_from + bytes_q;
  assign crc_from = pairs_from + (pairs_q << 2);
  assign whole = crc_from + 9'(CrcBytes);
  assign all_taken = taken_i && sent_q == whole - 9'd1;

  logic going_q, waited_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) going_q <= 1'b0;
    else if (ready_o) going_q <= valid_i;
    else if (all_taken) going_q <= 1'b0;
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) waited_q <= 1'b0;
    else waited_q <= going_q && !valid_o;
  end
  always_ff @(posedge clk_i) begin
    if (ready_o) begin
      sent_q <= '0;
      bytes_q <= due_bytes;
      pairs_q <= code_i == CodeOk ? due_pairs : '0;
      first_q <= from;
      followed_q <= first_byte(place_q);
    end else if (taken_i) begin
      sent_q <= sent_q + 9'd1;
    end
  end

  logic in_head, in_inverted, in_pairs, in_crc;
  logic [31:0] own_crc, crc;
  triaxis_crc32 u_own_crc (
      .start_i(ready_o),
      .valid_i(taken_i && !in_crc),
      .data_i (data_o),
      .crc_o  (own_crc),
      .*
  );
  assign crc = ~own_crc;

  // The byte that is due, where it is one of those that are followed.
  count_t followed, inverted, nth, crc_byte;
  logic [31:0] pair_word;
  assign followed = 9'(place_q);
  assign inverted = inverted_from + followed - 9'(ReplyHeadBytes);
  assign nth = sent_q - pairs_from;
  assign crc_byte = sent_q - crc_from;
  assign pair_word = {16'(pair_q[IndexWidth+:IndexWidth]), 16'(pair_q[IndexWidth-1:0])};
  assign in_head = sent_q < inverted_from;
  assign in_inverted = !in_head && sent_q < pairs_from;
  assign in_pairs = sent_q >= pairs_from && sent_q < crc_from;
  assign in_crc = sent_q >= crc_from && sent_q < whole;

  // Of the states Idle, Bytes, Next, Crc.
  logic sending, next, ending, chosen;
  assign sending = u_reply.state_q == 2'd1;
  assign next = u_reply.state_q == 2'd2;
  // Of the payload that is to follow inverted.
  logic again_is_due;
  always_comb begin
    again_is_due = 1'b1;
    for (int b = 0; b < int'(BodyBytes); b++) begin
      if (followed == 9'd10 + 9'(b) && 8'(u_reply.again_q >> 8 * b) != followed_q) begin
        again_is_due = 1'b0;
      end
    end
  end
  assign ending = u_reply.state_q == 2'd3;
  assign chosen = first_q + 32'(nth[8:2]) == number_q;

  always_comb begin
    TakenIfValid : assume (!taken_i || valid_o);
    // The judge: shown by `board_go`.
    PlaceOfLoad : assume (code_i != CodePlace || request_i.command == CmdLoad);
    OkIfKnown : assume (code_i != CodeOk || request_i.command inside {[CmdHello : CmdAbort]});
    Followed : assume (place_q < 7'(ReplyHeadBytes + BodyBytes));
    Ring : assume (past_number_q != number_q || ring_data_i == pair_q);
    if (rst_ni) begin
      OneAtATime : assert (ready_o == !going_q);
      NothingElse : assert (!valid_o || (going_q && sent_q < whole));
      KeepsOffering : assert (!going_q || valid_o || !waited_q);
      EndsInTime : assert (!valid_o || last_o == (sent_q == whole - 9'd1));
      AsDue :
      assert (!valid_o || followed >= inverted_from || sent_q != followed || data_o == followed_q);
      AgainInverted :
      assert (!valid_o || followed < 9'(ReplyHeadBytes) || followed >= inverted_from ||
              sent_q != inverted || data_o == ~followed_q);
      NearPair : assert (!valid_o || !in_pairs || !chosen || data_o == byte_of(pair_word, 7'(nth)));
      OwnCrc : assert (!valid_o || !in_crc || data_o == byte_of(crc, 7'(crc_byte)));
      SeenAll : cover (all_taken && pairs_q == 9'd32);
      SeenRefusal : cover (all_taken && bytes_q == '0);
      SeenInverted : cover (valid_o && in_inverted && sent_q == inverted && followed == 9'd65);
      SeenPair : cover (taken_i && in_pairs && chosen && nth == 9'd127);
      // What makes it inductive.
      assert (!going_q || (bytes_q <= 9'd56 && pairs_q <= 9'd32 && sent_q < whole));
      if (going_q) begin
        assert (sending || next || ending);
        assert (ending == (in_crc && !next));
        assert (!next || sent_q == inverted_from || sent_q == pairs_from ||
                (in_pairs && nth[1:0] == '0) || sent_q == crc_from);
        assert (!sending || in_head || in_inverted || in_pairs);
        assert (in_crc && !next || u_reply.crc == own_crc);
        // The head and the payload.
        assert (!in_head || (sending && 9'(u_reply.left_q) == inverted_from - sent_q));
        assert (!in_head || followed < sent_q || followed >= inverted_from ||
                u_reply.bytes_q[8*(followed-sent_q)+:8] == followed_q);
        assert (!in_head && !(next && sent_q == inverted_from) ||
                (9'(u_reply.again_bytes_q) == bytes_q &&
                 (followed < 9'd10 || followed >= inverted_from || again_is_due)));
        assert (sent_q > pairs_from || (in_pairs && sending) ||
                (9'(u_reply.pairs_q) == pairs_q && u_reply.number_q == first_q));
        assert (sent_q == '0 || sent_q > pairs_from || (in_pairs && sending) ||
                past_number_q == u_reply.number_q);
        // The payload inverted.
        assert (!in_inverted || (next && sent_q == inverted_from) ||
                (sending && 9'(u_reply.left_q) == pairs_from - sent_q));
        assert (in_head || (next && sent_q == inverted_from) || u_reply.again_bytes_q == '0);
        assert (!in_inverted || !sending || followed < 9'd10 || followed >= inverted_from ||
                inverted < sent_q || u_reply.bytes_q[8*(inverted-sent_q)+:8] == ~followed_q);
        // The near pairs.
        assert (!in_pairs || !sending || (9'(u_reply.left_q) == 9'd4 - 9'(nth[1:0]) &&
                 9'(u_reply.pairs_q) == pairs_q - 9'd1 - 9'(nth[8:2]) &&
                 u_reply.number_q == first_q + 32'd1 + 32'(nth[8:2]) &&
                 (nth[1:0] == '0 || past_number_q == u_reply.number_q)));
        assert (!in_pairs || !next || (9'(u_reply.pairs_q) == pairs_q - 9'(nth[8:2]) &&
                 u_reply.number_q == first_q + 32'(nth[8:2]) && past_number_q == u_reply.number_q));
        assert (!in_crc || u_reply.pairs_q == '0);
        for (int b = 0; b < 4; b++) begin
          assert (!in_pairs || !sending || !chosen || nth[1:0] > 2'(b) ||
                  u_reply.bytes_q[8*(b-int'(nth[1:0]))+:8] == byte_of(
              pair_word, 7'(b)
          ));
          // The CRC.
          assert (!in_crc || next || crc_byte[1:0] > 2'(b) ||
                  u_reply.bytes_q[8*(b-int'(crc_byte[1:0]))+:8] == byte_of(
              crc, 7'(b)
          ));
        end
        assert (!in_crc || next || 9'(u_reply.left_q) == whole - sent_q);
      end else begin
        assert (u_reply.state_q == 2'd0);
      end
    end
  end

endmodule
