// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The certified core with its rules, and what makes them inductive: where the followed pair is, at
// each age. What the data path and the certifier say of that pair is chosen when it is accepted
// (verdict_i, holds_i) and assumed when it is due: the stand-ins are free then, so nothing is
// excluded.
// With Upset one bit of what is kept or carried is inverted, once, in a copy of the core that has masks
// free_* where words are looked at: an inverted bit makes no difference before. Then the followed pair
// is near in truth, so nothing holds of it.

`include "triaxis_formal.svh"

module triaxis_certified_core_formal
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 16,
    parameter int unsigned TAG = 16,
    parameter bit Upset = 1'b0,
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,
    input logic mark_i,
    input verdict_t verdict_i,
    input logic holds_i,
    input logic strike_i,
    input logic [8:0] strike_at_i,
    input logic s_axis_tvalid_i,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [$bits(try_t)+TAG+M-1:0] s_axis_tuser_i,
    input logic m_axis_tready_i
);

  localparam int unsigned Latency = certified_latency(W, M);
  localparam int unsigned Stages = Latency - 1;
  localparam int unsigned Depth = 2 ** $clog2(Latency);
  localparam int unsigned PlaceWidth = $clog2(Depth);
  // Ages of a pair: its verdict is there; what is kept of it is read; the certifier has it; the
  // certifier has answered.
  localparam int unsigned Claimed = datapath_latency(W, M);
  localparam int unsigned Read = core_latency(W, M);
  localparam int unsigned Given = Read + 1;
  localparam int unsigned Shown = Given + certifier_latency(W);
  // Of a claim, and of a result in its queue.
  localparam int unsigned ResultBits = PlaceWidth + 1 + TAG + $bits(verdict_t) + 2;
  localparam int unsigned CarriedBits = ResultBits + 1;
  typedef logic [PlaceWidth:0] number_t;
  typedef logic [PlaceWidth-1:0] place_t;
  typedef logic [$clog2(Read):0] core_count_t;
  typedef logic [$clog2(Latency+2)-1:0] age_t;
  typedef logic [TAG-1:0] tag_t;
  typedef logic [margin_width(M)-1:0] margin_t;
  typedef logic [18*W-1:0] vertices_t;
  // As the module numbers parity bits.
  localparam int unsigned NumCoordinates = 18;
  localparam int unsigned ParityRest = 18;
  localparam int unsigned ParityResult = 31;
  typedef logic [ParityRest:0] parity_t;

  logic s_axis_tready_o, m_axis_tvalid_o;
  logic [15:0] m_axis_tdata_o;
  tag_t m_axis_tuser_o;

  triaxis_certified_core #(
      .W  (W),
      .M  (M),
      .TAG(TAG)
  ) u_certified (
      .*
  );

  // --- What a pair is to be answered with -----------------------------------------------------------

  function automatic verdict_t claim_of(verdict_t verdict, try_t attempt);
    claim_of = verdict;
    if (attempt.kind == TryClaim) begin
      claim_of.is_near = 1'b0;
      claim_of.axis = attempt.which;
    end
  endfunction

  function automatic logic pair_spoilt(try_t attempt);
    return attempt.kind == TryParity && attempt.which <= axis_t'(ParityRest);
  endfunction

  function automatic logic result_spoilt(try_t attempt);
    return attempt.kind == TryParity && attempt.which == axis_t'(ParityResult);
  endfunction

  function automatic logic number_changed(try_t attempt);
    return attempt.kind == TryNumber && attempt.which[2:0] <= 3'(PlaceWidth);
  endfunction

  // A claim that is not shown, or a pair that is not what was accepted.
  function automatic logic refuted(verdict_t verdict, logic holds, try_t attempt);
    verdict_t claim;
    claim = claim_of(verdict, attempt);
    return pair_spoilt(attempt) || (!claim.is_near && !holds);
  endfunction

  function automatic logic [15:0] word(verdict_t verdict, logic holds, try_t attempt);
    verdict_t claim;
    logic fault;
    claim = claim_of(verdict, attempt);
    fault = refuted(verdict, holds, attempt) || result_spoilt(attempt) || number_changed(attempt);
    return {
      3'b0,
      fault ? axis_t'(0) : claim.axis,
      3'b0,
      fault,
      claim.degenerate_b,
      claim.degenerate_a,
      claim.coplanar,
      claim.is_near || fault
    };
  endfunction

  try_t attempt;
  tag_t tag;
  margin_t margin;
  vertices_t vertices;
  assign {attempt, tag} = s_axis_tuser_i[M+:$bits(try_t)+TAG];
  if (M == 0) begin : g_no_margin
    assign margin = s_axis_tuser_i[0];
  end else begin : g_margin
    assign margin = s_axis_tuser_i[M-1:0];
  end
  assign vertices = s_axis_tdata_i[18*W-1:0];

  // Of an upset only what it makes of a near pair counts.
  localparam int unsigned ResultWidth = Upset ? 1 : TAG + 16;
  logic [ResultWidth-1:0] result, due;
  if (Upset) begin : g_safe_result
    assign result = m_axis_tdata_o[0];
    assign due = 1'b1;
  end else begin : g_whole_result
    assign result = {m_axis_tuser_o, m_axis_tdata_o};
    assign due = {tag, word(verdict_i, holds_i, attempt)};
  end

  triaxis_stream_rules #(
      .Depth(Depth),
      .Latency(Latency),
      .ResultWidth(ResultWidth)
  ) u_rules (
      .clk_i,
      .rst_ni,
      .s_valid_i(s_axis_tvalid_i),
      .s_ready_i(s_axis_tready_o),
      .m_valid_i(m_axis_tvalid_o),
      .m_ready_i(m_axis_tready_i),
      .result_i (result),
      .due_i    (due),
      .mark_i
  );

  logic following, first;
  number_t ahead, count;
  age_t age;
  assign following = u_rules.following_q;
  assign ahead = u_rules.ahead_q;
  assign count = u_rules.count_q;
  assign age = u_rules.age_q;
  assign first = following && ahead == '0 && m_axis_tvalid_o;

  `TRIAXIS_RESET_FIRST

  // The followed pair, as it was accepted.
  try_t attempt_q;
  tag_t tag_q;
  margin_t margin_q;
  vertices_t vertices_q;
  verdict_t verdict_q;
  logic holds_q;
  number_t accepted_q, followed_q;
  always_ff @(posedge clk_i) begin
    if (!following && u_rules.accept && mark_i) begin
      attempt_q <= attempt;
      tag_q <= tag;
      margin_q <= margin;
      vertices_q <= vertices;
      verdict_q <= verdict_i;
      holds_q <= holds_i;
      followed_q <= accepted_q;
    end
  end

  // --- Order ------------------------------------------------------------------------------------------

  // Ghosts: pairs accepted in the clock that each stage has its pair from, if it has one, and since.
  number_t since_q[Stages];
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      accepted_q <= '0;
      since_q <= '{default: '0};
    end else begin
      accepted_q <= accepted_q + number_t'(u_rules.accept);
      since_q[0] <= number_t'(u_rules.accept);
      for (int i = 1; i < int'(Stages); i++) begin
        since_q[i] <= since_q[i-1] + number_t'(u_rules.accept);
      end
    end
  end

  logic [Stages-1:0] valid;
  number_t delivered, written, queued, piped;
  core_count_t core_read, core_written, core_count;
  assign valid = {
    u_certified.valid_q,
    u_certified.claim_valid_q,
    u_certified.core_valid,
    u_certified.u_core.valid_q
  };
  assign delivered = u_certified.u_results.read_q;
  assign written = u_certified.u_results.write_q;
  assign queued = written - delivered;
  assign piped = accepted_q - written;
  assign core_read = u_certified.u_core.u_results.read_q;
  assign core_written = u_certified.u_core.u_results.write_q;
  assign core_count = u_certified.u_core.in_flight_q;

  number_t since_followed;
  logic chained, bounded, ordered;
  assign since_followed = accepted_q - followed_q;
  always_comb begin
    chained = since_q[0] == number_t'(valid[0]) && since_q[Stages-1] == piped;
    for (int i = 1; i < int'(Stages); i++) begin
      chained &= since_q[i] == since_q[i-1] + number_t'(valid[i]);
    end
    bounded = 1'b1;
    ordered = 1'b1;
    for (int i = 0; i < int'(Stages); i++) begin
      bounded &= since_q[i] <= number_t'(i + 1);
      ordered &= i + 1 < int'(age) || since_q[i] >= since_followed;
    end
  end

  // The verdict and the place as the core has them in its queue.
  logic [PlaceWidth+$bits(verdict_t)-1:0] core_result;
  place_t place, place_at[Claimed];
  assign place = place_t'(followed_q);
  for (genvar i = 0; i < Claimed; i++) begin : g_place
    assign place_at[i] = u_certified.u_core.u_tag.g_regs.g_stage[i].stage_q;
  end
  assign core_result = u_certified.u_core.u_results.memory_q[core_read[$clog2(Read)-1:0]];

  // The pair as it is kept.
  logic [$bits(parity_t)+1+$bits(try_t)+TAG+$bits(margin_t)+$bits(vertices_t)-1:0] kept;
  parity_t parity;
  always_comb begin
    for (int n = 0; n < int'(NumCoordinates); n++) parity[n] = ^vertices_q[n*W+:W];
    parity[ParityRest] = ^{followed_q[PlaceWidth], attempt_q, tag_q, margin_q};
    if (pair_spoilt(attempt_q)) parity[attempt_q.which] = !parity[attempt_q.which];
    kept = {parity, followed_q[PlaceWidth], attempt_q, tag_q, margin_q, vertices_q};
  end

  // What is kept where nothing is on offer: as it would be of a pair.
  parity_t of_offered;
  always_comb begin
    for (int n = 0; n < int'(NumCoordinates); n++) begin
      of_offered[n] = ^vertices[n*W+:W];
    end
    of_offered[ParityRest] = ^{u_certified.accepted_q[PlaceWidth], attempt, tag, margin};
  end

  // What the certifier is given.
  vertices_t given;
  for (genvar v = 0; v < 3; v++) begin : g_vertex
    for (genvar k = 0; k < 3; k++) begin : g_coordinate
      assign given[(3*v+k)*W+:W]   = u_certified.u_certifier.a_i[v][k];
      assign given[(9+3*v+k)*W+:W] = u_certified.u_certifier.b_i[v][k];
    end
  end
  logic is_given, own_kept;
  assign is_given = given == vertices_q && u_certified.u_certifier.margin_i == margin_q;
  assign own_kept = u_certified.kept_q == kept && u_certified.place_q == place;

  always_comb begin
    if (rst_ni) begin
      NotOffered :
      assert (s_axis_tvalid_i || attempt.kind == TryParity ||
          u_certified.kept_d.parity != of_offered);
      NumbersKnown : assert (u_certified.accepted_q == accepted_q);
      CountKnown : assert (u_certified.delivered_q == delivered);
      Chained : assert (chained);
      Bounded : assert (bounded);
      Conserved : assert (count == piped + queued && count >= queued && count <= number_t'(Depth));
      NoPushIntoFull : assert (!u_certified.u_results.push_i || queued != number_t'(Depth));
      CoreCounted : assert (core_count == core_count_t'(since_q[Read-1]));
      AwakeKnown : assert (u_certified.u_core.awake_q == u_rules.awake_q);
      CoreQueue : assert (core_count_t'(core_written - core_read) <= core_count_t'(1));
      EagerQueue : assert (!u_rules.eager_q || queued <= number_t'(1));
      Waited : assert (!u_rules.waited_q || (queued != '0 && u_rules.result_q == result));
      if (following) begin
        AgeKnown : assert (age != '0 && age <= age_t'(Latency));
        AheadKnown : assert (ahead == followed_q - delivered && ahead < count);
        Ordered : assert (age == age_t'(Latency) || ordered);
        InPipe :
        assert (age == age_t'(Latency) ||
            (valid[age-1] && since_q[age-1] == since_followed && ahead >= queued));
        InQueue : assert (age != age_t'(Latency) || ahead < queued);
        KeptPair : assert (age > age_t'(Read) || u_certified.pairs_q[place] == kept);
        CoreCarriesPlace : assert (age > age_t'(Claimed) || place_at[age-1] == place);
      end
    end
  end

  if (!Upset) begin : g_exact
    number_t number;
    logic fault, result_parity;
    verdict_t claim, told;
    logic [CarriedBits-1:0] carried;
    logic [ ResultBits-2:0] made;
    always_comb begin
      number = followed_q;
      if (number_changed(attempt_q)) number[attempt_q.which[2:0]] = !number[attempt_q.which[2:0]];
      claim = claim_of(verdict_q, attempt_q);
      carried = {
        number, tag_q, claim, !pair_spoilt(attempt_q), result_spoilt(attempt_q), ^{number, tag_q}
      };
      fault = refuted(verdict_q, holds_q, attempt_q);
      told = claim;
      if (fault) begin
        told.is_near = 1'b1;
        told.axis = '0;
      end
      made = {number, tag_q, fault, told};
      result_parity = ^made ^ result_spoilt(attempt_q);
    end

    logic moved_on;
    always_comb begin
      moved_on = 1'b1;
      for (int i = Given + 1; i <= int'(Shown); i++) begin
        moved_on &= age != age_t'(i) || u_certified.claims_q[i-int'(Given+1)] == carried;
      end
    end
    always_comb begin
      if (following) begin
        VerdictAsChosen :
        assume (age != age_t'(Claimed) || u_certified.u_core.u_datapath.verdict_o == verdict_q);
        AnswerAsChosen :
        assume (age != age_t'(Shown) || u_certified.u_certifier.holds_o == holds_q);
      end
      if (rst_ni && following) begin
        GivenThePair :
        assert (age != age_t'(Given) || (is_given && u_certified.u_certifier.axis_i == claim.axis));
        InCoreQueue : assert (age != age_t'(Read) || core_result == {place, verdict_q});
        KeptWithClaim :
        assert (age != age_t'(Given) || (own_kept && u_certified.verdict_q == verdict_q));
        Carried : assert (moved_on);
        Made :
        assert (age != age_t'(Latency) ||
            u_certified.u_results.memory_q[place] == {result_parity, made});
        DueKnown : assert (u_rules.due_q == {tag_q, word(verdict_q, holds_q, attempt_q)});
        ClearIsShown : assert (!first || m_axis_tdata_o[0] || (holds_q && !claim.is_near));
        NoFaultOfItself :
        assert (!first || !m_axis_tdata_o[4] || attempt_q.kind != TryNothing ||
            (!verdict_q.is_near && !holds_q));
        SeenClear : cover (first && !m_axis_tdata_o[0] && attempt_q.kind == TryNothing);
        SeenClaimTried :
        cover (first && !m_axis_tdata_o[0] && attempt_q.kind == TryClaim && verdict_q.is_near);
        SeenRefuted : cover (first && m_axis_tdata_o[4] && attempt_q.kind == TryNothing);
        SeenParityTried :
        cover (first && m_axis_tdata_o[4] && attempt_q.kind == TryParity && holds_q);
        SeenNumberTried :
        cover (first && m_axis_tdata_o[4] && attempt_q.kind == TryNumber && holds_q);
      end
    end
  end else begin : g_upset
    localparam int unsigned MaskBits = $bits(kept) + 2 * PlaceWidth + CarriedBits + ResultBits;
    logic [MaskBits-1:0] mask;
    logic struck_q = 1'b0;
    logic given_q;
    // The place that a pair is taken from in place of its own, if any is.
    place_t other_q;
    assign mask = {
      u_certified.free_kept,
      u_certified.free_place,
      u_certified.free_late_place,
      u_certified.free_claim,
      u_certified.free_result
    };
    always_ff @(posedge clk_i) begin
      other_q <= other_q;
      if (strike_i) struck_q <= 1'b1;
      if (age == age_t'(Given)) given_q <= is_given;
    end

    // Whether each claim on its way is that of the followed pair, or will be seen not to be.
    logic [certifier_latency(W)-1:0] own, seen;
    logic moved_on;
    for (genvar i = 0; i < certifier_latency(W); i++) begin : g_claim
      logic intact, numbered, even;
      assign intact = u_certified.claims_q[i].intact;
      assign numbered = u_certified.claims_q[i].number == followed_q;
      assign even = u_certified.claims_q[i].parity ==
          ^{u_certified.claims_q[i].number, u_certified.claims_q[i].tag};
      assign own[i] = given_q && intact && numbered && even && !u_certified.claims_q[i].spoil;
      assign seen[i] = struck_q && (!intact || !numbered);
    end
    always_comb begin
      moved_on = 1'b1;
      for (int i = 0; i < int'(certifier_latency(W)); i++) begin
        moved_on &= age != age_t'(int'(Given) + 1 + i) || own[i] || seen[i];
      end
    end

    // The same of its result.
    logic near_or_seen;
    assign near_or_seen = u_certified.u_results.memory_q[place].result.verdict.is_near ||
        u_certified.u_results.memory_q[place].result.number != followed_q ||
        u_certified.u_results.memory_q[place].parity !=
        ^u_certified.u_results.memory_q[place].result;

    always_comb begin
      OneBit : assume (mask == (strike_i ? MaskBits'(1) << strike_at_i : '0));
      Once : assume (!strike_i || !struck_q);
      TriesNothing : assume (attempt.kind == TryNothing);
      // Memories are zeros at power-up.
      NothingTried :
      assume (started_q || u_certified.pairs_q[other_q].pair.attempt.kind == TryNothing);
      OtherPlace : assume (u_certified.free_place == '0 || u_certified.core_place == other_q);
      NearInTruth :
      assume (!following || age != age_t'(Shown) || !given_q || !u_certified.u_certifier.holds_o);
      if (started_q) begin
        NoneTries : assert (u_certified.pairs_q[other_q].pair.attempt.kind == TryNothing);
      end
      if (rst_ni && following) begin
        TriedNothing : assert (attempt_q.kind == TryNothing);
        InCoreQueue :
        assert (age != age_t'(Read) || core_result[$bits(verdict_t)+:PlaceWidth] == place);
        KeptOrSeen :
        assert (age != age_t'(Given) || own_kept || (struck_q && (!u_certified.claim.intact ||
            u_certified.claim.number != followed_q)));
        CarriedOrSeen : assert (moved_on);
        MadeOrSeen : assert (age != age_t'(Latency) || near_or_seen);
        DueKnown : assert (u_rules.due_q == 1'b1);
        SeenStruck : cover (first && struck_q && m_axis_tdata_o[4]);
      end
    end
  end

endmodule
