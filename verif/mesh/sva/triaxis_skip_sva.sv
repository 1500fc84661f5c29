// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The rule behind every skip, bound from outside the RTL: a box is skipped only where an axis
// separates it from the grown box it was compared with; and it is skipped wherever one does.

module triaxis_skip_sva
  import triaxis_mesh_pkg::*;
#(
    parameter int unsigned W = 16,
    parameter int unsigned Lanes = 8
) (
    input logic clk_i,
    input logic rst_ni,
    input logic [Lanes-1:0] decided,
    input logic [Lanes-1:0] overlap,
    input logic signed [grown_width(W)-1:0] grown[2][3],
    input logic signed [W-1:0] boxes[Lanes][2][3]
);

  for (genvar l = 0; l < Lanes; l++) begin : g_lane
    // By how much a box stands clear of the grown one, on the axis where it is most; 64 bits hold all.
    logic signed [63:0] clearance;
    always_comb begin
      clearance = -64'sd1 <<< 62;
      for (int unsigned k = 0; k < 3; k++) begin
        if (64'(boxes[l][0][k]) - 64'(grown[1][k]) > clearance) begin
          clearance = 64'(boxes[l][0][k]) - 64'(grown[1][k]);
        end
        if (64'(grown[0][k]) - 64'(boxes[l][1][k]) > clearance) begin
          clearance = 64'(grown[0][k]) - 64'(boxes[l][1][k]);
        end
      end
    end

    SkipProven :
    assert property (@(posedge clk_i) disable iff (!rst_ni)
        decided[l] && !overlap[l] |-> clearance > 0)
    else $error("a box was skipped that no axis separates by more than the margin");

    OverlapKept :
    assert property (@(posedge clk_i) disable iff (!rst_ni)
        decided[l] && overlap[l] |-> clearance <= 0)
    else $error("a box was kept that an axis separates by more than the margin");
  end

endmodule

bind triaxis_group_rows triaxis_skip_sva #(
    .W(W),
    .Lanes(1)
) u_sva (
    .clk_i,
    .rst_ni,
    .decided(grown_valid_q),
    .overlap,
    .grown,
    .boxes  (whole)
);

bind triaxis_group_words triaxis_skip_sva #(
    .W(W),
    .Lanes(Lanes)
) u_sva (
    .clk_i,
    .rst_ni,
    .decided,
    .overlap,
    .grown(read_grown_q),
    .boxes(boxes_i)
);

bind triaxis_pair_boxes triaxis_skip_sva #(
    .W(W),
    .Lanes(Lanes)
) u_sva (
    .clk_i,
    .rst_ni,
    .decided,
    .overlap,
    .grown,
    .boxes(boxes_b_i)
);
