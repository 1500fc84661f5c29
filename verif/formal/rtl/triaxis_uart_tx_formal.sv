// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A serial line from any bytes at any clocks: by one count of clocks from the acceptance of a byte on, each of its
// bits stands for its own share of the ten, then the next byte may begin; the line is high but for bytes.

`include "triaxis_formal.svh"

module triaxis_uart_tx_formal #(
    parameter int unsigned ClocksPerThreeBits = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic valid_i,
    input logic [7:0] data_i
);

  // In clocks since the start bit began: where a bit of the byte ends.
  function automatic int unsigned ends(int unsigned place);
    return (place + 1) * ClocksPerThreeBits / 3;
  endfunction
  typedef logic [$clog2(ends(9)+1)-1:0] clocks_t;

  logic ready_o, line_o;
  triaxis_uart_tx #(.ClocksPerThreeBits(ClocksPerThreeBits)) u_tx (.*);

  `TRIAXIS_RESET_FIRST

  // Whether a byte is on the line, which, and for how many clocks.
  logic sends_q, line;
  clocks_t clocks_q;
  logic [9:0] bits_q;
  logic [3:0] place;
  always_comb begin
    place = '0;
    for (int i = 0; i < 9; i++) if (clocks_q >= clocks_t'(ends(i))) place = 4'(i + 1);
    line = !sends_q || bits_q[place];
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      sends_q  <= 1'b0;
      clocks_q <= '0;
    end else if (sends_q) begin
      clocks_q <= clocks_q + clocks_t'(1);
      sends_q  <= clocks_q != clocks_t'(ends(9) - 1);
    end else begin
      clocks_q <= '0;
      sends_q  <= valid_i;
    end
  end
  always_ff @(posedge clk_i) if (!sends_q) bits_q <= {1'b1, data_i, 1'b0};

  always_comb begin
    if (rst_ni) begin
      Line : assert (line_o == line);
      Ready : assert (ready_o == !sends_q);
      SeenBits : cover (sends_q && place == 4'd7 && bits_q[8:1] == 8'hC5);
      SeenNext : cover (ready_o && valid_i && bits_q[8:1] == 8'hC5);
      // What makes it inductive: what is left of the bit, in thirds of clocks, and of the byte.
      assert (!sends_q || clocks_q < clocks_t'(ends(9)));
      assert (!sends_q || (place == 4'd10 - u_tx.left_q && bits_q[9] && !bits_q[0]));
      assert (!sends_q || 3 * (32'(clocks_q) + 1) + 32'(u_tx.count_q) ==
              (32'(place) + 1) * ClocksPerThreeBits);
      for (int i = 0; i < 9; i++) begin
        assert (!sends_q || u_tx.bits_q[i] == (i + 32'(place) > 9 || bits_q[4'(i)+place]));
        assert (sends_q || u_tx.bits_q[i]);
      end
    end
  end

endmodule
