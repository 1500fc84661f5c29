// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What permits the machine to move is there twice on the board, and each permits nothing on its own, whatever
// the other does: go is the one's, stop the other's, and what is beyond a zone both must say. The registers
// begin with anything, so each of the two may have whatever state it likes: claims are about what the next clock
// makes of it. A run is of the request that is kept for it. Two runs that differ, and a byte of a frame that is
// broken, are a fault in the next clock. Of the first run all bits are told. What executes a command is that it was
// judged in the last clock, whole and good, and its code says so too.

`include "triaxis_formal.svh"

module triaxis_board_twice_formal
  import triaxis_board_pkg::*;
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 4096,
    parameter int unsigned WatchdogClocks = 10_000_000,
    parameter int unsigned HoldClocks = ClocksPerMs
) (
    input logic clk_i
);

  logic go_o, stop_o, beyond_slow_o, beyond_warn_o;
  nexys4ddr_top #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .WatchdogClocks(WatchdogClocks),
      .HoldClocks(HoldClocks)
  ) u_top (
      .clk_100mhz_i(clk_i),
      .cpu_reset_ni(1'b1),
      .uart_rx_i(1'b1),
      .uart_tx_o(),
      .led_o(),
      .seg_no(),
      .an_no(),
      .go_o,
      .stop_o,
      .beat_o(),
      .beyond_slow_o,
      .beyond_warn_o
  );

  // Go of each, and what it is made of.
  typedef logic [$clog2(WatchdogClocks+1)-1:0] left_t;
  typedef logic [$clog2(HoldClocks+1)-1:0] part_t;
  typedef struct packed {
    logic  timed;
    hold_t left;
    part_t part;
  } deadline_t;
  typedef logic [Zones-1:1] zones_t;
  logic [1:0] armed, going, alive;
  zones_t [1:0] zones, beyond;
  deadline_t [1:0] deadline;
  hold_t [1:0] hold;
  left_t left[2];
  for (genvar i = 0; i < 2; i++) begin : g_copy
    assign armed[i] = u_top.g_safety[i].u_safety.armed_q;
    assign going[i] = u_top.g_safety[i].u_safety.go_q;
    assign zones[i] = u_top.g_safety[i].u_safety.zones_q;
    assign beyond[i] = u_top.g_safety[i].u_safety.beyond_o;
    assign left[i] = u_top.g_watchdog[i].u_watchdog.left_q;
    assign alive[i] = left[i] != '0;
    assign hold[i] = u_top.runs[i].hold;
    assign deadline[i] = '{
            timed: u_top.g_safety[i].u_safety.timed_q,
            left: u_top.g_safety[i].u_safety.left_q,
            part: u_top.g_safety[i].u_safety.part_q
        };
  end

  // Each by the request that is kept for it.
  logic [1:0] changed;
  run_fields_t [1:0] asked;
  logic wrong, complete, tried, tried_frame, executes, judged;
  for (genvar i = 0; i < 2; i++) begin : g_asked
    assign asked[i] = u_top.request[i].fields;
    assign changed[i] = u_top.hello || u_top.load || u_top.abort ||
        (u_top.run[i] && asked[i].hold == '0);
  end
  typedef logic [8*(HeaderBytes+FieldBytes)-9:0] later_t;
  later_t whole[2];
  later_t [1:0] later;
  for (genvar i = 0; i < 2; i++) begin : g_gathered
    assign whole[i] = u_top.request[i][$bits(request_t)-1:8];
    assign later[i] = u_top.request[i][$bits(later_t)-1:0];
  end
  assign executes = u_top.hello || u_top.u_command.load_start || u_top.run != '0 || u_top.free ||
      u_top.abort;
  assign judged = u_top.u_command.state_q == 3'd2 && u_top.u_command.judged == CodeOk &&
      8'(u_top.u_command.place_q) == 8'(HeaderBytes + FieldBytes);
  assign wrong = u_top.link_error || u_top.refused || u_top.fault;
  assign complete = u_top.done && u_top.done_status == StatusComplete && u_top.near_count == '0;
  assign tried = u_top.busy && u_top.trial.kind == TrialBoard;
  assign tried_frame = tried && u_top.trial.which == 5'd31;

  // The engine is not given all bits of them.
  logic same_margins;
  assign same_margins = u_top.g_runner[0].u_runner.margins_q ==
      u_top.g_runner[1].u_runner.margins_q;

  typedef struct packed {
    logic [1:0] armed;
    logic [1:0] going;
    logic [1:0] alive;
    left_t [1:0] left;
    deadline_t [1:0] deadline;
    hold_t [1:0] hold;
    zones_t [1:0] zones;
    zones_t found;
    logic done;
    logic kick;
    logic [1:0] run;
    run_fields_t [1:0] asked;
    logic forget;
    logic judged;
    logic gathers;
    later_t [1:0] whole;
    logic [1:0] changed;
    logic wrong;
    logic complete;
    logic tried_runner;
    logic same_runs;
    logic broken;
    logic fault;
    logic hello;
  } known_t;
  known_t known, last_q;
  assign known = '{
          armed: armed,
          going: going,
          alive: alive,
          left: {left[1], left[0]},
          deadline: deadline,
          hold: hold,
          zones: zones,
          found: u_top.zones,
          done: u_top.done,
          kick: u_top.kick,
          run: u_top.run,
          asked: asked,
          forget: u_top.forget,
          judged: judged,
          gathers: u_top.u_command.state_q == 3'd1,
          whole: {whole[1], whole[0]},
          changed: changed,
          wrong: wrong,
          complete: complete,
          tried_runner: tried && !tried_frame,
          same_runs: u_top.runs[0] == u_top.runs[1] && same_margins,
          broken: u_top.frame_broken,
          fault: u_top.fault,
          hello: u_top.hello
      };
  always_ff @(posedge clk_i) last_q <= known;

  logic [1:0] kept;
  for (genvar i = 0; i < 2; i++) begin : g_kept
    assign kept[i] = u_top.runs[i].mode == last_q.asked[i].mode[1:0] &&
        u_top.runs[i].trial == last_q.asked[i].trial &&
        u_top.runs[i].hold == last_q.asked[i].hold &&
        u_top.runs[i].run_pose == last_q.asked[i].pose &&
        u_top.g_runner[i].u_runner.margins_q == last_q.asked[i].margins;
  end

  deadline_t [1:0] deadline_d;
  logic [1:0] late;
  always_comb begin
    for (int i = 0; i < 2; i++) begin
      deadline_d[i] = last_q.deadline[i];
      late[i] = last_q.going[i] && last_q.deadline[i].timed && !last_q.done &&
          last_q.deadline[i].left == hold_t'(1) && last_q.deadline[i].part == '0;
      if (last_q.armed[i] && last_q.complete) begin
        deadline_d[i] = '{
            timed: last_q.hold[i] != '0,
            left: last_q.hold[i],
            part: part_t'(HoldClocks - 1)
        };
      end else if (last_q.deadline[i].part != '0) begin
        deadline_d[i].part -= part_t'(1);
      end else begin
        deadline_d[i].part = part_t'(HoldClocks - 1);
        deadline_d[i].left -= hold_t'(1);
      end
    end
  end

  `TRIAXIS_FULL_AFTER(1)
  always_comb begin
    assume (u_top.rst_n);
    Outputs : assert (go_o == going[0] && stop_o == u_top.g_safety[1].u_safety.stop_q);
    // One alone says nothing.
    BothBeyond : assert ({beyond_warn_o, beyond_slow_o} == (beyond[0] & beyond[1]));
    Faults : assert (u_top.fault == (u_top.engine_fault || u_top.board_fault_q));
    Trials :
    assert (u_top.trying_frame == tried_frame && u_top.trying_runner == (tried && !tried_frame));
    Said :
    assert (u_top.status.flags.fault == u_top.fault &&
            (!u_top.fault || u_top.status.engine_status inside {8'(StatusNone), 8'(StatusFault)}));
    ZonesTold : assert (u_top.status.flags[5:4] == u_top.g_runner[0].u_runner.zones_q);
    Told :
    assert ({u_top.status.margin, u_top.status.pose, u_top.status.run_number} ==
            {u_top.g_runner[0].u_runner.margins_q[ZoneMargin], u_top.g_runner[0].u_runner.pose_q,
             u_top.g_runner[0].u_runner.run_number_q});
    Executes :
    assert (!executes || (u_top.u_command.state_q == 3'd3 && u_top.u_command.good_q &&
            u_top.code == CodeOk));
    // All but runs are of the first.
    First :
    assert (u_top.u_command.request == u_top.request[0] &&
            u_top.u_answer.request_i == u_top.request[0]);
    RunOfItsOwn :
    assert ((u_top.run[0] == u_top.run[1] ||
             u_top.request[0].command != u_top.request[1].command) &&
            (!u_top.run[0] || u_top.request[0].command == CmdRun) &&
            (!u_top.run[1] || u_top.request[1].command == CmdRun));
    if (full) begin
      AsAsked : assert (last_q.forget || (last_q.run & ~kept) == '0);
      // What is gathered goes on in its own.
      Gathered : assert (!last_q.gathers || last_q.whole == later);
      Judged : assert (u_top.u_command.good_q == last_q.judged);
      for (int i = 0; i < 2; i++) begin
        // Go, and being armed, of each come from its own past alone.
        assert (going[i] == (((last_q.going[i] && !late[i] && !last_q.done) ||
                (last_q.armed[i] && last_q.complete)) &&
                !last_q.changed[i] && !last_q.wrong && last_q.alive[i]));
        assert (armed[i] == (!last_q.wrong && last_q.alive[i] &&
                (last_q.run[i] || (last_q.armed[i] && !last_q.changed[i] && !late[i]))));
        // What it found of the zones, of the run that was clear; beyond one of them only with go.
        assert (zones[i] == (last_q.armed[i] && last_q.complete ? last_q.found : last_q.zones[i]));
        assert (beyond[i] == (going[i] ? ~zones[i] : '0));
        // Its deadline: of the run that was clear, then a clock less each clock.
        assert (deadline[i] == deadline_d[i]);
        assert (left[i] == (last_q.kick ? left_t'(WatchdogClocks) :
                last_q.left[i] - left_t'(last_q.alive[i])));
      end
      StopOfTheOther : assert (stop_o == !going[1]);
      RunsDiffer : assert (last_q.tried_runner || last_q.same_runs || u_top.board_fault_q);
      TriedRunner : assert (!last_q.tried_runner || !last_q.same_runs || u_top.board_fault_q);
      Broken : assert (!last_q.broken || u_top.board_fault_q);
      NoOtherFault :
      assert (!u_top.board_fault_q || last_q.broken || last_q.tried_runner || !last_q.same_runs ||
              (last_q.fault && !last_q.hello));
      SeenLate : cover (late == 2'b01 && !going[0] && going[1]);
      SeenOneAlone : cover (going[0] && !going[1] && go_o && stop_o && last_q.complete);
      SeenBeyondAlone : cover (beyond[0] == '1 && beyond[1] == '0 && going[1]);
      SeenOtherAlone : cover (!going[0] && going[1] && !go_o && !stop_o);
      SeenOneRun : cover (last_q.run == 2'b10 && last_q.same_runs);
      SeenRunsDiffer : cover (!last_q.tried_runner && !last_q.same_runs && !last_q.broken);
    end
  end

endmodule
