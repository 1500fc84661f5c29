// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what the frames ask for, one after the other: judges a frame, has it executed, asks for
// the reply. Answers are functions of the state after the command, so a repeat, which is not
// executed again, gets the same answer as the lost one.
// What a run is asked with is kept twice, see triaxis_request. That a frame was judged just then, whole
// and good, is kept beside its code.
// Widths: see triaxis_board_pkg.
// Latency: HeaderBytes + FieldBytes + 3 clocks, and what LOAD, HELLO and ABORT take.

module triaxis_command
  import triaxis_board_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096
) (
    input logic clk_i,
    input logic rst_ni,
    // The frame.
    input logic full_i,
    input logic [$clog2(MaxFrameBytes)-1:0] length_i,
    output logic [$clog2(MaxFrameBytes)-1:0] address_o,
    input byte_t data_i,
    output logic release_o,
    // State that frames are judged by.
    input logic alive_i,
    input logic busy_i,
    input logic [15:0] count_a_i,
    input logic [15:0] count_b_i,
    input logic [31:0] freed_i,
    input logic [31:0] written_i,
    // A clock each: accepted commands, before anything is changed; what was answered.
    output logic hello_o,
    output logic load_o,
    output logic [1:0] run_o,  // of each copy
    output logic free_o,
    output logic abort_o,
    output logic refused_o,
    output logic foreign_o,  // refused, as of another session
    output logic kick_o,  // executed: a repeat, or what is refused, is no sign of life
    output logic forget_o,  // HELLO: the engine is idle, its meshes are empty
    output request_t [1:0] request_o,
    // The reply.
    input logic reply_ready_i,
    output logic reply_o,
    output code_e code_o,
    output sequence_t expected_o,
    // The engine's load stream.
    output logic load_tvalid_o,
    input logic load_tready_i,
    output logic [9*W-1:0] load_tdata_o,
    output logic [1:0] load_tuser_o
);

  localparam int unsigned RequestBytes = HeaderBytes + FieldBytes;
  typedef logic [$clog2(MaxFrameBytes)-1:0] address_t;
  typedef logic [$clog2(RequestBytes)-1:0] place_t;

  typedef enum logic [2:0] {
    Idle,
    Gather,
    Judge,
    Act,
    Load,
    HelloEnd,
    AbortEnd,
    Reply
  } state_e;

  state_e state_q;
  code_e code_q;
  place_t place_q;
  logic good_q;

  request_t request;
  assign request = request_o[0];

  code_e judged;
  logic gather, nobody, mine, next, repeated, execute, done;
  logic load_start, load_done, load_bad, load_accepted;
  address_t load_address;

  // --- The frame ------------------------------------------------------------------------------------

  address_t content_bytes;
  assign content_bytes = length_i - 8'(CrcBytes);
  assign address_o = state_q == Load ? load_address : address_t'(place_q);
  assign gather = state_q == Gather;

  always_ff @(posedge clk_i) begin
    if (gather) begin
      place_q <= place_q + place_t'(1);
    end else begin
      place_q <= '0;
    end
  end

  for (genvar i = 0; i < 2; i++) begin : g_request
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_request u_request (
        .clk_i,
        .gather_i (gather),
        .data_i,
        .execute_i(execute),
        .run_o    (run_o[i]),
        .request_o(request_o[i])
    );
  end

  // --- Verdict --------------------------------------------------------------------------------------

  triaxis_session u_session (
      .clk_i,
      .rst_ni,
      .session_i(request.session),
      .sequence_number_i(request.sequence_number),
      .command_i(request.command),
      .take_i(hello_o),
      .executed_i(done),
      .nobody_o(nobody),
      .mine_o(mine),
      .next_o(next),
      .repeat_o(repeated),
      .expected_o
  );

  triaxis_judge #(
      .W(W),
      .M(M),
      .Depth(Depth)
  ) u_judge (
      .command_i(request.command),
      .fields_i(request.fields),
      .payload_bytes_i(content_bytes - 8'(HeaderBytes)),
      .nobody_i(nobody),
      .mine_i(mine),
      .alive_i,
      .next_i(next),
      .repeat_i(repeated),
      .busy_i,
      .count_a_i,
      .count_b_i,
      .freed_i,
      .written_i,
      .code_o(judged)
  );

  assign execute = state_q == Act && good_q && code_q == CodeOk && !repeated;
  assign done = state_q == Reply && code_q == CodeOk;
  assign hello_o = execute && request.command == CmdHello;
  assign load_start = execute && request.command == CmdLoad;
  assign load_o = load_accepted;
  assign free_o = execute && request.command == CmdResults;
  assign abort_o = execute && request.command == CmdAbort;
  // A HELLO is a repeat of itself as soon as it has taken the board.
  assign kick_o = hello_o || (done && !repeated);
  assign reply_o = state_q == Reply;
  assign release_o = reply_o;
  assign refused_o = reply_o && code_q != CodeOk;
  assign foreign_o = reply_o && code_q == CodeSession;
  assign code_o = code_q;

  // --- Execution ------------------------------------------------------------------------------------

  // The engine takes no load during a run: a HELLO empties the meshes after the run that it ends.
  assign forget_o = state_q == HelloEnd && load_done;

  triaxis_loader #(
      .W(W)
  ) u_loader (
      .clk_i,
      .rst_ni,
      .empty_both_i(hello_o),
      .load_i(load_start),
      .mesh_i(request.fields[0]),
      .empty_first_i(request.fields[23:8] == '0),
      .triangles_i(request.fields[24+:$clog2(LoadMax+1)]),
      .accepted_o(load_accepted),
      .done_o(load_done),
      .bad_o(load_bad),
      .address_o(load_address),
      .data_i,
      .tvalid_o(load_tvalid_o),
      .tready_i(load_tready_i),
      .tdata_o(load_tdata_o),
      .tuser_o(load_tuser_o)
  );

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= Idle;
    end else begin
      case (state_q)
        Idle: if (full_i && reply_ready_i) state_q <= Gather;
        Gather: if (place_q == place_t'(RequestBytes - 1)) state_q <= Judge;
        Judge: state_q <= Act;
        Act: begin
          if (hello_o) state_q <= HelloEnd;
          else if (load_start) state_q <= Load;
          else if (abort_o) state_q <= AbortEnd;
          else state_q <= Reply;
        end
        Load, HelloEnd: if (load_done) state_q <= Reply;
        AbortEnd: if (!busy_i) state_q <= Reply;
        default: state_q <= Idle;
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    good_q <= state_q == Judge && place_q == place_t'(RequestBytes) && judged == CodeOk;
    if (state_q == Judge) code_q <= judged;
    else if (load_bad) code_q <= CodeValue;
  end

endmodule
