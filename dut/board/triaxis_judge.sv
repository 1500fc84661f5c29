// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what a frame is answered with, in the order that triaxis_board_pkg gives, all but the
// range of LOAD's coordinates. The HELLO of the board's own session is a command like others: an old
// one that comes again is refused. A repeat is not judged again, but must still be of the right length;
// what RESULTS asks for must be in the ring.
// Widths: a LOAD of 255 triangles of 36 bytes and its fields have 9,184 bytes: 14 bits. Counts up to
// Depth <= 32,768: 16 bits; with another LoadMax triangles 17 bits.
// Latency: combinational.

module triaxis_judge
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096
) (
    input byte_t command_i,
    input logic [8*FieldBytes-1:0] fields_i,
    input logic [7:0] payload_bytes_i,
    // Session.
    input logic nobody_i,
    input logic mine_i,
    input logic alive_i,
    input logic next_i,
    input logic repeat_i,
    // State.
    input logic busy_i,
    input logic [15:0] count_a_i,
    input logic [15:0] count_b_i,
    input logic [31:0] freed_i,
    input logic [31:0] written_i,
    output code_e code_o
);

  localparam int unsigned TriangleBytes = 9 * ((W + 7) / 8);

  logic is_hello, is_known;
  assign is_hello = command_i == CmdHello;
  assign is_known = command_i >= CmdHello && command_i <= CmdAbort;

  // --- Length ---------------------------------------------------------------------------------------

  byte_t load_triangles;
  logic [13:0] load_bytes, wanted_bytes;
  assign load_triangles = fields_i[31:24];
  assign load_bytes = 14'(LoadFieldBytes) + {6'd0, load_triangles} * 14'(TriangleBytes);
  always_comb begin
    case (command_i)
      CmdLoad: wanted_bytes = load_bytes;
      CmdRun: wanted_bytes = 14'(RunBytes);
      CmdResults: wanted_bytes = 14'(ResultsBytes);
      default: wanted_bytes = '0;
    endcase
  end

  // --- Values and places ----------------------------------------------------------------------------

  logic [15:0] first, held;
  logic [16:0] after_load;
  assign first = fields_i[23:8];
  assign held = fields_i[0] ? count_b_i : count_a_i;
  assign after_load = {1'b0, first} + 17'(load_triangles[$clog2(LoadMax+1)-1:0]);

  run_fields_t run;
  logic load_value, run_value, results_value;
  assign load_value = fields_i[7:1] == '0 && load_triangles != '0 && load_triangles <= 8'(LoadMax);
  assign run = fields_i[0+:$bits(run)];
  logic [2:0] fits;
  logic [Zones-1:0] narrow;
  for (genvar k = 0; k < 3; k++) begin : g_pose
    // The sign and all above it; at W = 32 the sign alone, and all poses fit.
    logic signed [31:0] top;
    assign top = $signed(run.pose[k]) >>> W;
    assign fits[k] = top == '0 || top == '1;
  end
  for (genvar z = 0; z < Zones; z++) begin : g_margin
    assign narrow[z] = (run.margins[z] >> M) == '0;
  end
  assign run_value = run.mode <= 8'(ModeCount) && narrow == '1 && fits == '1;
  assign results_value = fields_i[31:0] - freed_i <= written_i - freed_i;

  code_e load_code, run_code, command_code;
  always_comb begin
    if (!load_value) load_code = CodeValue;
    else if (first != '0 && first != held) load_code = CodePlace;
    else if (after_load > 17'(Depth)) load_code = CodeOverfull;
    else load_code = CodeOk;

    if (!run_value) run_code = CodeValue;
    else if (run.count_a != count_a_i || run.count_b != count_b_i) run_code = CodeCounts;
    else if (count_a_i == '0 || count_b_i == '0) run_code = CodeEmpty;
    else run_code = CodeOk;

    case (command_i)
      CmdLoad: command_code = busy_i ? CodeBusy : load_code;
      CmdRun:  command_code = busy_i ? CodeBusy : run_code;
      default: command_code = CodeOk;
    endcase
  end

  // --- Verdict --------------------------------------------------------------------------------------

  always_comb begin
    if (is_hello && nobody_i) code_o = CodeValue;
    else if (!mine_i && (!is_hello || alive_i)) code_o = CodeSession;
    else if (!is_known) code_o = CodeUnknown;
    else if (mine_i && !next_i && !repeat_i) code_o = CodeSequence;
    else if (14'(payload_bytes_i) != wanted_bytes) code_o = CodeLength;
    else if (command_i == CmdResults && !results_value) code_o = CodeValue;
    else if (repeat_i) code_o = CodeOk;
    else code_o = command_code;
  end

  // Any will do.
  logic [$bits(trial_t)+$bits(hold_t)-1:0] unused_run;
  assign unused_run = {run.trial, run.hold};

endmodule
