// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: as triaxis_core, near(A, B, m) for one pair per clock; and shows each "clear" again before it
// gives it. What it cannot show is near, and a fault:
//   - the claim of the core, by another way, from vertices that waited elsewhere (triaxis_certifier);
//   - the pair and its result, by parity of all that is kept of them;
//   - their order, by a number that goes through the core in place of the tag and is counted again at the end.
// So no single wrong bit of a pair that was accepted, of a claim on it or of its result makes a "clear" of a
// pair that is near; and each of these checks can be tried on the running core.
//   s_axis_tdata_i   as of triaxis_core
//   s_axis_tuser_i   {try_t, tag, margin}; {try_t, tag} where M = 0; TryNothing in use
//   m_axis_tdata_o   {3'b0, axis[4:0], 3'b0, fault, degenerate_b, degenerate_a, coplanar, near}
//   m_axis_tuser_o   the tag
// Widths: see triaxis_pkg. At most Depth pairs are in flight; a number has one bit more than a place among
// these, so that a word that was left is known as such.
// Latency: certified_latency(W, M) clocks from the accepting edge to the first edge at which the result can
// be taken.

module triaxis_certified_core
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned M = 0,
    parameter int unsigned TAG = 16,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1,
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_tvalid_i,
    output logic s_axis_tready_o,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [$bits(try_t)+TAG+M-1:0] s_axis_tuser_i,

    output logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    output logic [15:0] m_axis_tdata_o,
    output logic [TAG-1:0] m_axis_tuser_o
);

  if (TAG == 0 || TAG > 64 - $bits(try_t)) begin : g_bad_tag
    $fatal(1, "TAG must be 1..57: what goes with a pair has at most 64 bits");
  end

  localparam int unsigned Depth = 2 ** $clog2(certified_latency(W, M));
  localparam int unsigned PlaceWidth = $clog2(Depth);
  localparam int unsigned Wait = certifier_latency(W);
  // Parity bits by number: of coordinate n, of the rest of the pair, of its result.
  localparam int unsigned ParityRest = 18;
  localparam int unsigned ParityResult = 31;
  typedef logic signed [W-1:0] coord_t;
  typedef logic [TAG-1:0] tag_t;
  typedef logic [PlaceWidth:0] number_t;
  typedef logic [margin_width(M)-1:0] margin_t;

  typedef logic [ParityRest:0] parity_t;

  typedef struct packed {
    logic wrap;  // of the pair's number: its place is where it is kept
    try_t attempt;
    tag_t tag;
    margin_t margin;
    logic [ParityRest-1:0][W-1:0] coordinates;
  } pair_t;

  // What is known of a result while its claim is looked at.
  typedef struct packed {
    number_t number;
    tag_t tag;
    verdict_t claim;
    logic intact;
    logic spoil;  // its parity, on trial
    logic parity;  // of number and tag
  } claim_t;

  typedef struct packed {
    number_t number;
    tag_t tag;
    logic fault;
    verdict_t verdict;
  } result_t;

  typedef struct packed {
    parity_t parity;
    pair_t   pair;
  } kept_pair_t;

  typedef struct packed {
    logic parity;
    result_t result;
  } kept_result_t;

  // --- The pair, as it is kept -----------------------------------------------------------------------

  logic accept, deliver, free, offered, core_ready;
  number_t accepted_q, delivered_q, in_flight;
  assign in_flight = accepted_q - delivered_q;
  assign free = in_flight != number_t'(Depth);
  assign s_axis_tready_o = core_ready && free;
  assign offered = s_axis_tvalid_i && free;
  assign accept = s_axis_tvalid_i && s_axis_tready_o;
  assign deliver = m_axis_tvalid_o && m_axis_tready_i;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      accepted_q  <= '0;
      delivered_q <= '0;
    end else begin
      if (accept) accepted_q <= accepted_q + number_t'(1);
      if (deliver) delivered_q <= delivered_q + number_t'(1);
    end
  end

  // Without margins a bit that nothing looks at.
  margin_t margin;
  assign margin = s_axis_tuser_i[$bits(margin_t)-1:0];
  logic [PlaceWidth+M-1:0] core_user;
  if (M == 0) begin : g_no_margin
    assign core_user = accepted_q[PlaceWidth-1:0];
  end else begin : g_margin
    assign core_user = {accepted_q[PlaceWidth-1:0], margin};
  end

  function automatic parity_t parity_of(pair_t pair);
    for (int unsigned i = 0; i < ParityRest; i++) parity_of[i] = ^pair.coordinates[i];
    parity_of[ParityRest] = ^{pair.wrap, pair.attempt, pair.tag, pair.margin};
  endfunction

  pair_t pair;
  kept_pair_t kept_d, kept_q, pairs_q[Depth];
  parity_t spoilt;
  assign pair.wrap = accepted_q[PlaceWidth];
  assign {pair.attempt, pair.tag} = s_axis_tuser_i[M+:$bits(try_t)+TAG];
  assign pair.margin = margin;
  assign pair.coordinates = s_axis_tdata_i[18*W-1:0];
  assign spoilt = (pair.attempt.kind == TryParity) ? parity_t'(1) << pair.attempt.which : '0;
  // What is not on offer is not intact: a result that comes without its pair finds none.
  assign kept_d.parity = parity_of(pair) ^ spoilt ^ parity_t'(!s_axis_tvalid_i);
  assign kept_d.pair = pair;
  // What is on offer is written until it is accepted: its place is free, as the pair that had it was read at
  // the core's latency, Depth clocks ago or more.
  always_ff @(posedge clk_i) pairs_q[accepted_q[PlaceWidth-1:0]] <= kept_d;

  // --- The core's claim, with the pair that it names -------------------------------------------------

  logic core_valid, claim_valid_q, holds;
  logic [15:0] core_word;
  logic [PlaceWidth-1:0] core_place, place_q;
  verdict_t verdict_q;
  claim_t   claim;

  triaxis_core #(
      .W(W),
      .M(M),
      .TAG(PlaceWidth),
      .EdgeBox(EdgeBox),
      .Gating(Gating)
  ) u_core (
      .clk_i,
      .rst_ni,
      .s_axis_tvalid_i(offered),
      .s_axis_tready_o(core_ready),
      .s_axis_tdata_i,
      .s_axis_tuser_i (core_user),
      .m_axis_tvalid_o(core_valid),
      .m_axis_tready_i(1'b1),
      .m_axis_tdata_o (core_word),
      .m_axis_tuser_o (core_place)
  );

  always_ff @(posedge clk_i) begin
    kept_q <= pairs_q[core_place];
    place_q <= core_place;
    verdict_q <= {core_word[12:8], core_word[3:0]};
  end
  logic unused_zeros;
  assign unused_zeros = ^{core_word[15:13], core_word[7:4]};

  always_comb begin
    claim.number = {kept_q.pair.wrap, place_q};
    claim.tag = kept_q.pair.tag;
    claim.claim = verdict_q;
    claim.intact = kept_q.parity == parity_of(kept_q.pair);
    claim.spoil = 1'b0;
    case (kept_q.pair.attempt.kind)
      TryClaim: begin
        claim.claim.is_near = 1'b0;
        claim.claim.axis = kept_q.pair.attempt.which;
      end
      TryParity: claim.spoil = kept_q.pair.attempt.which == axis_t'(ParityResult);
      TryNumber: claim.number ^= number_t'(1) << kept_q.pair.attempt.which[2:0];
      default:   ;
    endcase
    claim.parity = (^claim.number) ^ (^claim.tag);
  end

  coord_t a[3][3], b[3][3];
  for (genvar v = 0; v < 3; v++) begin : g_vertex
    for (genvar k = 0; k < 3; k++) begin : g_coordinate
      assign a[v][k] = kept_q.pair.coordinates[3*v+k];
      assign b[v][k] = kept_q.pair.coordinates[9+3*v+k];
    end
  end

  triaxis_certifier #(
      .W(W),
      .M(M)
  ) u_certifier (
      .clk_i,
      .a_i(a),
      .b_i(b),
      .margin_i(kept_q.pair.margin),
      .axis_i(claim.claim.axis),
      .holds_o(holds)
  );

  // --- The result --------------------------------------------------------------------------------------

  logic   [Wait-1:0] valid_q;
  (* srl_style = "srl_reg" *)claim_t [Wait-1:0] claims_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {valid_q, claim_valid_q} <= '0;
    else {valid_q, claim_valid_q} <= {valid_q[Wait-2:0], claim_valid_q, core_valid};
  end
  always_ff @(posedge clk_i) claims_q <= {claims_q[Wait-2:0], claim};

  claim_t shown;
  kept_result_t made, oldest;
  logic result_parity, sound;
  assign shown = claims_q[Wait-1];
  always_comb begin
    made.result.number = shown.number;
    made.result.tag = shown.tag;
    made.result.fault = !shown.intact || (!shown.claim.is_near && !holds);
    made.result.verdict = shown.claim;
    if (made.result.fault) begin
      made.result.verdict.is_near = 1'b1;
      made.result.verdict.axis = '0;
    end
    made.parity = (^made.result.verdict) ^ made.result.fault ^ shown.parity ^ shown.spoil;
  end

  triaxis_fifo #(
      .T(kept_result_t),
      .Depth(Depth)
  ) u_results (
      .clk_i,
      .rst_ni,
      .push_i (valid_q[Wait-1]),
      .data_i (made),
      .pop_i  (deliver),
      .valid_o(m_axis_tvalid_o),
      .data_o (oldest)
  );

  assign result_parity = ^oldest.result;
  assign sound = oldest.parity == result_parity && oldest.result.number == delivered_q;
  assign m_axis_tuser_o = oldest.result.tag;
  assign m_axis_tdata_o = {
    3'b0,
    sound ? oldest.result.verdict.axis : axis_t'(0),
    3'b0,
    oldest.result.fault || !sound,
    oldest.result.verdict.degenerate_b,
    oldest.result.verdict.degenerate_a,
    oldest.result.verdict.coplanar,
    oldest.result.verdict.is_near || !sound
  };

endmodule
