// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What runs of the mesh engine ask for and answer, and its widths, each defined here once.
//
// Widths. Coordinates have W bits. A translation has W+1 bits signed: it can take a mesh from one
// end of the range to the other. A moved by a translation stays within W bits, or the run is
// refused. Grown by the margin, of at most W bits, its boxes lie within
//   [-2^(W-1) - (2^W - 1), 2^(W-1) - 1 + (2^W - 1)],   W+2 bits signed,
// and translation - margin, translation + margin within [-2^(W+1) + 1, 2^(W+1) - 1], W+2 as well.

package triaxis_mesh_pkg;

  typedef enum logic [1:0] {
    ModeFirst = 2'd0,  // stop at the first near pair
    ModeAll   = 2'd1,  // stream all near pairs
    ModeCount = 2'd2,  // only count them
    ModeNone  = 2'd3   // refused
  } mode_e;

  // Neither all zeros nor all ones means that a run is complete.
  typedef enum logic [2:0] {
    StatusNone     = 3'd0,  // never sent
    StatusComplete = 3'd1,  // every pair was skipped with a proof, or tested
    StatusFirst    = 3'd2,  // stopped at the first near pair
    StatusAborted  = 3'd3,
    StatusOverflow = 3'd4,  // A moved leaves the range: nothing was run
    StatusOverfull = 3'd5,  // a mesh was given more triangles than fit: nothing was run
    StatusBadMode  = 3'd6   // nothing was run
  } status_e;

  function automatic int unsigned move_width(int unsigned w);
    return w + 1;
  endfunction

  function automatic int unsigned grown_width(int unsigned w);
    return w + 2;
  endfunction

  // Addresses of memories with one word are one constant bit wide.
  function automatic int unsigned address_width(int unsigned words);
    return (words > 1) ? $clog2(words) : 1;
  endfunction

endpackage
