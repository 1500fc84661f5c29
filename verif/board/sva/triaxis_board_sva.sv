// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Rules of what goes on between the board's parts, bound from outside the RTL: of its streams, of what
// a frame may do and when, of go.

module triaxis_board_sva
  import triaxis_board_pkg::*;
#(
    parameter int unsigned HoldClocks = ClocksPerMs
) (
    input logic clk_i,
    input logic rst_ni,
    // The engine's streams.
    input logic load_tvalid,
    input logic load_tready,
    input logic [1:0] load_tuser,
    input logic run_tvalid,
    input logic run_tready,
    // Frames, and their replies.
    input logic frame_full,
    input logic frame_release,
    input logic [$clog2(MaxFrameBytes)-1:0] frame_length,
    input logic reply_valid,
    input logic reply_ready,
    input logic receiving,
    input logic line,
    input logic line_ready,
    input logic byte_valid,
    input logic byte_taken,
    // What frames do.
    input code_e code,
    input logic executes,
    input logic changes,
    input logic keeps,  // with changes: go stays
    input logic ends,
    input logic forgets,
    input logic busy,
    input logic meshes_empty,
    input logic near_fit,
    input logic free,
    input logic [31:0] free_to,
    input logic [31:0] asked,
    // Faults.
    input logic tries,  // by the run that begins, or goes on
    input logic acknowledges,
    input logic fault,
    // Go.
    input logic done,
    input logic clear,
    input hold_t hold,
    input logic wrong,
    input logic go_o,
    input logic stop_o,
    input logic beat_o,
    input logic beyond_slow_o,
    input logic beyond_warn_o
);

  QuietInReset :
  assert property (@(posedge clk_i) !rst_ni |->
      !load_tvalid && !run_tvalid && !reply_valid && !executes && !frame_full)
  else $error("in a reset something is offered, or done");

  // With two states the reset of power-up is no edge: the line has its level from the first clock on.
  logic begun = 1'b0;
  always_ff @(posedge clk_i) begun <= 1'b1;

  LineIdleInReset :
  assert property (@(posedge clk_i) begun && !rst_ni |-> line && line_ready && !receiving)
  else $error("in a reset something is sent, or received");

  StopInReset :
  assert property (@(posedge clk_i) !rst_ni |->
      stop_o && !go_o && !beat_o && !beyond_slow_o && !beyond_warn_o)
  else $error("no stop in a reset");

  // What is offered and not taken stays as it is.
  EmptyingHeld :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      load_tvalid && !load_tready |=> load_tvalid && $stable(
      load_tuser
  ))
  else $error("the emptying of a mesh changed while it waited");

  FrameHeld :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      frame_full && !frame_release |=> frame_full && $stable(
      frame_length
  ))
  else $error("a frame changed before its reply");

  // A reply is made up while the line is busy with the byte before.
  ByteTakenIsThere :
  assert property (@(posedge clk_i) disable iff (!rst_ni) byte_taken |-> byte_valid)
  else $error("a byte of a reply was taken while there was none");

  // The loader and the runner look at no handshake: nothing of theirs may wait.
  TrianglesTakenAtOnce :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      load_tvalid && !load_tuser[1] |-> load_tready)
  else $error("a triangle was lost: the engine did not take it");

  RunsTakenAtOnce :
  assert property (@(posedge clk_i) disable iff (!rst_ni) run_tvalid |-> run_tready)
  else $error("a run was lost: the engine did not take it");

  RepliesTakenAtOnce :
  assert property (@(posedge clk_i) disable iff (!rst_ni) reply_valid |-> reply_ready)
  else $error("a reply was lost: another one was under way");

  OnlyWhatIsAcceptedIsDone :
  assert property (@(posedge clk_i) disable iff (!rst_ni) executes |-> code == CodeOk)
  else $error("a frame was executed that is refused");

  NothingChangesDuringRuns :
  assert property (@(posedge clk_i) disable iff (!rst_ni) changes |-> !busy)
  else $error("meshes, pose or run changed while a run was going on");

  ForgetsAtRest :
  assert property (@(posedge clk_i) disable iff (!rst_ni) forgets |-> !busy)
  else $error("a session began before the last run had ended");

  ForgetsMeshes :
  assert property (@(posedge clk_i) disable iff (!rst_ni) forgets |=> meshes_empty)
  else $error("a session began with triangles of another");

  // The reply tells the ring where, and is under way for no other frame then.
  FreesWhatWasAsked :
  assert property (@(posedge clk_i) disable iff (!rst_ni) free |-> free_to == asked)
  else $error("pairs are freed up to another than the frame asks for");

  RingBounded :
  assert property (@(posedge clk_i) near_fit)
  else $error("more near pairs are held than there is place for");

  Antivalent :
  assert property (@(posedge clk_i) go_o != stop_o)
  else $error("go and stop are the same");

  GoEnds :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      ends || (changes && !keeps) || wrong |=> !go_o)
  else $error("go is said after what ends it");

  // Clocks since the last run ended, that one among them.
  logic [63:0] since;
  always_ff @(posedge clk_i) since <= done ? 64'd1 : since + 64'd1;

  GoEndsWithARun :
  assert property (@(posedge clk_i) disable iff (!rst_ni) done && !clear |=> !go_o)
  else $error("go is said after a run that was not clear");

  GoEndsInTime :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      go_o && !busy && hold != '0 |-> since <= 64'(hold) * 64'(HoldClocks))
  else $error("go is said after the deadline of the last run");

  // While a run goes on, the deadline is that of the one before.
  hold_t hold_before;
  always_ff @(posedge clk_i) if (done) hold_before <= hold;
  GoEndsInTimeOfTheLast :
  assert property (@(posedge clk_i) disable iff (!rst_ni)
      go_o && busy && hold_before != '0 |->
      since <= 64'(hold_before) * 64'(HoldClocks))
  else $error("go is said during a run after the deadline of the one before");

  FaultEndsGo :
  assert property (@(posedge clk_i) disable iff (!rst_ni) fault |=> !go_o)
  else $error("go is said although a check has failed");

  FaultStands :
  assert property (@(posedge clk_i) disable iff (!rst_ni) fault && !acknowledges |=> fault)
  else $error("a fault is gone that nobody was told of");

  // Whether anything was tried since the last HELLO that found no run.
  logic tried;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) tried <= 1'b0;
    else tried <= (run_tvalid && tries) || (tried && !(acknowledges && !busy));
  end

  NoFalseAlarm :
  assert property (@(posedge clk_i) disable iff (!rst_ni) fault |-> tried)
  else $error("a check failed although nothing was tried");

  BeatOnlyWithGo :
  assert property (@(posedge clk_i) disable iff (!rst_ni) beat_o |-> go_o || $past(go_o))
  else $error("a beat without go");

  BeyondOnlyWithGo :
  assert property (@(posedge clk_i) beyond_slow_o || beyond_warn_o |-> go_o)
  else $error("beyond a zone without go");

endmodule

bind nexys4ddr_top triaxis_board_sva #(
    .HoldClocks(HoldClocks)
) u_sva (
    .clk_i(clk_100mhz_i),
    .rst_ni(rst_n),
    .load_tvalid,
    .load_tready,
    .load_tuser,
    .run_tvalid,
    .run_tready(unused.ready),
    .frame_full,
    .frame_release,
    .frame_length,
    .reply_valid,
    .reply_ready,
    .receiving(u_receiver.u_uart.state_q != '0),
    .line(uart_tx_o),
    .line_ready(u_transmitter.slip_ready),
    .byte_valid(u_transmitter.reply_valid),
    .byte_taken(u_transmitter.reply_ready),
    .code,
    .executes(hello || load || run != '0 || free || abort),
    .changes(load || run != '0),
    .keeps(run[0] && keep[0]),
    .ends(hello || abort),
    .forgets(forget),
    .busy,
    .meshes_empty(count_a == '0 && count_b == '0),
    .near_fit(ring_written - ring_freed <= 32'(u_ring.Entries)),
    .free,
    .free_to(ring_number),
    .asked(request[0].fields[31:0]),
    .tries(trial.kind != triaxis_mesh_pkg::TrialNothing),
    .acknowledges(hello),
    .fault,
    .done,
    .clear(done_status == triaxis_mesh_pkg::StatusComplete && near_count == '0),
    .hold(runs[0].hold),
    .wrong(link_error || refused || alive != '1),
    .go_o,
    .stop_o,
    .beat_o,
    .beyond_slow_o,
    .beyond_warn_o
);
