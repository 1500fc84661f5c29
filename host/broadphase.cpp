// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Which boxes of two trees come within a margin, and which facets in them are near first. Built as a shared
// library with the bulk checker's claims; see broadphase.py.
//
// A pair of nodes is opened into the children of the larger one, depth first, those first that overlap by
// most. All is in integers: coordinates below 2^60 and padding of 2^62 leave room for sums of three.

#include <algorithm>
#include <cstdint>

// The bulk checker (golden/bulk_claims.cpp).
extern "C" void triaxis_claims(const int32_t* pairs, const uint32_t* margins, int64_t n, int8_t* claims);

namespace triaxis::host {
namespace {

// Nodes below a node, as broadphase.py has it.
constexpr int kFan = 4;
// Levels of a tree over at most 2^40 boxes; each opened pair of nodes leaves all but one of its children on
// the stack.
constexpr int kLevels = 20, kDeepest = 2 * kLevels * (kFan - 1) + 1;
// Facet pairs decided at a time, where a near one ends the search.
constexpr int kFew = 64;
constexpr int kCoordinates = 18;

// x, y, z, and x again, for the sake of a register.
typedef int64_t Row __attribute__((vector_size(32), aligned(8)));

// The low corner and minus the high corner; or how far these of A may exceed their limits in B.
struct Box {
  Row low, minus_high;

  int64_t size() const {
    const Row sides = -(low + minus_high);
    return sides[0] + sides[1] + sides[2];
  }
};

struct Tree {
  // Nodes by height, leaves first; the numbers of the boxes of the leaves.
  const Box* const* levels;
  const int64_t* order;
};

// Two nodes, and their heights.
struct Meeting {
  int64_t a, b;
  int64_t height_a, height_b;
};

// A search that is interrupted when its caller has enough for now. It is kept in memory of the caller's.
struct Search {
  // Comparisons of two boxes, and pairs of nodes on the stack: read by the caller.
  int64_t compared;
  int64_t depth;
  Tree a, b;
  Box room;
  Meeting stack[kDeepest];

  // By how much two boxes are further apart than the margin, along the axis where they are furthest; at most
  // 0 where they are not.
  int64_t Apart(const Box& of_a, const Box& of_b) {
    ++compared;
    const Row up = of_a.low + of_b.minus_high - room.low;
    const Row down = of_a.minus_high + of_b.low - room.minus_high;
    const Row most = up > down ? up : down;
    return std::max(std::max(most[0], most[1]), most[2]);
  }

  void Begin(int64_t height_a, int64_t height_b) {
    compared = depth = 0;
    if (Apart(a.levels[height_a][0], b.levels[height_b][0]) <= 0) {
      stack[depth++] = {0, 0, height_a, height_b};
    }
  }

  // Writes the numbers of at most so many pairs of boxes, and returns how many: fewer at the end alone.
  int64_t Next(int64_t most, int64_t* i, int64_t* j) {
    int64_t found = 0;
    while (depth > 0 && found < most) {
      const Meeting met = stack[--depth];
      if (met.height_a == 0 && met.height_b == 0) {
        i[found] = a.order[met.a];
        j[found++] = b.order[met.b];
      } else {
        Open(met);
      }
    }
    return found;
  }

  void Open(Meeting met) {
    const Box& of_a = a.levels[met.height_a][met.a];
    const Box& of_b = b.levels[met.height_b][met.b];
    // Small nodes that meet a large one are as many as they are for long.
    const bool opens_a = met.height_b == 0 || (met.height_a > 0 && of_a.size() >= of_b.size());
    const Box* children = opens_a ? &a.levels[--met.height_a][met.a *= kFan] : &b.levels[--met.height_b][met.b *= kFan];
    int64_t apart[kFan];
    Meeting* const first = stack + depth;
    int count = 0;
    for (int child = 0; child < kFan; ++child) {
      const int64_t here = opens_a ? Apart(children[child], of_b) : Apart(of_a, children[child]);
      if (here <= 0) {
        // What overlaps by most comes last, and is opened first.
        int place = count++;
        for (; place > 0 && apart[place - 1] < here; --place) {
          apart[place] = apart[place - 1];
          first[place] = first[place - 1];
        }
        apart[place] = here;
        first[place] = met;
      }
      ++(opens_a ? met.a : met.b);
    }
    depth += count;
  }
};

// Facets, where A is moved to, and the margin.
struct Scene {
  const int64_t *a, *b, *move;
  uint32_t margin;

  // Decides facet pairs; returns how many are near, and puts their numbers first.
  int64_t Near(int64_t count, int64_t* i, int64_t* j) const {
    int32_t pairs[kFew * kCoordinates];
    uint32_t margins[kFew];
    int8_t claims[kFew];
    for (int64_t n = 0; n < count; ++n) {
      int32_t* const pair = pairs + n * kCoordinates;
      const int64_t *of_a = a + 9 * i[n], *of_b = b + 9 * j[n];
      for (int k = 0; k < 9; ++k) {
        pair[k] = static_cast<int32_t>(of_a[k] + move[k % 3]);
        pair[9 + k] = static_cast<int32_t>(of_b[k]);
      }
      margins[n] = margin;
    }
    triaxis_claims(pairs, margins, count, claims);
    int64_t near = 0;
    for (int64_t n = 0; n < count; ++n) {
      if (claims[n] < 0) {
        i[near] = i[n];
        j[near++] = j[n];
      }
    }
    return near;
  }
};

}  // namespace
}  // namespace triaxis::host

// Bytes that a search takes.
extern "C" int64_t triaxis_search_size() { return sizeof(triaxis::host::Search); }

// Begins a search. ``room`` has the form of a box.
extern "C" void triaxis_search(triaxis::host::Search* search, const triaxis::host::Box* const* levels_a,
                               int64_t height_a, const int64_t* order_a,
                               const triaxis::host::Box* const* levels_b, int64_t height_b,
                               const int64_t* order_b, const triaxis::host::Box* room) {
  search->a = {levels_a, order_a};
  search->b = {levels_b, order_b};
  search->room = *room;
  search->Begin(height_a, height_b);
}

// Goes on with it: see Search::Next.
extern "C" int64_t triaxis_search_next(triaxis::host::Search* search, int64_t most, int64_t* i, int64_t* j) {
  return search->Next(most, i, j);
}

// Decides some facet pairs, then those of a search, few at a time, until some are near; writes the numbers
// of these, at most kFew, and returns how many. ``decided``: how many pairs were, without those before where
// these did not suffice.
extern "C" int64_t triaxis_first_near(triaxis::host::Search* search, const int64_t* a, const int64_t* b,
                                      const int64_t* move, int64_t margin, const int64_t* before_i,
                                      const int64_t* before_j, int64_t before, int64_t* i, int64_t* j,
                                      int64_t* decided) {
  const triaxis::host::Scene scene{a, b, move, static_cast<uint32_t>(margin)};
  using triaxis::host::kFew;
  *decided = 0;
  for (int64_t start = 0; start < before; start += kFew) {
    const int64_t count = std::min<int64_t>(kFew, before - start);
    std::copy(before_i + start, before_i + start + count, i);
    std::copy(before_j + start, before_j + start + count, j);
    *decided += count;
    if (const int64_t near = scene.Near(count, i, j)) return near;
  }
  *decided = 0;
  while (const int64_t count = search->Next(kFew, i, j)) {
    *decided += count;
    if (const int64_t near = scene.Near(count, i, j)) return near;
  }
  return 0;
}
