// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Bytes of a serial line with any levels at any clocks: by one count of clocks from the line's fall
// on, each byte that is given is what the line was in the middles of its bits, after a start bit
// that was low in its middle and before a stop bit that was high; a byte whose stop bit was low is
// told as an error, once, and nothing begins before the line was high again.

module triaxis_uart_rx_formal #(
    parameter int unsigned ClocksPerThreeBits = 25
) (
    input logic clk_i,
    input logic rst_ni,
    input logic line_i
);

  // In clocks since the line's fall: the middle of a bit of the byte, and how wide the last one is.
  function automatic int unsigned middle(int unsigned place);
    return (2 * place + 1) * ClocksPerThreeBits / 6;
  endfunction
  typedef logic [$clog2(middle(9)+1)-1:0] clocks_t;

  logic valid_o, framing_error_o;
  logic [7:0] data_o;
  triaxis_uart_rx #(.ClocksPerThreeBits(ClocksPerThreeBits)) u_rx (.*);

  // The line two clocks ago; clocks since it fell; its levels in the middles of the bits so far. The
  // line's rest: from the middle of a stop bit until it is high.
  logic [1:0] line_q;
  logic line, under_way_q, rest_q, in_middle;
  clocks_t clocks_q;
  logic [9:0] levels_q;
  logic [3:0] bit_number;
  assign line = line_q[1];

  // A reset at the beginning that fills the synchroniser; any later.
  logic [1:0] started_q = '0;
  always_ff @(posedge clk_i) started_q <= {started_q[0], 1'b1};
  always_comb begin
    Reset : assume (started_q[1] || !rst_ni);
    assert (!started_q[0] || u_rx.line_q[0] == line_q[0]);
    assert (!started_q[1] || (started_q[0] && u_rx.line_q[1] == line_q[1]));
  end

  always_comb begin
    in_middle  = 1'b0;
    bit_number = '0;
    for (int i = 0; i < 10; i++) begin
      if (under_way_q && clocks_q == clocks_t'(middle(i))) begin
        in_middle  = 1'b1;
        bit_number = 4'(i);
      end
    end
  end
  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      {under_way_q, rest_q} <= '0;
      clocks_q <= '0;
      levels_q <= '1;
    end else begin
      if (in_middle) levels_q[bit_number] <= line;
      if (under_way_q) begin
        clocks_q <= clocks_q + clocks_t'(1);
        // A start bit that is over by its middle is none.
        if (in_middle && (bit_number == 4'd9 || (bit_number == '0 && line))) under_way_q <= 1'b0;
        if (in_middle && bit_number == 4'd9) rest_q <= 1'b1;
      end else if (rest_q) begin
        rest_q <= !line;
      end else if (!line) begin
        under_way_q <= 1'b1;
        clocks_q <= clocks_t'(1);
      end
    end
  end

  always_ff @(posedge clk_i) line_q <= {line_q[0], line_i};

  logic ends;
  assign ends = in_middle && bit_number == 4'd9;

  // A bit since the first clock.
  logic bit_seen_q = 1'b0;
  always_ff @(posedge clk_i) bit_seen_q <= bit_seen_q || in_middle;

  // Thirds of clocks from the line's fall to the middle of the bit that is waited for.
  int unsigned thirds;
  logic [2:0] state;
  assign state = u_rx.state_q;
  always_comb begin
    case (state)
      3'd1: thirds = ClocksPerThreeBits / 2;
      3'd2: thirds = ClocksPerThreeBits / 2 + (32'(u_rx.bit_q) + 1) * ClocksPerThreeBits;
      default: thirds = ClocksPerThreeBits / 2 + 9 * ClocksPerThreeBits;
    endcase
  end

  always_comb begin
    if (rst_ni) begin
      Given : assert (valid_o == ends);
      InTheMiddles : assert (!valid_o || (data_o == levels_q[8:1] && !levels_q[0]));
      Framing : assert (framing_error_o == (ends && !line));
      SeenByte : cover (valid_o && data_o == 8'hC5 && bit_seen_q);
      SeenFraming : cover (framing_error_o && bit_seen_q);
      // What makes it inductive.
      assert (state <= 3'd4);
      assert (under_way_q == (state inside {3'd1, 3'd2, 3'd3}));
      assert (rest_q == (state == 3'd4));
      assert (!under_way_q || 3 * 32'(clocks_q) + 32'(u_rx.count_q) == thirds);
      assert (!under_way_q || clocks_q != '0);
      assert (!under_way_q || 32'(u_rx.count_q) < ClocksPerThreeBits);
      assert (state == 3'd2 || u_rx.bit_q == '0);
      assert (!(state inside {3'd2, 3'd3}) || !levels_q[0]);
      for (int i = 0; i < 8; i++) begin
        assert (state != 3'd2 || 3'(i) >= u_rx.bit_q ||
                data_o[3'd0 - u_rx.bit_q + 3'(i)] == levels_q[i+1]);
        assert (state != 3'd3 || data_o[i] == levels_q[i+1]);
      end
    end
  end

endmodule
