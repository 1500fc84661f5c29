// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what a request is answered with, from the present state.
// Latency: combinational.

module triaxis_answer
  import triaxis_board_pkg::*;
#(
    parameter hello_block_t Hello = '0
) (
    input request_t request_i,
    input code_e code_i,
    input sequence_t expected_i,
    input status_block_t status_i,
    input logic [1:0][31:0] signatures_i,
    input hold_t hold_i,
    input logic [31:0] written_i,
    output reply_t reply_o,
    output body_bytes_t body_bytes_o,
    output near_pairs_t pairs_o,
    output logic [31:0] first_pair_o
);

  localparam int unsigned PairBits = $clog2(NearMax);  // NearMax is a power of two

  logic [31:0] from, held;
  near_pairs_t pairs;
  logic many;
  load_block_t held_mesh;
  run_block_t begun;
  assign from = request_i.fields[31:0];
  assign held = written_i - from;
  assign many = held[31:PairBits] != '0;
  assign pairs = many ? near_pairs_t'(NearMax) : near_pairs_t'(held[PairBits-1:0]);
  assign held_mesh.count = request_i.fields[0] ? status_i.count_b : status_i.count_a;
  assign held_mesh.signature = signatures_i[request_i.fields[0]];
  assign begun = '{hold: hold_i, number: status_i.run_number};

  // Only the bytes that are sent count.
  logic [BodyBits-1:0] body;
  body_bytes_t body_bytes;
  always_comb begin
    body = {pairs, from, status_i};
    body_bytes = body_bytes_t'(StatusBytes);
    case (request_i.command)
      CmdHello: begin
        body[0+:$bits(Hello)] = Hello;
        body_bytes = body_bytes_t'(HelloBytes);
      end
      CmdLoad: begin
        body[0+:$bits(held_mesh)] = held_mesh;
        body_bytes = body_bytes_t'(LoadBytes);
      end
      CmdRun: begin
        body[0+:$bits(begun)] = begun;
        body_bytes = body_bytes_t'(BegunBytes);
      end
      CmdResults: body_bytes = body_bytes_t'(BodyBytes);
      default: ;
    endcase
    if (code_i == CodeSequence) begin
      body[0+:$bits(expected_i)] = expected_i;
      body_bytes = body_bytes_t'(4);
    end else if (code_i != CodeOk && code_i != CodePlace) begin
      body_bytes = '0;
    end
  end

  assign reply_o = '{
          body: body,
          code: code_i,
          session: request_i.session,
          sequence_number: request_i.sequence_number,
          command: {1'b1, request_i.command[6:0]}
      };
  assign body_bytes_o = body_bytes;
  assign pairs_o = (request_i.command == CmdResults && code_i == CodeOk) ? pairs : '0;
  assign first_pair_o = from;

  logic [8*FieldBytes-33:0] unused_fields;
  assign unused_fields = request_i.fields[8*FieldBytes-1:32];

endmodule
