// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Go, on the board's own top: what it implies, in terms of the frames that were answered, of what
// the engine was given and said, and of clocks. The host's view is made of answered frames alone:
// whose the board is, the next number, the meshes, the pose and the run that were acknowledged. The
// engine's view is made of its streams alone. See triaxis_board_surroundings for what stands around
// the board. Whatever permits the machine to move is there twice, and the two do the same here: that each
// permits nothing on its own, whatever the other does, is `board_twice`.
//
// Meshes are followed by one byte of one triangle, of any mesh, number and place, chosen once by
// the prover: what holds of it holds of all. In each frame any one byte is followed; claims hold
// where it is the one that the triangle's comes from, so in particular then.

module triaxis_go_formal
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned WatchdogClocks = 10_000_000,
    parameter int unsigned HoldClocks = ClocksPerMs
) (
    input logic clk_i,
    input logic button_ni
);

  localparam int unsigned CoordWidth = 8 * ((W + 7) / 8);
  localparam int unsigned TriangleBytes = 9 * CoordWidth / 8;
  localparam int unsigned FirstTriangle = HeaderBytes + LoadFieldBytes;
  localparam int unsigned RequestBytes = HeaderBytes + FieldBytes;
  // States, by their places in the enumerations.
  localparam logic [2:0] Gather = 3'd1, Judge = 3'd2, Act = 3'd3, Load = 3'd4;
  localparam logic [2:0] HelloEnd = 3'd5, AbortEnd = 3'd6, Reply = 3'd7;
  localparam logic [2:0] LoaderGather = 3'd1, LoaderLook = 3'd2;
  localparam logic [2:0] LoaderEmpty = 3'd3, LoaderSend = 3'd4;

  typedef logic [16:0] count_t;
  typedef logic [$clog2(WatchdogClocks)+1:0] age_t;
  typedef logic [$clog2(WatchdogClocks+1)-1:0] left_t;
  typedef logic [$clog2(HoldClocks+1)-1:0] part_t;
  typedef struct packed {
    pose_t pose;
    logic [Zones-1:0][31:0] margins;
    logic [1:0] mode;
    trial_t trial;
    hold_t hold;
    logic [15:0] count_b;
    logic [15:0] count_a;
  } run_t;

  logic go_o, stop_o, beat_o, beyond_slow_o, beyond_warn_o;
  nexys4ddr_top #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .WatchdogClocks(WatchdogClocks),
      .HoldClocks(HoldClocks)
  ) u_top (
      .clk_100mhz_i(clk_i),
      .cpu_reset_ni(button_ni),
      .uart_rx_i(1'b1),
      .uart_tx_o(),
      .led_o(),
      .seg_no(),
      .an_no(),
      .go_o,
      .stop_o,
      .beat_o,
      .beyond_slow_o,
      .beyond_warn_o
  );
  logic rst_n;
  assign rst_n = u_top.rst_n;

  // --- What the prover chose ------------------------------------------------------------------------

  logic mesh_q;
  logic [15:0] slot_q;
  logic [$clog2(TriangleBytes)-1:0] place_q;
  always_ff @(posedge clk_i) begin
    mesh_q  <= mesh_q;
    slot_q  <= slot_q;
    place_q <= place_q;
  end
  always_comb begin
    Place : assume (32'(place_q) < TriangleBytes);
  end

  // The byte at that place of a triangle, as a frame has it.
  function automatic byte_t byte_of(logic [9*W-1:0] triangle,
                                    logic [$clog2(
                                    TriangleBytes)-1:0] place);
    logic [8*TriangleBytes-1:0] bytes;
    for (int k = 0; k < 9; k++)
    bytes[k*CoordWidth+:CoordWidth] = CoordWidth'(signed'(triangle[k*W+:W]));
    return bytes[8*32'(place)+:8];
  endfunction

  // --- What the host was answered ---------------------------------------------------------------------

  request_t frame;
  logic [7:0] first_place;
  logic [15:0] first;
  logic [7:0] triangles;
  byte_t frame_byte;
  logic [7:0] frame_place;
  logic [8:0] content;
  assign frame = u_top.request[0];
  assign first = frame.fields[23:8];
  assign triangles = frame.fields[31:24];
  assign frame_byte = u_top.u_receiver.byte_q;
  assign frame_place = u_top.u_receiver.place_q;
  assign content = 9'(8'(u_top.frame_length - 8'(CrcBytes)));

  // A frame that is released is answered; heard: acknowledged as a command that is no repeat.
  logic answered, acknowledged, owned, takes, heard, covered;
  logic [31:0] session_q;
  sequence_t number_q;
  byte_t command_q;
  assign answered = u_top.frame_release;
  assign acknowledged = answered && u_top.code == CodeOk;
  assign owned = frame.session != '0 && frame.session == session_q;
  assign takes = frame.session != '0 && frame.session != session_q && frame.command == CmdHello;
  assign heard = acknowledged && (takes || (owned && frame.sequence_number == number_q + 32'd1));
  // The frame loads the triangle that is followed, and its byte is the one that is.
  assign first_place = 8'(FirstTriangle) + 8'(slot_q - first) * 8'(TriangleBytes) + 8'(place_q);
  assign covered = frame.fields[0] == mesh_q && slot_q >= first &&
      17'(slot_q) < 17'(first) + 17'(triangles);

  count_t host_count_q[2], host_count_d[2];
  run_t host_run_q, host_run_d;
  logic known_q, known_d, asked_q, asked_d, wrong_q;
  byte_t host_byte_q, host_byte_d;
  age_t age_q;

  always_comb begin
    host_count_d = host_count_q;
    host_run_d = host_run_q;
    known_d = known_q;
    host_byte_d = host_byte_q;
    asked_d = asked_q;
    if (heard) begin
      case (frame.command)
        CmdHello: begin
          host_count_d = '{default: '0};
        end
        CmdLoad: begin
          host_count_d[frame.fields[0]] = 17'(first) + 17'(triangles);
          if (covered) begin
            known_d = frame_place == first_place;
            host_byte_d = frame_byte;
          end
        end
        CmdRun:
        host_run_d = '{
            pose: frame.fields[239:144],
            margins: frame.fields[103:8],
            mode: frame.fields[1:0],
            trial: frame.fields[143:136],
            hold: frame.fields[255:240],
            count_a: frame.fields[119:104],
            count_b: frame.fields[135:120]
        };
        default: ;
      endcase
      asked_d = frame.command inside {CmdResults, CmdStatus} ? asked_q : frame.command == CmdRun;
    end
  end

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      session_q <= '0;
      number_q <= '0;
      command_q <= '0;
      host_count_q <= '{default: '0};
      host_run_q <= '0;
      known_q <= 1'b0;
      host_byte_q <= '0;
      asked_q <= 1'b0;
      wrong_q <= 1'b0;
      age_q <= '1;
    end else begin
      if (heard) begin
        session_q <= frame.session;
        number_q  <= frame.sequence_number;
        command_q <= frame.command;
      end
      host_count_q <= host_count_d;
      host_run_q <= host_run_d;
      known_q <= known_d;
      host_byte_q <= host_byte_d;
      asked_q <= asked_d;
      // An error on the line, or a refusal, since a run was last asked for.
      wrong_q <= u_top.link_error || (answered && !acknowledged) ||
          (wrong_q && !(heard && frame.command == CmdRun));
      if (heard) age_q <= '0;
      else if (age_q != '1) age_q <= age_q + age_t'(1);
    end
  end

  // --- What the engine was given, and said ------------------------------------------------------------

  logic load, accept, clear_q, unchanged_q, loaded_here;
  // The last that it accepted; the last that ended, as it was accepted and as it had been acknowledged.
  run_t engine_run_q, ended_run_q, ended_host_q;
  logic [Zones-1:1] ended_zones_q;
  byte_t engine_byte_q;
  count_t engine_count[2];
  assign load = u_top.load_tvalid && u_top.load_tready;
  assign accept = u_top.run_tvalid && u_top.unused.ready;
  assign engine_count[0] = 17'(u_top.count_a);
  assign engine_count[1] = 17'(u_top.count_b);
  assign loaded_here = load && u_top.load_tuser == {1'b0, mesh_q} &&
      engine_count[mesh_q] == 17'(slot_q);

  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      clear_q <= 1'b0;
      unchanged_q <= 1'b0;
    end else begin
      // The last run that ended was complete and clear; its meshes are as they were; and a run that was
      // accepted since then holds.
      if (load || (accept && host_run_d.hold == '0)) clear_q <= 1'b0;
      else if (u_top.done) clear_q <= u_top.done_status == StatusComplete && u_top.near_count == '0;
      unchanged_q <= (unchanged_q || accept) && !load;
    end
  end
  always_ff @(posedge clk_i) begin
    if (loaded_here) engine_byte_q <= byte_of(u_top.load_tdata, place_q);
    if (accept) begin
      for (int k = 0; k < 3; k++)
      engine_run_q.pose[k] <= 32'(signed'(u_top.run_tdata[k*(W+1)+:W+1]));
      for (int z = 0; z < int'(Zones); z++)
      engine_run_q.margins[z] <= 32'(u_top.run_tuser >> (z * M)) & 32'((64'd1 << M) - 64'd1);
      engine_run_q.mode <= u_top.run_tuser[Zones*M+:2];
      engine_run_q.trial <= u_top.run_tuser[Zones*M+2+:$bits(trial_t)];
      // The engine knows of none.
      engine_run_q.hold <= host_run_d.hold;
      engine_run_q.count_a <= 16'(u_top.count_a);
      engine_run_q.count_b <= 16'(u_top.count_b);
    end
  end

  // Clocks since the last run ended, in whole units of its hold, and in the one that has begun.
  logic [16:0] units_q;
  part_t part_q;
  always_ff @(posedge clk_i) begin
    if (u_top.done) begin
      ended_run_q   <= engine_run_q;
      ended_host_q  <= host_run_d;
      ended_zones_q <= u_top.zones;
    end
  end
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) begin
      units_q <= '0;
      part_q  <= '0;
    end else if (u_top.done) begin
      units_q <= '0;
      part_q  <= '0;
    end else if (part_q == part_t'(HoldClocks - 1)) begin
      if (units_q != '1) units_q <= units_q + 17'd1;
      part_q <= '0;
    end else begin
      part_q <= part_q + part_t'(1);
    end
  end

  // --- Claims -----------------------------------------------------------------------------------------

  // Since the first clock: the triangle that is followed was loaded; a frame was read and judged;
  // by it a run was asked for, and the engine took it.
  logic was_go_q, judged_q = 1'b0, loaded_q = 1'b0, ran_q = 1'b0;
  always_ff @(posedge clk_i) begin
    judged_q <= judged_q || u_top.u_command.state_q == Judge;
    loaded_q <= loaded_q || loaded_here;
    ran_q <= ran_q || (judged_q && accept && heard && frame.command == CmdRun);
  end
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) was_go_q <= 1'b0;
    else was_go_q <= go_o;
  end

  // A fault since the run that was asked for last, or the last clock's.
  logic permits, faulted_q, was_fault_q, was_hello_q;
  assign permits = go_o || !stop_o;
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) {faulted_q, was_fault_q, was_hello_q} <= '0;
    else begin
      faulted_q   <= u_top.fault || (faulted_q && !u_top.run[0]);
      was_fault_q <= u_top.fault;
      was_hello_q <= u_top.hello;
    end
  end

  // In the last clock the host, the board or a run gave a reason to end go.
  logic reason_q;
  always_ff @(posedge clk_i or negedge rst_n) begin
    if (!rst_n) reason_q <= 1'b0;
    else
      reason_q <= u_top.hello || u_top.load || (u_top.run[0] && !u_top.keep[0]) || u_top.abort ||
          u_top.link_error || u_top.refused || u_top.fault || !u_top.alive[0] ||
          (u_top.done && (u_top.done_status != StatusComplete || u_top.near_count != '0));
  end

  logic [2:0] told;
  assign told = {u_top.forget, u_top.run[0], u_top.cut};

  always_comb begin
    Antivalent : assert (go_o != stop_o);
    StopInReset : assert (rst_n || !permits);
    if (rst_n) begin
      // Only frames of the board's own session, each once and in order, are acknowledged, or the
      // last one again; another session's HELLO takes the board.
      Legitimate :
      assert (!acknowledged || heard ||
              (owned && frame.sequence_number == number_q && frame.command == command_q));
      TakenInSilence : assert (!(u_top.hello && takes) || !u_top.alive[0]);
      if (permits) begin
        // The last run that ended was complete and found nothing near; one that began since then holds.
        Clear : assert (clear_q && unchanged_q);
        // It was the run asked for: pose, margin, mode, trial and counts; so is one that goes on.
        AsAsked : assert (asked_q && engine_run_q == host_run_q && ended_run_q == ended_host_q);
        // Its time is not over.
        InTime : assert (ended_host_q.hold == '0 || units_q < 17'(ended_host_q.hold));
        // On the meshes that were acknowledged: as many triangles, and each byte of each.
        Counts :
        assert (host_count_q == engine_count && engine_count[0] == 17'(host_run_q.count_a) &&
                engine_count[1] == 17'(host_run_q.count_b) && engine_count[0] != '0 &&
                engine_count[1] != '0 && ended_host_q.count_a == host_run_q.count_a &&
                ended_host_q.count_b == host_run_q.count_b);
        Triangles :
        assert (!known_q || 17'(slot_q) >= engine_count[mesh_q] || engine_byte_q == host_byte_q);
        NothingWrong : assert (!wrong_q);
        HeardInTime : assert (age_q <= age_t'(WatchdogClocks));
        // None while a fault stands, nor before the end of a run that was asked for after it.
        NoFault : assert (!was_fault_q && !faulted_q);
      end
      // Beyond a zone only with go, and where the run that go stands on looked at it and found nothing in it.
      Beyond : assert ({beyond_warn_o, beyond_slow_o} == (go_o ? ~ended_zones_q : '0));
      // Go lasts as long as it may.
      Lasts :
      assert (go_o || !was_go_q || reason_q ||
              (ended_host_q.hold != '0 && units_q == 17'(ended_host_q.hold)));
      // It stands until a HELLO.
      FaultStays : assert (!was_fault_q || u_top.fault || was_hello_q);
      // A HELLO ends what goes on.
      HelloEndsRun : assert (!was_hello_q || !u_top.busy || u_top.aborting);
      // As `board_runs` assumes of commands.
      ToldInOrder : assert ((told & (told - 3'd1)) == '0 && !(u_top.busy && told[2:1] != '0));
      BeatOnlyWithGo : assert (!beat_o || go_o || was_go_q);
      // What a LOAD is answered of each mesh is the engine's, so the host can compare it with its own.
      Signatures :
      assert (u_top.u_answer.signatures_i ==
              {u_top.u_mesh.signature_b_o, u_top.u_mesh.signature_a_o});
      FitsTheMesh :
      assert (!load || u_top.load_tuser[1] || engine_count[u_top.load_tuser[0]] < 17'(Depth));
      SeenGo : cover (go_o && ran_q);
      SeenSlow : cover (go_o && ran_q && beyond_slow_o && !beyond_warn_o);
      SeenLoad :
      cover (acknowledged && frame.command == CmdLoad && known_d && !known_q && loaded_q);
      SeenStopInTime :
      cover (judged_q && was_go_q && !go_o && age_q == age_t'(WatchdogClocks + 1) && !wrong_q);
      SeenLate :
      cover (was_go_q && !go_o && judged_q && ended_host_q.hold == 16'd3 &&
             units_q == 17'd3 && part_q == '0);
      SeenFault : cover (was_go_q && was_fault_q && !permits && judged_q);
      SeenTaken : cover (judged_q && heard && takes);
    end
  end

  // --- What makes it inductive --------------------------------------------------------------------------

  logic [2:0] state;
  logic [2:0] loader;
  left_t left;  // clocks until silence
  logic timed;  // go has a deadline, in so many units and clocks
  hold_t hold_left;
  part_t hold_part;
  logic busy, armed, repeated, executes, ok, load_here, loading, hello_new, in_hello;
  logic gathered_q = 1'b0;  // a frame, since power-up
  logic [7:0] read, came;  // bytes of the frame, and of it or of one before
  logic [3:0] sent;  // triangles of the frame before the one that is in hand
  logic [7:0] sent_place;
  logic [4:0] loader_byte;
  logic [8*TriangleBytes-1:0] loader_triangle;
  assign state = u_top.u_command.state_q;
  assign loader = u_top.u_command.u_loader.state_q;
  assign busy = u_top.busy;
  assign left = u_top.g_watchdog[0].u_watchdog.left_q;
  assign timed = u_top.g_safety[0].u_safety.timed_q;
  assign hold_left = u_top.g_safety[0].u_safety.left_q;
  assign hold_part = u_top.g_safety[0].u_safety.part_q;
  // In silence it comes to nothing.
  assign armed = u_top.g_safety[0].u_safety.armed_q && (u_top.alive[0] || go_o);
  assign repeated = u_top.u_command.repeated;
  assign ok = u_top.code == CodeOk;
  assign read = state > Gather ? 8'(RequestBytes) : 8'(u_top.u_command.place_q);
  assign came = gathered_q ? 8'(RequestBytes) : state == '0 ? '0 : 8'(u_top.u_command.place_q);
  assign executes = state == Act && ok && !repeated;
  assign loading = state == Load && u_top.u_command.u_loader.sending_q;
  assign hello_new = state == Reply && ok && frame.command == CmdHello && heard;
  assign in_hello = state == HelloEnd || hello_new;
  assign sent = u_top.u_command.u_loader.triangles_q - u_top.u_command.u_loader.left_q;
  assign loader_byte = 5'(u_top.u_command.u_loader.byte_q);
  assign loader_triangle = u_top.u_command.u_loader.triangle_q;
  assign sent_place = 8'(FirstTriangle) + 8'(sent) * 8'(TriangleBytes);
  assign load_here = frame.fields[0] == mesh_q;
  always_ff @(posedge clk_i) gathered_q <= gathered_q || state == Judge;

  always_comb begin
    // Nothing resets what is gathered: what came is alike, and before the first frame the rest is anything.
    assert ((u_top.request[0] ^ u_top.request[1]) >> (8 * (8'(RequestBytes) - came)) == '0);
    assert (gathered_q || state inside {3'd0, Gather, Judge});
    if (rst_n) begin
      // The copies.
      assert (u_top.says_go[0] == u_top.says_go[1] && u_top.says_stop[0] == u_top.says_stop[1]);
      assert (u_top.g_safety[0].u_safety.armed_q == u_top.g_safety[1].u_safety.armed_q);
      assert (left == u_top.g_watchdog[1].u_watchdog.left_q);
      assert (timed == u_top.g_safety[1].u_safety.timed_q);
      assert (hold_left == u_top.g_safety[1].u_safety.left_q);
      assert (hold_part == u_top.g_safety[1].u_safety.part_q);
      assert (u_top.g_safety[0].u_safety.zones_q == u_top.g_safety[1].u_safety.zones_q);
      assert (u_top.says_beyond[0] == u_top.says_beyond[1]);
      assert (hold_part < part_t'(HoldClocks) && part_q < part_t'(HoldClocks));
      assert (u_top.runner_seen[0] == u_top.runner_seen[1]);
      // The command: states, and what is read of the frame.
      assert (state == '0 || (u_top.frame_full && u_top.u_mesh.awake_q));
      assert (8'(u_top.u_command.place_q) < 8'(RequestBytes) || state == Judge);
      assert (state inside {Gather, Judge} || u_top.u_command.place_q == '0);
      assert (state != Judge || 8'(u_top.u_command.place_q) == 8'(RequestBytes));
      assert (state != Act || u_top.u_command.good_q == ok);
      assert (!u_top.frame_full ||
              content inside {[9'(HeaderBytes) : 9'(MaxFrameBytes - CrcBytes)]});
      Head :
      assert (state == '0 || frame_place >= read || 9'(frame_place) >= content ||
              8'(frame >> (8 * (32'(RequestBytes) - 32'(read) + 32'(frame_place)))) == frame_byte);
      // The session: as the host sees it, but while a HELLO is executed.
      if (in_hello) begin
        assert (u_top.u_command.u_session.session_q == frame.session &&
                u_top.u_command.u_session.sequence_q == frame.sequence_number &&
                u_top.u_command.u_session.command_q == frame.command);
        assert (ok && frame.command == CmdHello && frame.session != '0);
        assert (takes || (owned && frame.sequence_number == number_q + 32'd1));
      end else begin
        assert (u_top.u_command.u_session.session_q == session_q);
        assert (session_q == '0 || (u_top.u_command.u_session.sequence_q == number_q &&
                u_top.u_command.u_session.command_q == command_q));
      end
      if (state inside {Act, Load, AbortEnd, Reply} && ok && !in_hello) begin
        assert (frame.command inside {[CmdHello : CmdAbort]});
        assert (frame.session != '0 && (u_top.u_command.next || repeated ||
                (frame.command == CmdHello && !u_top.u_command.mine)));
      end
      if (state inside {Act, Load} && ok && !repeated && frame.command == CmdLoad) begin
        assert (triangles inside {[8'd1 : 8'(LoadMax)]} && frame.fields[7:1] == '0);
        assert (17'(first) + 17'(triangles) <= 17'(Depth) && !busy);
        assert (content == 9'(FirstTriangle) + 9'(triangles) * 9'(TriangleBytes));
        assert (loading || first == '0 || engine_count[frame.fields[0]] == 17'(first));
      end
      if (executes && frame.command == CmdRun) begin
        for (int k = 0; k < 3; k++)
        assert (frame.fields[144+32*k+:32] == 32'(signed'(frame.fields[144+32*k+:W+1])));
        for (int z = 0; z < int'(Zones); z++) assert ((frame.fields[8+32*z+:32] >> M) == '0);
        assert (!busy && frame.fields[7:0] <= 8'(ModeCount));
        assert (17'(frame.fields[119:104]) == engine_count[0] && engine_count[0] != '0);
        assert (17'(frame.fields[135:120]) == engine_count[1] && engine_count[1] != '0);
      end
      assert (state != Load || (ok && u_top.u_command.next && frame.command == CmdLoad));
      assert (state != AbortEnd || (ok && u_top.u_command.next && frame.command == CmdAbort));
      assert (state != Load || !busy);

      // The loader, in step with the command.
      assert ((loader != '0) == (state inside {Load, HelloEnd}));
      assert (loader <= LoaderSend);
      if (state == HelloEnd) begin
        assert (loader == LoaderEmpty && u_top.u_command.u_loader.both_q);
        assert (!u_top.u_command.u_loader.mesh_q || (engine_count[0] == '0 && !busy));
      end
      if (hello_new) assert (engine_count[0] == '0 && engine_count[1] == '0);
      if (state == Load) begin
        assert (!u_top.u_command.u_loader.both_q);
        assert (u_top.u_command.u_loader.mesh_q == frame.fields[0]);
        assert (u_top.u_command.u_loader.empty_first_q == (first == '0));
        assert (8'(u_top.u_command.u_loader.triangles_q) == triangles);
        assert (u_top.u_command.u_loader.left_q != '0 &&
                u_top.u_command.u_loader.left_q <= u_top.u_command.u_loader.triangles_q);
        assert (loader != LoaderSend || loading);
        assert (loader != LoaderEmpty || (loading && sent == '0 && first == '0));
        assert (loader != LoaderLook || !loading);
        assert (loader_byte < 5'(TriangleBytes) && (loader == LoaderGather || loader_byte == '0));
        assert (u_top.u_command.u_loader.address_q == sent_place +
                (loader inside {LoaderLook, LoaderSend} ? 8'(TriangleBytes) : 8'(loader_byte)));
        if (frame_place == sent_place + 8'(place_q)) begin
          if (loader == LoaderGather && loader_byte > 5'(place_q))
            assert (loader_triangle[8*(TriangleBytes-32'(loader_byte)+32'(place_q))+:8] ==
                    frame_byte);
          if (loader inside {LoaderLook, LoaderSend})
            assert (loader_triangle[8*32'(place_q)+:8] == frame_byte);
        end
      end

      // The meshes: the engine's are the host's, but while a LOAD or HELLO is under way.
      for (int mesh = 0; mesh < 2; mesh++) begin
        assert (engine_count[mesh] <= 17'(Depth));
        if (loading && frame.fields[0] == 1'(mesh))
          assert (loader == LoaderEmpty || engine_count[mesh] == 17'(first) + 17'(sent));
          else if (state != HelloEnd) assert (engine_count[mesh] == host_count_d[mesh]);
      end
      if (loading && load_here) begin
        assert (loader == LoaderEmpty || 17'(slot_q) >= engine_count[mesh_q] || !covered ||
                frame_place != first_place || engine_byte_q == frame_byte);
        assert (loader == LoaderEmpty || 17'(slot_q) >= 17'(first) || !known_q ||
                engine_byte_q == host_byte_q);
      end else begin
        assert (!known_d || 17'(slot_q) >= engine_count[mesh_q] || engine_byte_q == host_byte_d);
      end

      // The runner and the engine.
      assert (busy == (u_top.run_tvalid || u_top.u_mesh.running_q));
      assert (!u_top.run_tvalid || (!u_top.u_mesh.running_q && state == Reply));
      TakenAtOnce : assert (!u_top.run_tvalid || u_top.unused.ready);
      assert (u_top.run_state <= RunDone);
      if (state != HelloEnd) begin
        for (int k = 0; k < 3; k++)
        assert (u_top.status.pose[k] == 32'(signed'(u_top.status.pose[k][W:0])));
      end

      // What go rests on, from RUN's execution on.
      assert (!(armed || go_o) || !in_hello);
      if (armed) begin
        assert (asked_d && !(state inside {HelloEnd, AbortEnd}) && !loading);
        assert (!wrong_q || (heard && frame.command == CmdRun));
        assert (u_top.status.pose == host_run_d.pose && u_top.runs[0].hold == host_run_d.hold);
        assert (u_top.g_runner[0].u_runner.margins_q == host_run_d.margins &&
                u_top.run_mode == host_run_d.mode);
        assert (u_top.trial == host_run_d.trial && !faulted_q && u_top.run_state != RunNever);
        for (int z = 0; z < int'(Zones); z++) assert ((host_run_d.margins[z] >> M) == '0);
        assert (engine_count[0] == 17'(host_run_d.count_a) && engine_count[0] != '0);
        assert (engine_count[1] == 17'(host_run_d.count_b) && engine_count[1] != '0);
        assert (u_top.run_tvalid || unchanged_q);
        assert (u_top.run_tvalid || engine_run_q == host_run_d);
      end
      assert (!go_o || armed);
      if (go_o) begin
        assert (clear_q && unchanged_q && ended_run_q == ended_host_q);
        assert (!busy || host_run_d.hold != '0);
        assert (u_top.g_safety[0].u_safety.zones_q == ended_zones_q);
        assert (ended_host_q.count_a == host_run_d.count_a &&
                ended_host_q.count_b == host_run_d.count_b);
        assert (timed == (ended_host_q.hold != '0));
        if (timed) begin
          assert (hold_left != '0 && 17'(hold_left) + units_q == 17'(ended_host_q.hold));
          assert (hold_part + part_q == part_t'(HoldClocks - 1));
        end
      end

      // The watchdog.
      assert (32'(left) <= 32'(WatchdogClocks));
      assert (in_hello || left == '0 || 32'(left) + 32'(age_q) <= 32'(WatchdogClocks));
      assert (!armed || left != '0 || age_q <= age_t'(WatchdogClocks));
      assert (!u_top.beat_o || go_o || was_go_q);
    end
  end

endmodule
