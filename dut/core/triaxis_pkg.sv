// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Shared types and constants of the core: the axis numbering, the widths and the latencies, each
// defined here once.
//
// Widths. L = 2^W - 1 is the largest difference of two coordinates. Every quantity below is
// multi-affine in the vertex coordinates, so its extremes lie at corners of the coordinate box;
// verif/formal/widths.py enumerates those corners.
//
//   difference of two vertices            |.| <= L      W+1  bits signed
//   sum of two coordinates                |.| <= 2^W    W+1  bits signed
//   sum of three coordinates              |.| < 2^(W+1) W+2  bits signed
//   cross product from a common vertex    |.| <= L^2    2W+1 bits signed
//   edge x edge, one component            |.| <= 2 L^2  2W+2 bits signed
//   edge x edge, sum of the absolutes     |.| <= 4 L^2  2W+3 bits signed (never negative)
//   orientation of four vertices          |.| <= 2 L^3  3W+2 bits signed
//   difference of projections on an axis  |.| <= 4 L^3  3W+3 bits signed
//   the same, moved by margin * |axis|1   |.| <= 7 L^3  3W+4 bits signed
//   2D orientation moved by its margin    |.| <= 3 L^2  2W+3 bits signed
//
// Sums may wrap on the way as long as the result fits: two's complement addition is exact modulo
// its width.

package triaxis_pkg;

  // Axis numbers. Edge i runs from vertex i to vertex i+1, cyclically; coordinate k is x, y, z.
  parameter int unsigned NumAxes = 32;
  parameter int unsigned AxisBox = 0;  // + k
  parameter int unsigned AxisNormalA = 3;
  parameter int unsigned AxisNormalB = 4;
  parameter int unsigned AxisEdgeEdge = 5;  // + 3i + j, edge i of A, edge j of B
  parameter int unsigned AxisEdgeBoxA = 14;  // + 3i + k
  parameter int unsigned AxisEdgeBoxB = 23;  // + 3j + k

  typedef logic [$clog2(NumAxes)-1:0] axis_t;

  typedef struct packed {
    axis_t axis;          // lowest-numbered separating axis; 0 where is_near
    logic  degenerate_b;
    logic  degenerate_a;
    logic  coplanar;
    logic  is_near;
  } verdict_t;

  // What a pair of the certified core tries: nothing; a claim in place of the core's, of that axis; a parity
  // bit of its vertices, or of its result, inverted; its number changed in one bit.
  typedef enum logic [1:0] {
    TryNothing,
    TryClaim,
    TryParity,
    TryNumber
  } try_kind_e;

  typedef struct packed {
    try_kind_e kind;
    axis_t which;
  } try_t;

  function automatic int unsigned diff_width(int unsigned w);
    return w + 1;
  endfunction

  function automatic int unsigned height_width(int unsigned w);
    return w + 2;
  endfunction

  function automatic int unsigned cross_width(int unsigned w);
    return 2 * w + 1;
  endfunction

  function automatic int unsigned axis_width(int unsigned w);
    return 2 * w + 2;
  endfunction

  function automatic int unsigned span_width(int unsigned w);
    return 3 * w + 3;
  endfunction

  // Ports cannot be zero bits wide: without margins the margin is a constant bit, 0.
  function automatic int unsigned margin_width(int unsigned m);
    return (m == 0) ? 1 : m;
  endfunction

  // margin * |axis|1, unsigned; one constant bit where M = 0.
  function automatic int unsigned axis_threshold_width(int unsigned w, int unsigned m);
    return (m == 0) ? 1 : axis_width(w) + m;
  endfunction

  function automatic int unsigned edge_threshold_width(int unsigned w, int unsigned m);
    return (m == 0) ? 1 : diff_width(w) + m;
  endfunction

  // A DSP48E1 multiplies 25 by 18 bits, signed; for parts with other blocks the wider port can be
  // given from outside. Lower pieces of a split operand are unsigned, so they hold one bit less than
  // the port; the top piece is signed and fills it.
`ifdef TRIAXIS_DSP_PORT_A
  parameter int unsigned DspPortA = `TRIAXIS_DSP_PORT_A;
`else
  parameter int unsigned DspPortA = 25;
`endif
  parameter int unsigned DspPortB = 18;

  // A piece of at most this many bits is multiplied by additions: it would waste a block.
  parameter int unsigned NarrowBits = 5;

  function automatic int unsigned mul_pieces(int unsigned width, int unsigned port);
    if (width <= port) return 1;
    return 1 + (width - port + port - 2) / (port - 1);
  endfunction

  // True where the first operand is better placed on the 25-bit port: there are no more pieces.
  function automatic bit mul_first_on_a(int unsigned aw, int unsigned bw);
    return mul_pieces(aw, DspPortA) * mul_pieces(bw, DspPortB) <=
        mul_pieces(aw, DspPortB) * mul_pieces(bw, DspPortA);
  endfunction

  function automatic int unsigned mul_products(int unsigned aw, int unsigned bw);
    if (mul_first_on_a(aw, bw)) return mul_pieces(aw, DspPortA) * mul_pieces(bw, DspPortB);
    return mul_pieces(aw, DspPortB) * mul_pieces(bw, DspPortA);
  endfunction

  // Latencies, in clocks.
  parameter int unsigned InputLatency = 1;  // input register
  parameter int unsigned BoxLatency = 4;  // order, extents, gaps, comparison
  parameter int unsigned GateLatency = 1;  // operand register
  parameter int unsigned SumLatency = 1;  // operands of a multiplier
  parameter int unsigned AreaLatency = 2;  // trapezoids to areas
  parameter int unsigned FlatLatency = 2;  // prisms to orientations of four vertices
  parameter int unsigned ProjectionLatency = 4;  // prisms to projections
  parameter int unsigned VerdictLatency = 3;  // axis bits, the lowest of them, claim
  parameter int unsigned FifoLatency = 1;

  function automatic int unsigned sum_latency(int unsigned terms);
    return $clog2(terms);
  endfunction

  // Operands, products, products again, then the sum of the pieces.
  function automatic int unsigned mul_latency(int unsigned aw, int unsigned bw);
    return 3 + sum_latency(mul_products(aw, bw));
  endfunction

  function automatic int unsigned trapezoid_latency(int unsigned w);
    return SumLatency + mul_latency(diff_width(w), diff_width(w));
  endfunction

  // From the operand register to the areas seen along the coordinate axes, and so to the normals.
  function automatic int unsigned area_latency(int unsigned w);
    return trapezoid_latency(w) + AreaLatency;
  endfunction

  function automatic int unsigned prism_latency(int unsigned w);
    return mul_latency(cross_width(w), height_width(w));
  endfunction

  function automatic int unsigned interval_latency(int unsigned m);
    return (m == 0) ? 1 : 2;
  endfunction

  // margin * (|c0| + .. + |cn|): absolute values, their sum, product with the margin.
  function automatic int unsigned threshold_latency(int unsigned components, int unsigned cw,
                                                    int unsigned m);
    return 1 + sum_latency(components) + mul_latency(cw + 1, m + 1);
  endfunction

  // From the operand register to the registered axis bits.
  function automatic int unsigned decision_latency(int unsigned w, int unsigned m);
    return area_latency(w) + prism_latency(w) + ProjectionLatency + interval_latency(m);
  endfunction

  // From the input port to the verdict, before the result FIFO.
  function automatic int unsigned datapath_latency(int unsigned w, int unsigned m);
    return InputLatency + BoxLatency + GateLatency + decision_latency(w, m) + VerdictLatency;
  endfunction

  // Of the certifier: products of an axis and vertices, summed; margin * |axis|1; comparison.
  parameter int unsigned ApartLatency = 4;

  function automatic int unsigned inner_latency(int unsigned w);
    return mul_latency(axis_width(w), diff_width(w)) + 2;
  endfunction

  function automatic int unsigned reach_latency(int unsigned w, int unsigned m);
    return 3 + mul_latency(axis_width(w) + 1, m + 1);
  endfunction

  // Differences, their choice, the axis, projections, comparison.
  function automatic int unsigned certifier_latency(int unsigned w);
    return 3 + mul_latency(diff_width(w), diff_width(w)) + inner_latency(w) + ApartLatency;
  endfunction

  // From the accepting clock edge to the first edge at which the result can be taken.
  function automatic int unsigned core_latency(int unsigned w, int unsigned m);
    return datapath_latency(w, m) + FifoLatency;
  endfunction

  // The same of the certified core: the pair is read again, and its result waits in a second queue.
  function automatic int unsigned certified_latency(int unsigned w, int unsigned m);
    return core_latency(w, m) + 1 + certifier_latency(w) + FifoLatency;
  endfunction

endpackage
