// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The bulk checker: all facts of pairs (see facts.py), exactly, for 32-bit coordinates and margins.
// Built as a shared library; see bulk.py.

#include <algorithm>
#include <cstdint>

#include "bulk_axes.h"
#include "bulk_lanes.h"
#include "bulk_narrow.h"
#include "bulk_wide.h"

namespace triaxis::bulk {

// Where facts go: the fields of Facts in facts.py.
struct FactArrays {
  uint32_t *above, *below, *upper, *lower, *level, *clear_step, *near_step, *flat;
  uint8_t *support_a, *support_b, *rank_a, *rank_b, *order_a, *order_b;
  uint8_t *coplanar, *a_in_b, *b_in_a;
  int32_t *low, *high;
  uint32_t *extent, *kind;
};

namespace {

constexpr int64_t kNormals = 0b11 << 3;
constexpr int64_t kNormalA = 1 << 3;
constexpr int64_t kNormalB = 1 << 4;
constexpr int64_t kEdgeCrossEdge = 0x1ff << 5;

// One pair in each lane.
struct Input {
  int64_t index[kLanes];
  Reals a[3][3], b[3][3];  // As they are, not relative.
  Reals low, high;
  // The largest difference of coordinates; the margin, or a smaller one of the same effect.
  Reals extent, margin;
};

Input Load(const int32_t* pairs, const uint32_t* margins, const int64_t* index) {
  Input input;
  std::copy(index, index + kLanes, input.index);
  LoadPairs(pairs, margins, input.index, input.a, input.b, input.margin);
  for (int k = 0; k < 3; ++k) {
    const auto& a = input.a;
    const auto& b = input.b;
    const Reals low = Min(Min(Min(a[0][k], a[1][k]), a[2][k]), Min(Min(b[0][k], b[1][k]), b[2][k]));
    const Reals high = Max(Max(Max(a[0][k], a[1][k]), a[2][k]), Max(Max(b[0][k], b[1][k]), b[2][k]));
    input.low = k ? Min(input.low, low) : low;
    input.high = k ? Max(input.high, high) : high;
    input.extent = k ? Max(input.extent, high - low) : high - low;
  }
  // A gap is at most L |c|1, L the extent. From a margin of L + 2 on, the excess is at most -2 |c|1, which
  // is less than -g: nothing separates, is level, or is a step away, and the margin matters no more.
  input.margin = Min(input.margin, input.extent + 2);
  return input;
}

template <class Number>
AxisFacts Decide(const Input& input) {
  Pair<Number> pair;
  for (int i = 0; i < 3; ++i) {
    const int next = (i + 1) % 3;
    for (int k = 0; k < 3; ++k) {
      pair.a[i][k] = Number::ToFactor(input.a[i][k] - input.a[0][k]);
      pair.b[i][k] = Number::ToFactor(input.b[i][k] - input.a[0][k]);
      pair.edges_a[i][k] = Number::ToFactor(input.a[next][k] - input.a[i][k]);
      pair.edges_b[i][k] = Number::ToFactor(input.b[next][k] - input.b[i][k]);
    }
  }
  pair.margin = Number::ToFactor(input.margin);
  return ExamineAll(pair);
}

Masks Equal(const Reals (&x)[3], const Reals (&y)[3]) {
  return (x[0] == y[0]) & (x[1] == y[1]) & (x[2] == y[2]);
}

Masks NotAfter(const Reals (&x)[3], const Reals (&y)[3]) {
  return (x[0] < y[0]) |
         ((x[0] == y[0]) & ((x[1] < y[1]) | ((x[1] == y[1]) & (x[2] <= y[2]))));
}

// The first permutation, in the order of itertools.permutations, that sorts the vertices.
Masks Order(const Reals (&vertices)[3][3]) {
  const Masks le01 = NotAfter(vertices[0], vertices[1]);
  const Masks le02 = NotAfter(vertices[0], vertices[2]);
  const Masks le12 = NotAfter(vertices[1], vertices[2]);
  const Masks zero{};
  const Masks first = le12 ? zero : (le02 ? zero + 1 : zero + 4);
  const Masks second = le02 ? zero + 2 : (le12 ? zero + 3 : zero + 5);
  return le01 ? first : second;
}

Masks Rank(const Reals (&vertices)[3][3], Masks normal_not_zero) {
  const Masks point = Equal(vertices[0], vertices[1]) & Equal(vertices[0], vertices[2]);
  const Masks zero{};
  return normal_not_zero ? zero + 2 : (point ? zero : zero + 1);
}

// Whether all six vertices lie in one plane. A flat axis proves that they do. Without one they do not,
// where a normal is not 0, since it would be flat; nor where two segments have directions with a cross
// product that is not 0, since that would be flat. What is left are points and parallel segments.
Masks Coplanar(const AxisFacts& found) {
  return (found.flat != 0) | ((found.not_zero & (kNormals | kEdgeCrossEdge)) == 0);
}

// The number that facts.py puts together.
uint32_t Kind(const AxisFacts& found, int lane, int64_t rank_a, int64_t rank_b) {
  const auto one_of = [lane](const Masks& mask) { return static_cast<uint32_t>(mask[lane]); };
  const uint32_t separating = one_of(found.above) | one_of(found.below);
  uint32_t kind = separating ? __builtin_ctz(separating) + 1 : 0;
  kind = kind << 2 | static_cast<uint32_t>(rank_a);
  kind = kind << 2 | static_cast<uint32_t>(rank_b);
  kind = kind << 1 | (one_of(found.level) != 0);
  kind = kind << 1 | ((one_of(found.clear_step) & separating) != 0);
  kind = kind << 1 | (one_of(found.near_step) != 0);
  kind = kind << 1 | (one_of(found.flat) != 0);
  kind = kind << 2 | __builtin_popcount(one_of(found.support_a));
  return kind << 2 | __builtin_popcount(one_of(found.support_b));
}

void Store(const Input& input, const AxisFacts& found, const FactArrays& out) {
  const Masks rank_a = Rank(input.a, (found.not_zero & kNormalA) != 0);
  const Masks rank_b = Rank(input.b, (found.not_zero & kNormalB) != 0);
  const Masks order_a = Order(input.a), order_b = Order(input.b);
  const Masks coplanar = Coplanar(found);
  for (int lane = 0; lane < kLanes; ++lane) {
    const int64_t i = input.index[lane];
    out.above[i] = found.above[lane];
    out.below[i] = found.below[lane];
    out.upper[i] = found.upper[lane];
    out.lower[i] = found.lower[lane];
    out.level[i] = found.level[lane];
    out.clear_step[i] = found.clear_step[lane];
    out.near_step[i] = found.near_step[lane];
    out.flat[i] = found.flat[lane];
    out.support_a[i] = found.support_a[lane];
    out.support_b[i] = found.support_b[lane];
    out.rank_a[i] = rank_a[lane];
    out.rank_b[i] = rank_b[lane];
    out.order_a[i] = order_a[lane];
    out.order_b[i] = order_b[lane];
    out.coplanar[i] = coplanar[lane] & 1;
    out.a_in_b[i] = found.a_in_b[lane] & 1;
    out.b_in_a[i] = found.b_in_a[lane] & 1;
    out.low[i] = input.low[lane];
    out.high[i] = input.high[lane];
    out.extent[i] = input.extent[lane];
    out.kind[i] = Kind(found, lane, rank_a[lane], rank_b[lane]);
  }
}

// What is read and written.
struct Job {
  const int32_t* pairs;
  const uint32_t* margins;
  const FactArrays& out;
};

// Pairs that wait until they fill all lanes.
template <class Number>
class Group {
 public:
  explicit Group(const Job& job) : job_(job) {}

  void Add(int64_t index) {
    index_[count_++] = index;
    if (count_ == kLanes) Finish();
  }

  void Finish() {
    if (count_ == 0) return;
    // Unused lanes repeat the last pair.
    std::fill(index_ + count_, index_ + kLanes, index_[count_ - 1]);
    const Input input = Load(job_.pairs, job_.margins, index_);
    Store(input, Decide<Number>(input), job_.out);
    count_ = 0;
  }

 private:
  const Job& job_;
  int64_t index_[kLanes];
  int count_ = 0;
};

void Run(const Job& job, int64_t n) {
  Group<Narrow> narrow(job);
  Group<Wide> wide(job);
  for (int64_t start = 0; start < n; start += kLanes) {
    int64_t index[kLanes];
    for (int lane = 0; lane < kLanes; ++lane) index[lane] = std::min(start + lane, n - 1);
    const Input input = Load(job.pairs, job.margins, index);
    const Masks too_wide = input.extent > Narrow::kLargestExtent;
    if (!Any(too_wide)) {
      Store(input, Decide<Narrow>(input), job.out);
      continue;
    }
    for (int lane = 0; lane < std::min<int64_t>(kLanes, n - start); ++lane) {
      if (too_wide[lane]) {
        wide.Add(index[lane]);
      } else {
        narrow.Add(index[lane]);
      }
    }
  }
  narrow.Finish();
  wide.Finish();
}

}  // namespace
}  // namespace triaxis::bulk

// Writes the facts of n pairs (18 coordinates each) at their margins.
extern "C" void triaxis_facts(const int32_t* pairs, const uint32_t* margins, int64_t n,
                              const triaxis::bulk::FactArrays* out) {
  triaxis::bulk::Run({pairs, margins, *out}, n);
}
