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

  // How near a pair is asked to be. A run has a margin for each; the outer zones only tell, the margin itself is
  // what the modes and counts are about.
  typedef enum logic [1:0] {
    ZoneMargin = 2'd0,
    ZoneSlow   = 2'd1,
    ZoneWarn   = 2'd2
  } zone_e;

  localparam int unsigned Zones = 3;

  // Neither all zeros nor all ones means that a run is complete.
  typedef enum logic [2:0] {
    StatusNone     = 3'd0,  // never sent
    StatusComplete = 3'd1,  // every pair was skipped with a proof, or tested
    StatusFirst    = 3'd2,  // stopped at the first near pair
    StatusAborted  = 3'd3,
    StatusOverflow = 3'd4,  // A moved leaves the range: nothing was run
    StatusOverfull = 3'd5,  // a mesh was given more triangles than fit: nothing was run
    StatusBadMode  = 3'd6,  // nothing was run
    StatusFault    = 3'd7   // a check failed: nothing that was found counts
  } status_e;

  // What a run tries, so that each check is seen to work; a run of use tries nothing. The first four are the
  // attempts of the certified core, see triaxis_pkg, on each pair that is tested; then words of one of the
  // memories are taken as broken where they are used, one of the two walks is misread, or one of the two
  // intakes of each mesh.
  typedef enum logic [2:0] {
    TrialNothing,
    TrialClaim,
    TrialParity,
    TrialNumber,
    TrialMemory,
    TrialWalk,
    TrialIntake,
    TrialBoard  // of the board around the engine, which does nothing with it
  } trial_kind_e;

  // which: of an attempt see triaxis_pkg; of the walk and the intake each 32nd bit, from this one on. Of memories
  // one of memory_e, during the run; from WhichScrub on one of them, where it is scrubbed after the run; from
  // WhichScrubbed on a comparison of triaxis_mesh_scrub, of both meshes.
  typedef struct packed {
    trial_kind_e kind;
    logic [4:0]  which;
  } trial_t;

  typedef enum logic [2:0] {
    MemoryGroupsA,
    MemoryGroupsB,
    MemoryBoxesA,
    MemoryBoxesB,
    MemoryTrianglesA,
    MemoryTrianglesB
  } memory_e;

  localparam int unsigned WhichScrub = 8;
  localparam int unsigned WhichScrubbed = 16;

  // CRC-32 of IEEE 802.3, reflected.
  localparam logic [31:0] CrcPolynomial = 32'hEDB8_8320;

  function automatic int unsigned move_width(int unsigned w);
    return w + 1;
  endfunction

  function automatic int unsigned grown_width(int unsigned w);
    return w + 2;
  endfunction

  // Of a run: {trial, mode, a margin for each zone, the innermost lowest}.
  function automatic int unsigned run_user_width(int unsigned m);
    return Zones * m + $bits(mode_e) + $bits(trial_t);
  endfunction

  // Addresses of memories with one word are one constant bit wide.
  function automatic int unsigned address_width(int unsigned words);
    return (words > 1) ? $clog2(words) : 1;
  endfunction

  // Of what two intakes must have alike: count, overfull, three clocks under way, number, vertices, three boxes.
  function automatic int unsigned intake_seen_width(int unsigned w, int unsigned depth);
    return 2 * $clog2(depth) + 5 + 27 * w;
  endfunction

  // Of what two walks must have alike, in the order of triaxis_walk.
  function automatic int unsigned walk_seen_width(int unsigned w, int unsigned m,
                                                  int unsigned depth, int unsigned group,
                                                  int unsigned lanes, int unsigned cycle_bits);
    int unsigned index_bits = $clog2(depth);
    int unsigned addresses = address_width(
        depth / group
    ) + address_width(
        depth / group / lanes
    ) + address_width(
        depth / lanes
    ) + 7 * index_bits;
    int unsigned counts = 2 * (2 * $clog2(depth / group) + 1) + 2 * (2 * index_bits + 1);
    int unsigned summary = 1 + $bits(status_e) + (Zones - 1) + 2 * index_bits + 1;
    return m + 11 + $bits(zone_e) + addresses + 18 * w + cycle_bits + counts + summary;
  endfunction

endpackage
