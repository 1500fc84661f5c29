// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The comparison of a certificate, registers included, against its specification: the lowest projection of
// B lies above the highest of A, whose first is 0, by more than the reach, or the other way round, as whole
// numbers. Nine = 1: of the nine differences of a projection of B and one of A all exceed the reach, or all
// of their negatives do. Projections and the reach, three clocks after them, are free, but for the promise
// that differences fit.

`include "triaxis_formal.svh"

module triaxis_apart_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter bit Nine = 1'b1
) (
    input logic clk_i,
    input logic signed [span_width(W)-1:0] a_i[2],
    input logic signed [span_width(W)-1:0] b_i[3],
    input logic [axis_threshold_width(W, M)-1:0] reach_i
);

  localparam int unsigned Size = span_width(W);
  localparam int unsigned ReachWait = 3;
  // Two bits more than anything that is compared.
  typedef logic signed [Size+1:0] wide_t;
  localparam wide_t Beyond = wide_t'(1) <<< (Size - 1);
  // Of a pair: its projections, all of A and all of B.
  typedef struct packed {
    logic signed [2:0][Size-1:0] a;
    logic signed [2:0][Size-1:0] b;
  } pair_t;
  // What is to be said of a pair, and what it shows.
  typedef struct packed {
    logic apart;
    logic above;
    logic below;
    logic touching;
    logic moved;
  } specified_t;

  logic apart_o;

  triaxis_apart #(
      .W(W),
      .M(M)
  ) u_apart (
      .*
  );

  function automatic wide_t highest(logic signed [2:0][Size-1:0] of);
    highest = wide_t'(signed'(of[0]));
    for (int i = 1; i < 3; i++) begin
      if (wide_t'(signed'(of[i])) > highest) highest = wide_t'(signed'(of[i]));
    end
  endfunction

  function automatic wide_t lowest(logic signed [2:0][Size-1:0] of);
    lowest = wide_t'(signed'(of[0]));
    for (int i = 1; i < 3; i++) begin
      if (wide_t'(signed'(of[i])) < lowest) lowest = wide_t'(signed'(of[i]));
    end
  endfunction

  pair_t pair, due;
  assign pair = '{a: {a_i[1], a_i[0], Size'(0)}, b: {b_i[2], b_i[1], b_i[0]}};
  `TRIAXIS_PAST(pair_t, pair_q, pair, ReachWait)
  `TRIAXIS_FULL_AFTER(ApartLatency)
  assign due = pair_q[ReachWait-1];
  always_comb begin
    // So all nine differences do, and their negatives.
    Fits :
    assume (highest(pair.b) - lowest(pair.a) < Beyond && highest(pair.a) - lowest(pair.b) < Beyond);
    NoMargin : assume (M != 0 || reach_i == '0);
  end

  // The reach is there with the gaps.
  wide_t reach, gap_above, gap_below, difference;
  specified_t specified;
  always_comb begin
    reach = (M == 0) ? '0 : wide_t'({1'b0, reach_i});
    gap_above = lowest(due.b) - highest(due.a);
    gap_below = lowest(due.a) - highest(due.b);
    difference = '0;
    specified.above = gap_above > reach;
    specified.below = gap_below > reach;
    specified.touching = gap_above == reach || gap_below == reach;
    specified.moved = M == 0 || reach != '0;
    if (Nine) begin
      specified.above = 1'b1;
      specified.below = 1'b1;
      for (int i = 0; i < 3; i++) begin
        for (int j = 0; j < 3; j++) begin
          difference = wide_t'(signed'(due.b[j])) - wide_t'(signed'(due.a[i]));
          specified.above &= difference > reach;
          specified.below &= -difference > reach;
        end
      end
    end
    specified.apart = specified.above || specified.below;
  end

  `TRIAXIS_PAST(specified_t, specified_q, specified, ApartLatency - ReachWait)
  always_comb begin
    if (full) begin
      Apart : assert (apart_o == specified_q[0].apart);
      SeenAbove : cover (specified_q[0].above && specified_q[0].moved);
      SeenBelow : cover (specified_q[0].below && specified_q[0].moved);
      SeenTouching : cover (specified_q[0].touching && specified_q[0].moved && !apart_o);
    end
  end

endmodule
