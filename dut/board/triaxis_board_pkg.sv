// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the board and its host have in common: framing, commands, codes, fields of replies.
//
// A frame on the line is SLIP (RFC 1055), with an END before and after. Unstuffed, numbers little
// endian, at most 256 bytes:
//   command u8 | sequence number u32 | session u32 | payload | CRC-32 over all before it
// A reply: command + 0x80, sequence number and session as in the frame, code u8, payload, the payload
// again with every bit inverted, near pairs (RESULTS alone), CRC-32. The host believes a payload only
// where both forms agree: a field that is altered in one of them, in whatever way, is no answer.
//
// Frames are judged in this order: a HELLO of session 0 (6), session (3), command (1), sequence number
// (4), length (2), a run that is going on (5), values (6), place (7, 8, 9, 10), coordinates (6).
// The sequence number counts commands that were executed: one that is refused does not use it up. A
// refusal has no payload, but for code 4 (u32: the number expected) and code 7 (what LOAD answers:
// the mesh held).
//
// The error counter counts frames with a bad CRC, bad stuffing, fewer than 13 or more than 256
// bytes; framing errors of the line; frames that arrive before the last one was taken; and frames
// of another session. It stays at 4,095. HELLO does not clear it.

package triaxis_board_pkg;

  typedef logic [7:0] byte_t;

  localparam byte_t ProtocolVersion = 8'd7;

  // --- Framing --------------------------------------------------------------------------------------

  localparam byte_t SlipEnd = 8'hC0;
  localparam byte_t SlipEsc = 8'hDB;
  localparam byte_t SlipEscEnd = 8'hDC;
  localparam byte_t SlipEscEsc = 8'hDD;

  localparam int unsigned MaxFrameBytes = 256;
  localparam int unsigned HeaderBytes = 9;
  localparam int unsigned CrcBytes = 4;

  // What the register of the CRC-32 holds after a frame and its own CRC.
  localparam logic [31:0] CrcResidue = 32'hDEBB_20E3;

  // --- Commands -------------------------------------------------------------------------------------

  typedef enum byte_t {
    CmdHello = 8'h01,
    CmdLoad = 8'h02,
    CmdRun = 8'h03,
    CmdResults = 8'h04,
    CmdStatus = 8'h05,
    CmdAbort = 8'h06
  } command_e;

  typedef enum byte_t {
    CodeOk = 8'd0,
    CodeUnknown = 8'd1,
    CodeLength = 8'd2,
    CodeSession = 8'd3,
    CodeSequence = 8'd4,
    CodeBusy = 8'd5,
    CodeValue = 8'd6,
    CodePlace = 8'd7,
    CodeCounts = 8'd8,
    CodeEmpty = 8'd9,
    CodeOverfull = 8'd10
  } code_e;

  // Fields of a payload, the longest being RUN's; LOAD's triangles come after its fields.
  localparam int unsigned FieldBytes = 32;
  localparam int unsigned LoadFieldBytes = 4;
  localparam int unsigned RunBytes = 32;
  localparam int unsigned ResultsBytes = 4;

  localparam int unsigned LoadMax = 12;  // triangles a frame
  localparam int unsigned NearMax = 32;  // near pairs a reply

  // So wide that no frame which a line keeps back can be one of the numbers that are due again.
  typedef logic [31:0] sequence_t;

  typedef struct packed {
    logic [8*FieldBytes-1:0] fields;  // payload, anything after its end
    logic [31:0] session;
    sequence_t sequence_number;
    byte_t command;
  } request_t;

  // --- Runs -----------------------------------------------------------------------------------------

  typedef enum logic [1:0] {
    RunNever = 2'd0,
    RunGoing = 2'd1,
    RunDone  = 2'd2
  } run_state_e;

  // What the engine says of a run; zeros of one that is going on.
  typedef struct packed {
    logic [31:0] near_count;
    logic [31:0] tested;
    logic [31:0] pairs_skipped;
    logic [31:0] groups_opened;
    logic [31:0] groups_skipped;
    logic [31:0] cycles;
  } summary_t;

  typedef logic [2:0][31:0] pose_t;  // z, y, x

  // For how long a run's end permits, in HoldClocks; 0: for as long as nothing ends it. See triaxis_safety.
  typedef logic [15:0] hold_t;

  // RUN's fields, the last first.
  typedef struct packed {
    hold_t hold;
    pose_t pose;
    triaxis_mesh_pkg::trial_t trial;
    logic [15:0] count_b;
    logic [15:0] count_a;
    logic [triaxis_mesh_pkg::Zones-1:0][31:0] margins;  // of the zones, the margin itself lowest
    byte_t mode;
  } run_fields_t;

  // What a RUN is answered.
  typedef struct packed {
    hold_t hold;
    byte_t number;
  } run_block_t;

  // Of what two runners must have alike: two bits of control, state, mode, margins, trial, pose, hold, number,
  // status, zones, summary.
  localparam int unsigned RunnerSeenWidth = 2 + $bits(
      run_state_e
  ) + 2 + 32 * triaxis_mesh_pkg::Zones + $bits(
      triaxis_mesh_pkg::trial_t
  ) + $bits(
      pose_t
  ) + $bits(
      hold_t
  ) + 8 + $bits(
      triaxis_mesh_pkg::status_e
  ) + (triaxis_mesh_pkg::Zones - 1) + $bits(
      summary_t
  );

  // --- Replies --------------------------------------------------------------------------------------

  typedef struct packed {
    logic [1:0] none;
    logic [triaxis_mesh_pkg::Zones-1:1] zones;  // zones_o of the last run, see triaxis_mesh
    logic fault;  // a check failed since the last HELLO
    logic expired;  // the watchdog has run out since the last HELLO or RUN
    logic waiting;  // near pairs are in the ring
    logic go;
  } flags_t;

  // Last field first: the first byte of a reply is the lowest.
  typedef struct packed {
    logic [15:0] count_b;
    logic [15:0] count_a;
    logic [15:0] errors;
    summary_t summary;
    logic [31:0] margin;
    pose_t pose;
    byte_t mode;
    flags_t flags;
    byte_t engine_status;
    byte_t state;
    byte_t run_number;
  } status_block_t;

  typedef struct packed {
    byte_t certifies;  // 1: each "clear" is shown again
    logic [15:0] watchdog_ms;
    logic [31:0] build_id;
    byte_t lanes;
    byte_t group;
    logic [15:0] depth;
    byte_t m;
    byte_t w;
    byte_t version;
  } hello_block_t;

  // The mesh that is held: triangles, and its signature, see triaxis_mesh_scrub.
  typedef struct packed {
    logic [31:0] signature;
    logic [15:0] count;
  } load_block_t;

  // The watchdog's time as HELLO gives it, rounded up; of at least one clock.
  localparam int unsigned ClocksPerMs = 100_000;
  function automatic int unsigned watchdog_ms(int unsigned clocks);
    return (clocks - 1) / ClocksPerMs + 1;
  endfunction

  localparam int unsigned StatusBytes = $bits(status_block_t) / 8;
  localparam int unsigned HelloBytes = $bits(hello_block_t) / 8;
  localparam int unsigned LoadBytes = $bits(load_block_t) / 8;
  localparam int unsigned BegunBytes = $bits(run_block_t) / 8;
  // Command, sequence number, session, code.
  localparam int unsigned ReplyHeadBytes = HeaderBytes + 1;
  localparam int unsigned BodyBytes = StatusBytes + 5;  // RESULTS: status, from, k; then the pairs
  localparam int unsigned BodyBits = 8 * (BodyBytes - 1) + $clog2(NearMax + 1);  // k ends it
  localparam int unsigned NearPairBytes = 4;

  // A reply: so many bytes of the body, the same inverted, then so many near pairs from the ring.
  typedef struct packed {
    logic [BodyBits-1:0] body;
    code_e code;
    logic [31:0] session;
    sequence_t sequence_number;
    byte_t command;
  } reply_t;
  typedef logic [$clog2(BodyBytes+1)-1:0] body_bytes_t;
  typedef logic [$clog2(NearMax+1)-1:0] near_pairs_t;

endpackage
