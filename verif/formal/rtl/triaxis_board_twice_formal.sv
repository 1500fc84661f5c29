// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What permits the machine to move is there twice on the board, and each permits nothing on its own, whatever
// the other does: go is the one's, stop the other's, and what is beyond a zone both must say. The registers
// begin with anything, so each of the two may have whatever state it likes: claims are about what the next clock
// makes of it. Two runs that differ, and a byte of a frame that is broken, are a fault in the next clock. Of the
// first run all bits are told.

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

  logic holds, changed, wrong, complete, tried, tried_frame;
  assign holds = u_top.request.fields[255:240] != '0;
  assign changed = u_top.hello || u_top.load || (u_top.run && !holds) || u_top.abort;
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
    logic run;
    logic changed;
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
    if (full) begin
      for (int i = 0; i < 2; i++) begin
        // Go, and being armed, of each come from its own past alone.
        assert (going[i] == (((last_q.going[i] && !late[i] && !last_q.done) ||
                (last_q.armed[i] && last_q.complete)) &&
                !last_q.changed && !last_q.wrong && last_q.alive[i]));
        assert (armed[i] == ((last_q.run || (last_q.armed[i] && !last_q.changed && !late[i])) &&
                !last_q.wrong && last_q.alive[i]));
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
      SeenRunsDiffer : cover (!last_q.tried_runner && !last_q.same_runs && !last_q.broken);
    end
  end

endmodule
