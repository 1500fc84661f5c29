// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: near(A, B, m) for one pair per clock, AXI4-Stream in and out. The pipeline never
// stalls: a pair is accepted only while the result queue has a place for it, so back-pressure loses
// nothing and no enable fans out over the multipliers.
//   s_axis_tdata_i   18 coordinates of W bits, lowest first: A1 x y z, A2, A3, B1, B2, B3; then
//                    zeros up to the next byte
//   s_axis_tuser_i   {tag, margin}; only the tag where M = 0
//   m_axis_tdata_o   {3'b0, axis[4:0], 4'b0, degenerate_b, degenerate_a, coplanar, near}
//   m_axis_tuser_o   the tag
// Widths: see triaxis_pkg. At most Depth pairs are in flight, so log2(Depth)+1 bits count them.
// Latency: core_latency(W, M) clocks from the accepting edge to the first edge at which the result
// can be taken.

module triaxis_core
  import triaxis_pkg::*;
#(
    parameter int unsigned W = 16,  // coordinate bits, 8..32
    parameter int unsigned M = 0,  // margin bits, 0..W; 0: collision only
    parameter int unsigned TAG = 16,  // tag bits, at least 1
    parameter bit EdgeBox = 1'b1,  // 0: coplanar pairs answer near (needs M = 0)
    parameter bit Gating = 1'b1,  // 0: flags also for pairs that their boxes decide
    localparam int unsigned DataWidth = 8 * ((18 * W + 7) / 8)
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axis_tvalid_i,
    output logic s_axis_tready_o,
    input logic [DataWidth-1:0] s_axis_tdata_i,
    input logic [TAG+M-1:0] s_axis_tuser_i,

    output logic m_axis_tvalid_o,
    input logic m_axis_tready_i,
    output logic [15:0] m_axis_tdata_o,
    output logic [TAG-1:0] m_axis_tuser_o
);

  localparam int unsigned Latency = datapath_latency(W, M);
  localparam int unsigned Depth = 2 ** $clog2(core_latency(W, M));
  typedef logic [$clog2(Depth):0] count_t;
  typedef logic signed [W-1:0] coord_t;
  typedef logic [TAG-1:0] tag_t;
  typedef struct packed {
    tag_t tag;
    verdict_t verdict;
  } result_t;

  if (TAG == 0 || TAG > 64) begin : g_bad_tag
    $fatal(1, "TAG must be 1..64");
  end

  logic accept, deliver;
  assign accept  = s_axis_tvalid_i && s_axis_tready_o;
  assign deliver = m_axis_tvalid_o && m_axis_tready_i;

  // --- Input --------------------------------------------------------------------------------------

  coord_t a[3][3], b[3][3];
  for (genvar v = 0; v < 3; v++) begin : g_vertex
    for (genvar k = 0; k < 3; k++) begin : g_coordinate
      assign a[v][k] = s_axis_tdata_i[(3*v+k)*W+:W];
      assign b[v][k] = s_axis_tdata_i[(9+3*v+k)*W+:W];
    end
  end
  if (DataWidth > 18 * W) begin : g_padding
    logic unused_padding;
    assign unused_padding = ^s_axis_tdata_i[DataWidth-1:18*W];
  end

  tag_t tag;
  assign tag = s_axis_tuser_i[M+:TAG];
  logic [margin_width(M)-1:0] margin;
  if (M == 0) begin : g_no_margin
    assign margin = '0;
  end else begin : g_margin
    assign margin = s_axis_tuser_i[M-1:0];
  end

  // --- Pipeline -------------------------------------------------------------------------------------

  result_t result;

  triaxis_datapath #(
      .W(W),
      .M(M),
      .EdgeBox(EdgeBox),
      .Gating(Gating)
  ) u_datapath (
      .clk_i,
      .valid_i(accept),
      .a_i(a),
      .b_i(b),
      .margin_i(margin),
      .verdict_o(result.verdict)
  );

  triaxis_delay #(
      .T(tag_t),
      .Cycles(Latency)
  ) u_tag (
      .clk_i,
      .d_i(tag),
      .q_o(result.tag)
  );

  logic [Latency-1:0] valid_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) valid_q <= '0;
    else valid_q <= {valid_q[Latency-2:0], accept};
  end

  // --- Result queue ---------------------------------------------------------------------------------

  result_t oldest;

  triaxis_fifo #(
      .T(result_t),
      .Depth(Depth)
  ) u_results (
      .clk_i,
      .rst_ni,
      .push_i (valid_q[Latency-1]),
      .data_i (result),
      .pop_i  (deliver),
      .valid_o(m_axis_tvalid_o),
      .data_o (oldest)
  );

  assign m_axis_tuser_o = oldest.tag;
  assign m_axis_tdata_o = {
    3'b0,
    oldest.verdict.axis,
    4'b0,
    oldest.verdict.degenerate_b,
    oldest.verdict.degenerate_a,
    oldest.verdict.coplanar,
    oldest.verdict.is_near
  };

  // Pairs accepted and not yet delivered; never more than the queue holds. No pair is accepted in
  // reset.
  count_t in_flight_q;
  logic   awake_q;
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      in_flight_q <= '0;
      awake_q <= 1'b0;
    end else begin
      awake_q <= 1'b1;
      if (accept && !deliver) in_flight_q <= in_flight_q + count_t'(1);
      else if (deliver && !accept) in_flight_q <= in_flight_q - count_t'(1);
    end
  end

  assign s_axis_tready_o = awake_q && (in_flight_q != count_t'(Depth));

endmodule
