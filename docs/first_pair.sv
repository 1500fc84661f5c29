// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The core in a design of its own, and one pair through it at two margins: a triangle in the plane z = 0, and
// another in z = 3 above it, near at the margin 3, clear at 2.

module first_pair;

  localparam int unsigned W = 16, M = 4, TAG = 8;

  logic clk, rst_n, valid, ready, result_valid;
  logic [  M-1:0] margin;
  logic [   15:0] result;
  logic [TAG-1:0] result_tag;
  // x, y, z of A1, A2, A3, B1, B2, B3; the first in the lowest bits.
  logic signed [W-1:0] pair[18];
  assign pair = '{0, 0, 0, 9, 0, 0, 0, 9, 0, 1, 1, 3, 4, 1, 3, 1, 4, 3};

  triaxis_core #(
      .W  (W),
      .M  (M),
      .TAG(TAG)
  ) u_core (
      .clk_i(clk),
      .rst_ni(rst_n),
      .s_axis_tvalid_i(valid),
      .s_axis_tready_o(ready),
      .s_axis_tdata_i({<<W{pair}}),
      .s_axis_tuser_i({TAG'(margin), margin}),
      .m_axis_tvalid_o(result_valid),
      .m_axis_tready_i(1'b1),
      .m_axis_tdata_o(result),
      .m_axis_tuser_o(result_tag)
  );

  initial clk = 1'b0;
  always #5 clk = !clk;

  initial begin
    {rst_n, valid, margin} = {1'b1, 1'b0, M'(0)};
    @(negedge clk) rst_n = 1'b0;
    repeat (4) @(negedge clk);
    rst_n = 1'b1;
    for (int unsigned m = 2; m <= 3; m++) begin
      @(negedge clk) {valid, margin} = {1'b1, M'(m)};
      // Taken at the edge at which both are there; so is the result.
      do @(posedge clk); while (!ready);
      @(negedge clk) valid = 1'b0;
      do @(posedge clk); while (!result_valid);
      $display("margin %0d: %s", result_tag, result[0] ? "near" : "clear");
      if (result_tag != TAG'(m) || result[0] != (m == 3)) $fatal(1, "first_pair: a wrong answer");
    end
    $finish;
  end

endmodule
