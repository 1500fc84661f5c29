// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The board Nexys 4 DDR (XC7A100T-1CSG324C): the mesh engine behind a serial line, and the outputs
// go, stop, beat, and what is beyond a zone. See triaxis_board_pkg for the line, triaxis_safety and
// triaxis_beat for the outputs.
// LEDs, from the right: 0 go, 1 stop, 2 a run is going on, 3 a host is there, 4 near pairs are
// waiting, 5 the ring of near pairs is full, 6 the watchdog has run out, 7 something went wrong
// since the last HELLO or RUN, 8..15 errors on the link, low bits.
// What permits the machine to move is there twice: the runs, the watchdog, the decision of go; and checked, as
// the engine is: see triaxis_mesh. A check that fails is a fault, and no go, until the next HELLO. A run can
// try each check, see trial_t.
// Latency: one clock, 100 MHz.

module nexys4ddr_top
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,  // coordinate bits, 8..32
    parameter int unsigned M = 16,  // margin bits, 0..W
    parameter int unsigned Depth = 4096,  // as in triaxis_mesh, at most 32,768
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    parameter bit Certify = 1'b1,  // as in triaxis_mesh
    parameter int unsigned ClocksPerThreeBits = 25,  // 12,000,000 baud
    parameter int unsigned WatchdogClocks = 10_000_000,  // 100 ms
    parameter int unsigned HoldClocks = ClocksPerMs,  // of a run's hold: 1 ms
    parameter int unsigned BeatClocks = 50_000,  // 1 kHz
    parameter int unsigned DigitClocks = 12_500,  // the displays are scanned in 1 ms
    parameter logic [31:0] BuildId = '0  // first bits of a hash of everything in the bitstream
) (
    input logic clk_100mhz_i,
    input logic cpu_reset_ni,
    input logic uart_rx_i,
    output logic uart_tx_o,
    output logic [15:0] led_o,
    output logic [7:0] seg_no,
    output logic [7:0] an_no,
    output logic go_o,
    output logic stop_o,
    output logic beat_o,
    output logic beyond_slow_o,
    output logic beyond_warn_o
);

  localparam int unsigned IndexWidth = $clog2(Depth);
  localparam int unsigned GroupPairWidth = 2 * $clog2(Depth / Group) + 1;
  localparam int unsigned PairCountWidth = 2 * IndexWidth + 1;
  localparam int unsigned WatchdogMs = watchdog_ms(WatchdogClocks);
  localparam hello_block_t Hello = '{
      version: ProtocolVersion,
      w: 8'(W),
      m: 8'(M),
      depth: 16'(Depth),
      group: 8'(Group),
      lanes: 8'(Lanes),
      build_id: BuildId,
      watchdog_ms: 16'(WatchdogMs),
      certifies: 8'(Certify)
  };

  if (Depth > 32768) begin : g_bad_depth
    $fatal(1, "Depth must be at most 32,768: counts of triangles have 16 bits on the link");
  end
  if (HoldClocks == 0) begin : g_bad_hold
    $fatal(1, "HoldClocks must be at least 1");
  end
  if (WatchdogClocks == 0) begin : g_bad_watchdog
    $fatal(1, "WatchdogClocks must be at least 1");
  end

  logic rst_n;

  triaxis_reset_sync u_reset (
      .clk_i(clk_100mhz_i),
      .button_ni(cpu_reset_ni),
      .rst_no(rst_n)
  );

  // --- Commands -------------------------------------------------------------------------------------

  logic frame_full, frame_release, frame_broken, link_error, trying_frame;
  logic [$clog2(MaxFrameBytes)-1:0] frame_length;
  logic [$clog2(MaxFrameBytes)-1:0] frame_address;
  byte_t frame_data;

  triaxis_receiver #(
      .ClocksPerThreeBits(ClocksPerThreeBits)
  ) u_receiver (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .line_i(uart_rx_i),
      .full_o(frame_full),
      .length_o(frame_length),
      .address_i(frame_address),
      .data_o(frame_data),
      .release_i(frame_release),
      .trial_i(trying_frame),
      .broken_o(frame_broken),
      .error_o(link_error)
  );

  logic hello, load, free, abort, refused, foreign, kick, forget;
  // As it was asked, and as it was asked all the same: each of what decides twice has its own.
  logic [1:0] run;
  request_t [1:0] request;
  logic expired, busy, reply_valid, reply_ready;
  logic [1:0] alive;
  logic [IndexWidth:0] count_a, count_b;
  logic [1:0][31:0] signatures;
  logic [31:0] ring_freed, ring_written;
  code_e code;
  sequence_t expected;
  logic load_tvalid, load_tready;
  logic [9*W-1:0] load_tdata;
  logic [1:0] load_tuser;

  triaxis_command #(
      .W(W),
      .M(M),
      .Depth(Depth)
  ) u_command (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .full_i(frame_full),
      .length_i(frame_length),
      .address_o(frame_address),
      .data_i(frame_data),
      .release_o(frame_release),
      .alive_i(alive[0]),
      .busy_i(busy),
      .count_a_i(16'(count_a)),
      .count_b_i(16'(count_b)),
      .freed_i(ring_freed),
      .written_i(ring_written),
      .hello_o(hello),
      .load_o(load),
      .run_o(run),
      .free_o(free),
      .abort_o(abort),
      .refused_o(refused),
      .foreign_o(foreign),
      .kick_o(kick),
      .forget_o(forget),
      .request_o(request),
      .reply_ready_i(reply_ready),
      .reply_o(reply_valid),
      .code_o(code),
      .expected_o(expected),
      .load_tvalid_o(load_tvalid),
      .load_tready_i(load_tready),
      .load_tdata_o(load_tdata),
      .load_tuser_o(load_tuser)
  );

  // A session, or a run, begins; one ends before its time.
  logic begins, cut;
  assign begins = hello || run != '0;
  assign cut = abort || hello;

  logic [1:0] silences;
  for (genvar i = 0; i < 2; i++) begin : g_watchdog
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_watchdog #(
        .Clocks(WatchdogClocks)
    ) u_watchdog (
        .clk_i(clk_100mhz_i),
        .rst_ni(rst_n),
        .kick_i(kick),
        .forget_i(begins),
        .alive_o(alive[i]),
        .expired_o(silences[i])
    );
  end
  assign expired = silences != '0;

  // --- Runs -----------------------------------------------------------------------------------------

  logic aborting, run_tvalid, near_tvalid, near_tready, done, engine_fault, fault;
  logic [3*move_width(W)-1:0] run_tdata;
  logic [run_user_width(M)-1:0] run_tuser;
  logic [2*IndexWidth-1:0] near_tdata;
  status_e done_status;
  logic [31:0] cycles;
  logic [GroupPairWidth-1:0] groups_skipped, groups_opened;
  logic [PairCountWidth-1:0] pairs_skipped, tested, near_count;
  logic [Zones-1:1] zones;

  summary_t summary, done_summary;
  status_e engine_status, shown_status;
  run_state_e run_state;
  logic [1:0] run_mode;
  status_block_t status;
  trial_t trial;

  // Of the second only what it shows is looked at.
  typedef struct packed {
    logic busy;
    logic aborting;
    byte_t number;
    run_state_e state;
    logic [1:0] mode;
    pose_t run_pose;
    logic [31:0] margin;
    trial_t trial;
    hold_t hold;
    status_e engine_status;
    logic [Zones-1:1] zones;
    summary_t summary;
    logic tvalid;
    logic [3*move_width(W)-1:0] tdata;
    logic [run_user_width(M)-1:0] tuser;
  } run_t;
  run_t runs[2];
  logic [RunnerSeenWidth-1:0] runner_seen[2], misread;

  for (genvar i = 0; i < 2; i++) begin : g_runner
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_runner #(
        .W(W),
        .M(M)
    ) u_runner (
        .clk_i(clk_100mhz_i),
        .rst_ni(rst_n),
        .forget_i(forget),
        .run_i(run[i]),
        .abort_i(cut),
        .fields_i(request[i].fields),
        .busy_o(runs[i].busy),
        .aborting_o(runs[i].aborting),
        .run_number_o(runs[i].number),
        .run_state_o(runs[i].state),
        .run_mode_o(runs[i].mode),
        .run_pose_o(runs[i].run_pose),
        .run_margin_o(runs[i].margin),
        .run_trial_o(runs[i].trial),
        .run_hold_o(runs[i].hold),
        .engine_status_o(runs[i].engine_status),
        .zones_o(runs[i].zones),
        .summary_o(runs[i].summary),
        .run_tvalid_o(runs[i].tvalid),
        .run_tdata_o(runs[i].tdata),
        .run_tuser_o(runs[i].tuser),
        .done_tvalid_i(done),
        .done_status_i(done_status),
        .done_zones_i(zones),
        .done_summary_i(done_summary),
        .seen_o(runner_seen[i])
    );
  end

  assign busy = runs[0].busy;
  assign aborting = runs[0].aborting;
  assign run_state = runs[0].state;
  assign run_mode = runs[0].mode;
  assign trial = runs[0].trial;
  assign engine_status = runs[0].engine_status;
  assign summary = runs[0].summary;
  assign run_tvalid = runs[0].tvalid;
  assign run_tdata = runs[0].tdata;
  assign run_tuser = runs[0].tuser;
  assign status.run_number = runs[0].number;
  assign status.pose = runs[0].run_pose;
  assign status.margin = runs[0].margin;
  logic unused_run;
  assign unused_run = ^runs[1];

  assign done_summary = '{
          cycles: cycles,
          groups_skipped: 32'(groups_skipped),
          groups_opened: 32'(groups_opened),
          pairs_skipped: 32'(pairs_skipped),
          tested: 32'(tested),
          near_count: 32'(near_count)
      };

  // The runner knows of a run before the engine does. A mesh that was given too much is found by
  // the engine: the run ends so.
  typedef struct packed {
    logic busy;
    logic ready;
    logic overfull_b;
    logic overfull_a;
  } unused_t;
  unused_t unused;

  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes),
      .Certify(Certify)
  ) u_mesh (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .s_axis_load_tvalid_i(load_tvalid),
      .s_axis_load_tready_o(load_tready),
      .s_axis_load_tdata_i(load_tdata),
      .s_axis_load_tuser_i(load_tuser),
      .count_a_o(count_a),
      .count_b_o(count_b),
      .overfull_o({unused.overfull_b, unused.overfull_a}),
      .signature_a_o(signatures[0]),
      .signature_b_o(signatures[1]),
      .s_axis_run_tvalid_i(run_tvalid),
      .s_axis_run_tready_o(unused.ready),
      .s_axis_run_tdata_i(run_tdata),
      .s_axis_run_tuser_i(run_tuser),
      .abort_i(aborting),
      .busy_o(unused.busy),
      .m_axis_near_tvalid_o(near_tvalid),
      .m_axis_near_tready_i(near_tready),
      .m_axis_near_tdata_o(near_tdata),
      .m_axis_done_tvalid_o(done),
      .m_axis_done_tready_i(1'b1),
      .status_o(done_status),
      .cycles_o(cycles),
      .group_pairs_skipped_o(groups_skipped),
      .group_pairs_opened_o(groups_opened),
      .pairs_skipped_o(pairs_skipped),
      .tested_o(tested),
      .near_o(near_count),
      .zones_o(zones),
      .acknowledge_i(hello),
      .fault_o(engine_fault)
  );

  // --- Faults ---------------------------------------------------------------------------------------

  // Of the board itself: two runners that differ, a frame that is not as it came.
  logic trying_runner, runners_differ, board_fault_q;
  assign trying_frame  = busy && trial.kind == TrialBoard && trial.which == '1;
  assign trying_runner = busy && trial.kind == TrialBoard && trial.which != '1;
  for (genvar i = 0; i < RunnerSeenWidth; i++) begin : g_misread
    assign misread[i] = trying_runner && 5'(i % 31) == trial.which;
  end
  assign runners_differ = runner_seen[0] != (runner_seen[1] ^ misread);
  always_ff @(posedge clk_100mhz_i or negedge rst_n) begin
    if (!rst_n) board_fault_q <= 1'b0;
    else board_fault_q <= runners_differ || frame_broken || (board_fault_q && !hello);
  end
  assign fault = engine_fault || board_fault_q;

  logic ring_clear, ring_full;
  logic [31:0] ring_number;
  logic [2*IndexWidth-1:0] ring_data;

  assign ring_clear = run != '0 || forget;

  triaxis_near_ring #(
      .Width(2 * IndexWidth)
  ) u_ring (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .clear_i(ring_clear),
      .drop_i(aborting),
      .free_i(free),
      .freed_o(ring_freed),
      .written_o(ring_written),
      .full_o(ring_full),
      .tvalid_i(near_tvalid),
      .tready_o(near_tready),
      .tdata_i(near_tdata),
      .number_i(ring_number),
      .data_o(ring_data)
  );

  // --- Replies --------------------------------------------------------------------------------------

  logic [11:0] errors;
  triaxis_saturating_counter #(
      .Width($bits(errors))
  ) u_errors (
      .clk_i  (clk_100mhz_i),
      .rst_ni (rst_n),
      .one_i  (link_error),
      .other_i(foreign),
      .count_o(errors)
  );

  assign status.errors = 16'(errors);
  assign status.count_b = 16'(count_b);
  assign status.count_a = 16'(count_a);
  assign status.summary = summary;
  assign status.flags = '{
          none: '0,
          zones: runs[0].zones,
          fault: fault,
          expired: expired,
          waiting: ring_written != ring_freed,
          go: go_o
      };
  assign status.mode = 8'(run_mode);
  assign shown_status = (fault && engine_status != StatusNone) ? StatusFault : engine_status;
  assign status.engine_status = 8'(shown_status);
  assign status.state = 8'(run_state);

  reply_t reply;
  body_bytes_t body_bytes;
  near_pairs_t reply_pairs;
  logic [31:0] first_pair;

  triaxis_answer #(
      .Hello(Hello)
  ) u_answer (
      .request_i(request[0]),
      .code_i(code),
      .expected_i(expected),
      .status_i(status),
      .signatures_i(signatures),
      .hold_i(runs[0].hold),
      .written_i(ring_written),
      .reply_o(reply),
      .body_bytes_o(body_bytes),
      .pairs_o(reply_pairs),
      .first_pair_o(first_pair)
  );

  triaxis_transmitter #(
      .IndexWidth(IndexWidth),
      .ClocksPerThreeBits(ClocksPerThreeBits)
  ) u_transmitter (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .valid_i(reply_valid),
      .ready_o(reply_ready),
      .reply_i(reply),
      .body_bytes_i(body_bytes),
      .pairs_i(reply_pairs),
      .first_pair_i(first_pair),
      .ring_number_o(ring_number),
      .ring_data_i(ring_data),
      .line_o(uart_tx_o)
  );

  // --- Outputs --------------------------------------------------------------------------------------

  // A run that leaves go as it is until its end: its hold is the last of its fields.
  logic [1:0] keep;

  logic [1:0] says_go, says_stop;
  logic [1:0][Zones-1:1] says_beyond;
  for (genvar i = 0; i < 2; i++) begin : g_safety
    assign keep[i] = request[i].fields[8*RunBytes-1-:$bits(hold_t)] != '0;
    (* keep_hierarchy = "yes", dont_touch = "yes" *)
    triaxis_safety #(
        .NearWidth (PairCountWidth),
        .HoldClocks(HoldClocks)
    ) u_safety (
        .clk_i(clk_100mhz_i),
        .rst_ni(rst_n),
        .hello_i(hello),
        .load_i(load),
        .run_i(run[i]),
        .keep_i(keep[i]),
        .abort_i(abort),
        .link_error_i(link_error),
        .refused_i(refused),
        .alive_i(alive[i]),
        .fault_i(fault),
        .done_i(done),
        .engine_status_i(done_status),
        .near_i(near_count),
        .zones_i(zones),
        .hold_i(runs[i].hold),
        .go_o(says_go[i]),
        .stop_o(says_stop[i]),
        .beyond_o(says_beyond[i])
    );
  end
  assign go_o = says_go[0];
  assign stop_o = says_stop[1];
  assign {beyond_warn_o, beyond_slow_o} = says_beyond[0] & says_beyond[1];
  logic unused_said;
  assign unused_said = ^{says_go[1], says_stop[0]};

  triaxis_beat #(
      .Clocks(BeatClocks)
  ) u_beat (
      .clk_i (clk_100mhz_i),
      .rst_ni(rst_n),
      .go_i  (go_o),
      .beat_o
  );

  logic wrong_q, shown_wrong;
  always_ff @(posedge clk_100mhz_i or negedge rst_n) begin
    if (!rst_n) wrong_q <= 1'b0;
    else if (link_error || refused) wrong_q <= 1'b1;
    else if (begins) wrong_q <= 1'b0;
  end
  assign shown_wrong = wrong_q || expired || fault;

  triaxis_display #(
      .DigitClocks(DigitClocks)
  ) u_display (
      .clk_i(clk_100mhz_i),
      .rst_ni(rst_n),
      .go_i(go_o),
      .running_i(busy),
      .error_i(shown_wrong),
      .near_i(summary.near_count),
      .seg_no,
      .an_no
  );

  assign led_o = {
    status.errors[7:0],
    wrong_q || fault,
    expired,
    ring_full,
    status.flags.waiting,
    alive[0],
    busy,
    stop_o,
    go_o
  };

endmodule
