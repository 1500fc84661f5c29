// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: what the registers of triaxis_soc.rdl say, from the mesh engine: AXI4-Lite around triaxis_mesh, for
// systems with a processor. Decides nothing about triangles.
// A write to LOAD or RUN is answered when the engine has taken it. It is answered at once and refused during a run,
// which may be long, so that the bus is never held up for longer than the engine takes to settle; and where a
// number does not fit the engine, as what is cut off could be clear. A result is always that of the meshes as they
// are meant to be: it is void as soon as something was loaded or refused after its begin, or a check failed; and a
// mesh that lacks what was refused, or met a fault, has to be emptied before the next run.
// Widths: registers have 32 bits. A coordinate has W of them, a margin M, a move W + 1: with W = 32 moves beyond
// 2^31 - 1 cannot be asked for. Counts of pairs have 2 log2(Depth) + 1 bits, at most 31 with Depth <= 32768.
// Latency: a read is answered two clocks after its address, NEAR_PAIR one more.

module triaxis_soc
  import triaxis_mesh_pkg::*;
  import triaxis_soc_regs_pkg::*;
#(
    parameter int unsigned W = 16,  // as in triaxis_mesh, as are all but:
    parameter int unsigned M = 16,
    parameter int unsigned Depth = 1024,  // 16..32768
    parameter int unsigned Group = 8,
    parameter int unsigned Lanes = 8,
    parameter bit EdgeBox = 1'b1,
    parameter bit Gating = 1'b1,
    parameter bit Certify = 1'b1
) (
    input logic clk_i,
    input logic rst_ni,

    input logic s_axil_awvalid_i,
    output logic s_axil_awready_o,
    input logic [7:0] s_axil_awaddr_i,
    input logic [2:0] s_axil_awprot_i,
    input logic s_axil_wvalid_i,
    output logic s_axil_wready_o,
    input logic [31:0] s_axil_wdata_i,
    input logic [3:0] s_axil_wstrb_i,
    output logic s_axil_bvalid_o,
    input logic s_axil_bready_i,
    output logic [1:0] s_axil_bresp_o,
    input logic s_axil_arvalid_i,
    output logic s_axil_arready_o,
    input logic [7:0] s_axil_araddr_i,
    input logic [2:0] s_axil_arprot_i,
    output logic s_axil_rvalid_o,
    input logic s_axil_rready_i,
    output logic [31:0] s_axil_rdata_o,
    output logic [1:0] s_axil_rresp_o,

    output logic irq_o
);

  localparam int unsigned IndexWidth = $clog2(Depth);
  localparam int unsigned MoveWidth = move_width(W);
  localparam int unsigned UserWidth = run_user_width(M);

  if (Depth < 16 || Depth > 32768) begin : g_bad_depth
    $fatal(1, "Depth must be 16..32768");
  end

  triaxis_soc_regs__in_t  to_bus;
  triaxis_soc_regs__out_t from_bus;

  // --- Writes that wait for the engine --------------------------------------------------------------------

  typedef struct packed {
    logic load;
    logic run;
  } which_t;

  which_t asked, refused, wanted_d, wanted_q, taken;
  logic busy, load_ready, run_ready, triangle_fits, run_fits, void_d, void_q, fault;
  logic [1:0] ignored, load_q, mode_q, incomplete_d, incomplete_q, empty;
  logic [$bits(trial_t)-1:0] trial_q;
  logic [7:0] tag_q;

  // Converters of buses write words of which no byte is meant.
  assign ignored[0] = from_bus.LOAD.req && from_bus.LOAD.wr_biten == '0;
  assign ignored[1] = from_bus.RUN.req && from_bus.RUN.wr_biten == '0;
  assign asked.load = from_bus.LOAD.req && from_bus.LOAD.req_is_wr && !ignored[0];
  assign asked.run = from_bus.RUN.req && from_bus.RUN.req_is_wr && !ignored[1];
  assign taken.load = wanted_q.load && load_ready;
  assign taken.run = wanted_q.run && run_ready;
  // The bus has one such write under way at most, so a run cannot begin between this and its answer.
  assign refused.load = asked.load && (busy || !(&from_bus.LOAD.wr_biten) ||
      (!triangle_fits && !from_bus.LOAD.wr_data.clear));
  assign refused.run = asked.run &&
      (busy || !(&from_bus.RUN.wr_biten) || !run_fits || incomplete_q != '0 || empty != '0);
  assign wanted_d = (asked & ~refused) | (wanted_q & ~taken);
  assign void_d = refused != '0 || taken.load || fault || (void_q && !taken.run);
  for (genvar mesh = 0; mesh < 2; mesh++) begin : g_mesh
    // Of a part of a word it is not known which mesh was meant.
    assign incomplete_d[mesh] = fault || (refused.load &&
        (!(&from_bus.LOAD.wr_biten) || from_bus.LOAD.wr_data.mesh == 1'(mesh))) ||
        (incomplete_q[mesh] && !(taken.load && load_q == {1'b1, 1'(mesh)}));
  end

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {wanted_q, void_q, incomplete_q} <= '0;
    else {wanted_q, void_q, incomplete_q} <= {wanted_d, void_d, incomplete_d};
  end

  // In the clock in which it is shown the run before is no longer: it is void, or busy says that one goes on.
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) tag_q <= '0;
    else if (asked.run) tag_q <= from_bus.RUN.wr_data.tag;
  end

  always_ff @(posedge clk_i) begin
    if (asked.load) load_q <= {from_bus.LOAD.wr_data.clear, from_bus.LOAD.wr_data.mesh};
    if (asked.run) {trial_q, mode_q} <= {from_bus.RUN.wr_data.trial, from_bus.RUN.wr_data.mode};
  end

  assign to_bus.LOAD.wr_ack = taken.load || refused.load || ignored[0];
  assign to_bus.RUN.wr_ack  = taken.run || refused.run || ignored[1];

  // --- The engine -----------------------------------------------------------------------------------------

  logic [9*W-1:0] triangle;
  logic [3*MoveWidth-1:0] move;
  logic [UserWidth-1:0] run_user;
  logic near_valid, near_ready, done, fault_q, clear;
  status_e status;
  logic [2*IndexWidth-1:0] near_pair;
  logic [IndexWidth:0] count_a, count_b;
  logic [1:0] overfull;
  logic [2*$clog2(Depth/Group):0] groups_skipped, groups_opened;
  logic [2*IndexWidth:0] skipped, tested, near;
  logic [Zones-1:1] zones;

  logic [8:0] coordinates_fit;
  logic [2:0] moves_fit;
  logic [Zones-1:0][31:0] margins;
  logic [Zones-1:0] margins_fit;

  for (genvar number = 0; number < 9; number++) begin : g_coordinate
    assign triangle[number*W+:W] = W'(from_bus.VERTEX[number].value.value);
    assign coordinates_fit[number] =
        from_bus.VERTEX[number].value.value == 32'(signed'(triangle[number*W+:W]));
  end
  for (genvar axis = 0; axis < 3; axis++) begin : g_move
    assign move[axis*MoveWidth+:MoveWidth] = MoveWidth'(signed'(from_bus.MOVE[axis].value.value));
    assign moves_fit[axis] =
        from_bus.MOVE[axis].value.value == 32'(signed'(move[axis*MoveWidth+:MoveWidth]));
  end
  assign margins[ZoneMargin] = from_bus.MARGIN.value.value;
  assign margins[ZoneSlow]   = from_bus.SLOW.value.value;
  assign margins[ZoneWarn]   = from_bus.WARN.value.value;
  for (genvar zone = 0; zone < Zones; zone++) begin : g_zone
    assign margins_fit[zone] = (margins[zone] >> M) == '0;
    if (M > 0) begin : g_margin
      assign run_user[zone*M+:M] = margins[zone][M-1:0];
    end
  end
  assign run_user[UserWidth-1:Zones*M] = {trial_q, mode_q};
  assign run_fits = &moves_fit && &margins_fit;
  assign triangle_fits = &coordinates_fit;

  triaxis_mesh #(
      .W(W),
      .M(M),
      .Depth(Depth),
      .Group(Group),
      .Lanes(Lanes),
      .EdgeBox(EdgeBox),
      .Gating(Gating),
      .Certify(Certify)
  ) u_mesh (
      .clk_i,
      .rst_ni,
      .s_axis_load_tvalid_i(wanted_q.load),
      .s_axis_load_tready_o(load_ready),
      .s_axis_load_tdata_i(triangle),
      .s_axis_load_tuser_i(load_q),
      .count_a_o(count_a),
      .count_b_o(count_b),
      .overfull_o(overfull),
      .signature_a_o(to_bus.SIGNATURE_A.value.next),
      .signature_b_o(to_bus.SIGNATURE_B.value.next),
      .s_axis_run_tvalid_i(wanted_q.run),
      .s_axis_run_tready_o(run_ready),
      .s_axis_run_tdata_i(move),
      .s_axis_run_tuser_i(run_user),
      .abort_i(from_bus.CONTROL.abort.value),
      .busy_o(busy),
      .m_axis_near_tvalid_o(near_valid),
      .m_axis_near_tready_i(near_ready),
      .m_axis_near_tdata_o(near_pair),
      .m_axis_done_tvalid_o(done),
      .m_axis_done_tready_i(1'b1),
      .status_o(status),
      .cycles_o(to_bus.CYCLES.value.next),
      .group_pairs_skipped_o(groups_skipped),
      .group_pairs_opened_o(groups_opened),
      .pairs_skipped_o(skipped),
      .tested_o(tested),
      .near_o(near),
      .zones_o(zones),
      .acknowledge_i(from_bus.CONTROL.acknowledge.value),
      .fault_o(fault)
  );

  // --- What is read ---------------------------------------------------------------------------------------

  logic near_asked_q;

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) {near_asked_q, fault_q} <= '0;
    else
      {near_asked_q, fault_q} <= {from_bus.NEAR_PAIR.req && !from_bus.NEAR_PAIR.req_is_wr, fault};
  end

  assign near_ready = near_asked_q;
  assign to_bus.NEAR_PAIR.rd_ack = near_asked_q;
  assign to_bus.NEAR_PAIR.rd_data.a = near_valid ? 16'(near_pair[0+:IndexWidth]) : '1;
  assign to_bus.NEAR_PAIR.rd_data.b = near_valid ? 16'(near_pair[IndexWidth+:IndexWidth]) : '1;

  assign to_bus.CONFIGURATION.width.next = 6'(W);
  assign to_bus.CONFIGURATION.margin.next = 6'(M);
  assign to_bus.CONFIGURATION.log2_depth.next = 5'(IndexWidth);
  assign to_bus.CONFIGURATION.certify.next = Certify;
  assign to_bus.STATUS.busy.next = busy || wanted_q.run;
  assign to_bus.STATUS.near_waits.next = near_valid;
  assign to_bus.STATUS.fault.next = fault;
  assign to_bus.STATUS.incomplete_a.next = incomplete_q[0];
  assign to_bus.STATUS.incomplete_b.next = incomplete_q[1];
  assign clear = status == StatusComplete && near == '0 && !void_q && !fault && !busy &&
      !wanted_q.run;
  assign to_bus.STATUS.clear.next = clear;
  assign to_bus.STATUS.result.next = fault ? StatusFault : (void_q ? StatusNone : status);
  assign to_bus.STATUS.beyond_slow.next = clear && !zones[ZoneSlow];
  assign to_bus.STATUS.beyond_warn.next = clear && !zones[ZoneWarn];
  assign to_bus.STATUS.overfull_a.next = overfull[0];
  assign to_bus.STATUS.overfull_b.next = overfull[1];
  assign to_bus.STATUS.tag.next = tag_q;
  // Of nothing all is clear: after a reset, too.
  assign empty = {count_b == '0, count_a == '0};
  assign to_bus.COUNT_A.value.next = 32'(count_a);
  assign to_bus.COUNT_B.value.next = 32'(count_b);
  assign to_bus.NEAR.value.next = 32'(near);
  assign to_bus.TESTED.value.next = 32'(tested);
  assign to_bus.PAIRS_SKIPPED.value.next = 32'(skipped);
  assign to_bus.GROUP_PAIRS_SKIPPED.value.next = 32'(groups_skipped);
  assign to_bus.GROUP_PAIRS_OPENED.value.next = 32'(groups_opened);

  assign to_bus.INTERRUPT.done.hwset = done;
  assign to_bus.INTERRUPT.fault.hwset = fault && !fault_q;
  assign to_bus.INTERRUPT.refused.hwset = refused != '0;
  assign to_bus.INTERRUPT.near_waits.hwset = near_valid;
  assign irq_o = (from_bus.INTERRUPT.done.value && from_bus.INTERRUPT_ENABLE.done.value) ||
      (from_bus.INTERRUPT.fault.value && from_bus.INTERRUPT_ENABLE.fault.value) ||
      (from_bus.INTERRUPT.refused.value && from_bus.INTERRUPT_ENABLE.refused.value) ||
      (from_bus.INTERRUPT.near_waits.value && from_bus.INTERRUPT_ENABLE.near_waits.value);

  // --- The registers --------------------------------------------------------------------------------------

  triaxis_soc_regs u_regs (
      .clk(clk_i),
      .arst_n(rst_ni),
      .s_axil_awready(s_axil_awready_o),
      .s_axil_awvalid(s_axil_awvalid_i),
      .s_axil_awaddr(s_axil_awaddr_i),
      .s_axil_awprot(s_axil_awprot_i),
      .s_axil_wready(s_axil_wready_o),
      .s_axil_wvalid(s_axil_wvalid_i),
      .s_axil_wdata(s_axil_wdata_i),
      .s_axil_wstrb(s_axil_wstrb_i),
      .s_axil_bready(s_axil_bready_i),
      .s_axil_bvalid(s_axil_bvalid_o),
      .s_axil_bresp(s_axil_bresp_o),
      .s_axil_arready(s_axil_arready_o),
      .s_axil_arvalid(s_axil_arvalid_i),
      .s_axil_araddr(s_axil_araddr_i),
      .s_axil_arprot(s_axil_arprot_i),
      .s_axil_rready(s_axil_rready_i),
      .s_axil_rvalid(s_axil_rvalid_o),
      .s_axil_rdata(s_axil_rdata_o),
      .s_axil_rresp(s_axil_rresp_o),
      .hwif_in(to_bus),
      .hwif_out(from_bus)
  );

endmodule
