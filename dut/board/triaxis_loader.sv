// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Computes: the engine's load stream, from a frame held in memory. The coordinates are all looked at
// before the first is loaded: a frame with one that needs more than W bits changes nothing. While no
// run goes on the engine takes in each clock what it is given: to empty both meshes waits for that.
// Widths: a coordinate has CoordBytes = ceil(W / 8) bytes, sign-extended, lowest first.
// Latency: two passes of 9 * CoordBytes + 1 clocks a triangle, and a clock for each emptied mesh.

module triaxis_loader
  import triaxis_board_pkg::*;
#(
    parameter int unsigned W = 16
) (
    input logic clk_i,
    input logic rst_ni,
    // One of them starts it; done_o ends it.
    input logic empty_both_i,
    input logic load_i,
    input logic mesh_i,
    input logic empty_first_i,
    input logic [$clog2(LoadMax+1)-1:0] triangles_i,  // 1 .. LoadMax
    output logic accepted_o,  // the coordinates are in range; the mesh changes after this clock
    output logic done_o,
    output logic bad_o,  // with done_o: a coordinate is out of range, nothing was changed
    // The frame.
    output logic [$clog2(MaxFrameBytes)-1:0] address_o,
    input byte_t data_i,
    // The engine.
    output logic tvalid_o,
    input logic tready_i,
    output logic [9*W-1:0] tdata_o,
    output logic [1:0] tuser_o
);

  localparam int unsigned CoordWidth = 8 * ((W + 7) / 8);
  localparam int unsigned TriangleBytes = 9 * CoordWidth / 8;
  typedef logic [$clog2(MaxFrameBytes)-1:0] address_t;
  typedef logic [$clog2(TriangleBytes)-1:0] byte_index_t;
  typedef logic [$clog2(LoadMax+1)-1:0] triangle_count_t;
  localparam address_t FirstTriangle = address_t'(HeaderBytes + LoadFieldBytes);

  typedef enum logic [2:0] {
    Idle,
    Gather,
    Look,
    Empty,
    Send
  } state_e;

  state_e state_q;
  logic both_q, sending_q, mesh_q, empty_first_q;
  address_t address_q;
  byte_index_t byte_q;
  triangle_count_t triangles_q, left_q;
  logic [8*TriangleBytes-1:0] triangle_q;

  logic last_byte;
  assign last_byte = byte_q == byte_index_t'(TriangleBytes - 1);

  logic [8:0] fits;
  for (genvar k = 0; k < 9; k++) begin : g_coordinate
    assign tdata_o[k*W+:W] = triangle_q[k*CoordWidth+:W];
    // The sign and all above it.
    logic [CoordWidth-W:0] top;
    assign top = triangle_q[k*CoordWidth+W-1+:CoordWidth-W+1];
    assign fits[k] = top == '0 || top == '1;
  end

  logic last_triangle, all_fit, sent, emptied;
  assign last_triangle = left_q == triangle_count_t'(1);
  assign all_fit = fits == '1;

  assign accepted_o = state_q == Look && all_fit && last_triangle;
  assign bad_o = state_q == Look && !all_fit;
  assign sent = state_q == Send && last_triangle;
  assign emptied = both_q && mesh_q;
  assign done_o = bad_o || sent || emptied;
  assign address_o = address_q;
  assign tvalid_o = state_q == Empty || state_q == Send;
  assign tuser_o = {state_q == Empty, mesh_q};

  always_ff @(posedge clk_i or negedge rst_ni) begin
    if (!rst_ni) begin
      state_q <= Idle;
    end else begin
      case (state_q)
        Idle: begin
          if (empty_both_i) state_q <= Empty;
          else if (load_i) state_q <= Gather;
        end
        Gather:  if (last_byte) state_q <= sending_q ? Send : Look;
        Look: begin
          if (!all_fit) state_q <= Idle;
          else state_q <= (last_triangle && empty_first_q) ? Empty : Gather;
        end
        Empty:   state_q <= emptied ? Idle : both_q ? Empty : Gather;
        default: state_q <= sent ? Idle : Gather;
      endcase
    end
  end

  always_ff @(posedge clk_i) begin
    case (state_q)
      Idle: begin
        both_q <= empty_both_i;
        sending_q <= 1'b0;
        mesh_q <= !empty_both_i && mesh_i;
        empty_first_q <= empty_first_i;
        address_q <= FirstTriangle;
        byte_q <= '0;
        triangles_q <= triangles_i;
        left_q <= triangles_i;
      end
      Gather: begin
        address_q <= address_q + address_t'(1);
        byte_q <= last_byte ? '0 : byte_q + byte_index_t'(1);
      end
      Look: begin
        left_q <= left_q - triangle_count_t'(1);
        if (last_triangle) begin
          sending_q <= 1'b1;
          address_q <= FirstTriangle;
          left_q <= triangles_q;
        end
      end
      Empty:   if (both_q && tready_i) mesh_q <= 1'b1;
      default: left_q <= left_q - triangle_count_t'(1);
    endcase
    triangle_q <= {data_i, triangle_q[8*TriangleBytes-1:8]};
  end

endmodule
