// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The bulk checker's verdicts alone: the lowest-numbered separating axis of each pair, exactly, for
// 32-bit coordinates and margins. Built as a shared library; see bulk.py.
//
// Each axis is asked in doubles first. Let L bound the differences of coordinates, let the margin be at
// most L + 2, and u = 2^-53. Differences of coordinates are exact. Up to terms of u^2, fused or not:
// - A component of an axis that is a cross product of edges is off by at most 6 u L^2, its 1-norm by 36
//   u L^2, a projection, at most 6 L^3, by 42 u L^3, the difference of two by 96 u L^3; so an excess of
//   at most 18.1 L^3, made of a projection and two such differences, by less than 400 u L^3 for L >
//   2^16. Up to there nothing is rounded (bulk_narrow.h).
// - On an axis of an edge and a coordinate, whose components are exact, a projection is at most 2 L^2,
//   the excess 6.1 L^2, and by less than 25 u L^2 off for L > 2^24. Up to there nothing is rounded.
//
// Where an excess is closer to 0 than that, a bound of its own products decides, or else the exact arithmetic
// of bulk_wide.h.

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>

#include "bulk_lanes.h"
#include "bulk_wide.h"

namespace triaxis::bulk {
namespace {

// The largest extents at which nothing is rounded on an axis that is a cross product of two edges, on its
// components alone, and on one of an edge and a coordinate.
constexpr double kExact = 0x1p16, kExactComponents = 0x1p26, kExactEdge = 0x1p24;
// What excesses may be off, in units of the cube and of the square of the extent, and in units of the
// sizes of the products of which it is made.
constexpr double kError = 512 * 0x1p-53, kErrorEdge = 64 * 0x1p-53, kErrorOfSizes = 16 * 0x1p-53;

using Vector = Reals[3];
template <size_t kCount>
using Points = std::array<const Vector*, kCount>;

inline Reals Least(Reals x, Reals y, Reals z) { return Min(Min(x, y), z); }
inline Reals Most(Reals x, Reals y, Reals z) { return Max(Max(x, y), z); }

// One pair in each lane.
struct Block {
  int64_t index[kLanes];
  Reals a[3][3], b[3][3];
  Reals margin;

  void Load(const int32_t* pairs, const uint32_t* margins) {
    LoadPairs(pairs, margins, index, a, b, margin);
  }
};

// The axes that separate, as bits by their numbers. Later axes may be missing where an earlier one
// separates.
class Claims {
 public:
  void Take(int number, Masks separates) { found_ |= separates & (int64_t{1} << number); }

  // Where no axis separates, so far.
  Masks open() const { return found_ == 0; }

  int lowest(int lane) const { return found_[lane] ? __builtin_ctzll(found_[lane]) : -1; }

 private:
  Masks found_{};
};

// Three coordinates, and a fourth place that is not used.
typedef int32_t Row __attribute__((vector_size(16)));
typedef int64_t LongRow __attribute__((vector_size(32)));

inline Row Lesser(Row x, Row y) { return x < y ? x : y; }
inline Row Greater(Row x, Row y) { return x > y ? x : y; }

// The first of the three box axes that separates a pair, or -1: exact in 64 bits. Reads a number more
// than the pair has.
inline int ByBoxes(const int32_t* pair, uint32_t margin) {
  Row vertex[6];
  for (int i = 0; i < 6; ++i) std::memcpy(&vertex[i], pair + 3 * i, sizeof vertex[i]);
  const auto wide = [](Row row) { return __builtin_convertvector(row, LongRow); };
  const LongRow low_a = wide(Lesser(Lesser(vertex[0], vertex[1]), vertex[2]));
  const LongRow low_b = wide(Lesser(Lesser(vertex[3], vertex[4]), vertex[5]));
  const LongRow up = low_b - wide(Greater(Greater(vertex[0], vertex[1]), vertex[2]));
  const LongRow down = low_a - wide(Greater(Greater(vertex[3], vertex[4]), vertex[5]));
  const LongRow separates = (up > down ? up : down) > static_cast<int64_t>(margin);
  return separates[0] ? 0 : separates[1] ? 1 : separates[2] ? 2 : -1;
}

// The other axes.
class Examination {
 public:
  explicit Examination(const Block& block) {
    Reals extent{};
    for (int k = 0; k < 3; ++k) {
      const auto& a = block.a;
      const auto& b = block.b;
      extent = Max(extent, Max(Most(a[0][k], a[1][k], a[2][k]), Most(b[0][k], b[1][k], b[2][k])) -
                               Min(Least(a[0][k], a[1][k], a[2][k]), Least(b[0][k], b[1][k], b[2][k])));
      for (int i = 0; i < 3; ++i) {
        const int next = (i + 1) % 3;
        edges_a_[i][k] = a[next][k] - a[i][k];
        edges_b_[i][k] = b[next][k] - b[i][k];
        third_a_[next][k] = a[i][k] - a[next][k];
        for (int j = 0; j < 3; ++j) apart_[i][j][k] = b[j][k] - a[i][k];
      }
    }
    // From a margin of L + 2 on, nothing separates: see bulk.cpp.
    margin_ = Min(block.margin, extent + 2);
    error_ = extent > kExact ? extent * extent * extent * kError : Reals{};
    error_edge_ = extent > kExactEdge ? extent * extent * kErrorEdge : Reals{};
    exact_components_ = extent <= kExactComponents;
    watched_ = error_ > 0;
  }

  Claims Run() { return Any(margin_ > 0) ? Decide<true>() : Decide<false>(); }

 private:
  // ``kMargin``: some margin is not 0. Without one, the axes up to 13 decide every pair that is not in
  // one plane.
  template <bool kMargin>
  Claims Decide() {
    Reals on_b[3], on_a[3];
    const Masks off_a = ByNormal<kMargin>(3, edges_a_, {&apart_[0][0], &apart_[0][1], &apart_[0][2]}, on_b);
    const Masks off_b = ByNormal<kMargin>(4, edges_b_, {&apart_[0][0], &apart_[1][0], &apart_[2][0]}, on_a);
    if (!Any(claims_.open())) return claims_;
    Watch<kMargin>();
    ByEdges<kMargin>(on_a, on_b);
    if (kMargin ? !Any(claims_.open()) : !Any(claims_.open() & ~(off_a | off_b))) return claims_;
    for (int i = 0; i < 3; ++i) {
      for (int k = 0; k < 3; ++k) {
        ByEdge<kMargin>(14 + 3 * i + k, edges_a_[i], k, third_a_[i],
                        {&apart_[i][0], &apart_[i][1], &apart_[i][2]});
      }
    }
    for (int j = 0; j < 3; ++j) {
      for (int k = 0; k < 3; ++k) {
        // All signs reversed: A's vertices come relative to B's, and B's third vertex likewise.
        ByEdge<kMargin>(23 + 3 * j + k, edges_b_[j], k, edges_b_[(j + 2) % 3],
                        {&apart_[0][j], &apart_[1][j], &apart_[2][j]});
      }
    }
    return claims_;
  }

  // Where nothing is rounded, an excess of 0 is one; in one plane, the products of two edges separate
  // nothing without a margin.
  template <bool kMargin>
  void Watch() {
    watched_ &= claims_.open();
    if constexpr (!kMargin) watched_ &= ~flat_;
  }

  // The normal of the triangle with these edges; the vertices of the other one, relative to it, fall
  // ``on`` it. Returns where one of them is surely off the triangle's plane.
  template <bool kMargin>
  Masks ByNormal(int number, const Vector (&edges)[3], Points<3> far, Reals (&on)[3]) {
    const Cross c(edges[0], edges[1]);
    for (int n = 0; n < 3; ++n) on[n] = c.Dot(*far[n]);
    const Reals low = Least(on[0], on[1], on[2]), high = Most(on[0], on[1], on[2]);
    Take<kMargin, 0, 3>(number, c, Max(low, -high), edges[0], edges[1], {}, far);
    return Max(high, -low) > error_;
  }

  // The cross products of an edge of each, which begin at A_i and B_j. Relative to A_i, A lies between 0
  // and -N_A.f_j, and B between D and D + N_B.e_i, with D = c.(B_j - A_i); see docs/theory.md, section 4.
  template <bool kMargin>
  void ByEdges(const Reals (&on_a)[3], const Reals (&on_b)[3]) {
    Reals low_a[3], high_a[3];
    for (int j = 0; j < 3; ++j) {
      const Reals third = on_b[j] - on_b[(j + 1) % 3];
      low_a[j] = Min(third, Reals{});
      high_a[j] = Max(third, Reals{});
    }
    for (int i = 0; i < 3; ++i) {
      const Reals third = on_a[i] - on_a[(i + 1) % 3];
      const Reals low_b = Min(third, Reals{}), high_b = Max(third, Reals{});
      for (int j = 0; j < 3; ++j) {
        const Cross c(edges_a_[i], edges_b_[j]);
        const Reals on = c.Dot(apart_[i][j]);
        const Reals gap = Max(on + (low_b - high_a[j]), (low_a[j] - high_b) - on);
        Take<kMargin, 1, 2>(5 + 3 * i + j, c, gap, edges_a_[i], edges_b_[j], {&third_a_[i]},
                            {&apart_[i][j], &apart_[i][(j + 2) % 3]});
      }
    }
  }

  struct Cross {
    Reals c[3];

    Cross(const Vector& e, const Vector& f)
        : c{e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]} {}

    Reals Dot(const Vector& x) const { return c[0] * x[0] + c[1] * x[1] + c[2] * x[2]; }
    Reals Norm() const { return Abs(c[0]) + Abs(c[1]) + Abs(c[2]); }
  };

  // Decides the axis c = e x f by the gap on it, or by closer looks: one triangle has projections 0 and
  // those of ``near``, the other one those of ``far``.
  template <bool kMargin, size_t kNear, size_t kFar>
  [[gnu::always_inline]] void Take(int number, const Cross& c, Reals gap, const Vector& e, const Vector& f,
                                   Points<kNear> near, Points<kFar> far) {
    const Reals excess = kMargin ? gap - margin_ * c.Norm() : gap;
    Masks separates = excess > error_;
    if (Any((Abs(excess) <= error_) & watched_)) separates = Closely(e, f, near, far);
    claims_.Take(number, separates);
  }

  // The excess may be off by what its products call for: with P the sum of the sizes of the two products
  // of a component, and D that of P |x| over the components, a component is off by 3 u P, a projection
  // by 7 u D, a gap by 8 u (D + D'), the norm by 6 u P, so that the excess is by less than 10 u (D + D'
  // + margin * P). Where factors are 0, as in faces along coordinate planes, so is what they contribute.
  template <size_t kNear, size_t kFar>
  [[gnu::noinline]] Masks Closely(const Vector& e, const Vector& f, Points<kNear> near, Points<kFar> far) {
    const Cross c(e, f);
    Reals size[3], sizes{};
    for (int k = 0; k < 3; ++k) {
      const int next = (k + 1) % 3, last = (k + 2) % 3;
      size[k] = Abs(e[next] * f[last]) + Abs(e[last] * f[next]);
      sizes += size[k];
    }
    const Reals least_norm = sizes * kErrorOfSizes;
    sizes *= margin_;
    const auto add = [&](const Vector& x) {
      sizes += size[0] * Abs(x[0]) + size[1] * Abs(x[1]) + size[2] * Abs(x[2]);
    };
    Reals low{}, high{}, far_low = c.Dot(*far[0]), far_high = far_low;
    for (const Vector* x : near) {
      add(*x);
      low = Min(low, c.Dot(*x));
      high = Max(high, c.Dot(*x));
    }
    for (const Vector* x : far) {
      add(*x);
      far_low = Min(far_low, c.Dot(*x));
      far_high = Max(far_high, c.Dot(*x));
    }
    const Reals norm = c.Norm(), error = Min(error_, sizes * kErrorOfSizes);
    const Reals excess = Max(far_low - high, low - far_high) - margin_ * norm;
    const Masks separates = excess > error;
    if constexpr (kNear == 0) {
      flat_ |= (error == 0) & (far_low == 0) & (far_high == 0) & (norm > least_norm) & (margin_ == 0);
    }
    // Known to be 0, or along a coordinate, of which all were asked first.
    const Masks x = size[0] == 0, y = size[1] == 0, z = size[2] == 0;
    const Masks idle = ((norm == 0) & exact_components_) | (x & y) | (x & z) | (y & z);
    const Masks doubtful = (Abs(excess) <= error) & (error > 0) & ~idle & watched_;
    return Any(doubtful) ? (doubtful ? Exactly(e, f, near, far) : separates) : separates;
  }

  template <size_t kNear, size_t kFar>
  [[gnu::noinline]] Masks Exactly(const Vector& e, const Vector& f, Points<kNear> near, Points<kFar> far) {
    Wide::Factor x[3], y[3];
    for (int k = 0; k < 3; ++k) {
      x[k] = Wide::ToFactor(e[k]);
      y[k] = Wide::ToFactor(f[k]);
    }
    const Wide::Component c[3] = {Wide::Minor(x[1], y[2], x[2], y[1]), Wide::Minor(x[2], y[0], x[0], y[2]),
                                  Wide::Minor(x[0], y[1], x[1], y[0])};
    const auto dot = [&](const Vector& point) {
      const Wide::Factor factors[3] = {Wide::ToFactor(point[0]), Wide::ToFactor(point[1]),
                                       Wide::ToFactor(point[2])};
      return Wide::Dot(c, factors);
    };
    Wide::Value low{}, high{}, far_low = dot(*far[0]), far_high = far_low;
    for (const Vector* point : near) {
      const Wide::Value on = dot(*point);
      low = Min(low, on);
      high = Max(high, on);
    }
    for (size_t n = 1; n < kFar; ++n) {
      const Wide::Value on = dot(*far[n]);
      far_low = Min(far_low, on);
      far_high = Max(far_high, on);
    }
    const Wide::Component norm = Wide::Norm(c);
    if constexpr (kNear == 0) flat_ |= (Sign(far_low) == 0) & (Sign(far_high) == 0) & (Sign(norm) > 0);
    return Beyond(low, high, far_low, far_high, Wide::Times(norm, Wide::ToFactor(margin_)));
  }

  // Whether one interval lies beyond the other by more than the reach; sums of four values are exact.
  static Masks Beyond(Wide::Value low, Wide::Value high, Wide::Value far_low, Wide::Value far_high,
                      Wide::Value reach) {
    return (Sign(far_low - high - reach) > 0) | (Sign(low - far_high - reach) > 0);
  }

  // The axis (edge e) x (coordinate k), with components c and d along the other two coordinates: as
  // above.
  template <bool kMargin>
  [[gnu::always_inline]] void ByEdge(int number, const Vector& e, int k, const Vector& near, Points<3> far) {
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    const Reals c = e[last], d = -e[next];
    const auto dot = [&](const Vector& v) { return c * v[next] + d * v[last]; };
    const Reals on = dot(near), x = dot(*far[0]), y = dot(*far[1]), z = dot(*far[2]);
    const Reals gap = Max(Least(x, y, z) - Max(on, Reals{}), Min(on, Reals{}) - Most(x, y, z));
    const Reals excess = kMargin ? gap - margin_ * (Abs(c) + Abs(d)) : gap;
    Masks separates = excess > error_edge_;
    // Along a coordinate it is of no use: those were asked first.
    const Masks oblique = (c != 0) & (d != 0);
    if (Any((Abs(excess) <= error_edge_) & (error_edge_ > 0) & oblique & claims_.open())) {
      separates = EdgeClosely(c, d, excess, next, last, near, far);
    }
    claims_.Take(number, separates);
  }

  [[gnu::noinline]] Masks EdgeClosely(Reals c, Reals d, Reals excess, int next, int last, const Vector& near,
                                      Points<3> far) const {
    const auto size = [&](const Vector& v) { return Abs(c * v[next]) + Abs(d * v[last]); };
    const Reals norm = Abs(c) + Abs(d);
    const Reals sizes = size(near) + size(*far[0]) + size(*far[1]) + size(*far[2]) + margin_ * norm;
    const Reals error = Min(error_edge_, sizes * kErrorOfSizes);
    const Masks separates = excess > error;
    const Masks doubtful = (Abs(excess) <= error) & (error > 0) & claims_.open();
    if (!Any(doubtful)) return separates;
    const auto dot = [&](const Vector& x) {
      return Wide::EdgeDot(c, Wide::ToFactor(x[next]), d, Wide::ToFactor(x[last]));
    };
    const Wide::Value zero{}, on = dot(near), x = dot(*far[0]), y = dot(*far[1]), z = dot(*far[2]);
    const Masks exactly = Beyond(Min(on, zero), Max(on, zero), Min(Min(x, y), z), Max(Max(x, y), z),
                                 Wide::EdgeTimes(norm, Wide::ToFactor(margin_)));
    return doubtful ? exactly : separates;
  }

  Vector edges_a_[3], edges_b_[3];
  // The vertex of A that edge i leaves out, relative to where that begins; vertex j of B relative to i
  // of A.
  Vector third_a_[3], apart_[3][3];
  Reals margin_, error_, error_edge_;
  // Lanes where an excess close to 0 is looked at again; where both triangles are known to be in one
  // plane, and that of one of them is known.
  Masks exact_components_, watched_, flat_{};
  Claims claims_;
};

// What is read and written.
struct Job {
  const int32_t* pairs;
  const uint32_t* margins;
  int8_t* claims;

  void Store(const Block& block, const Claims& found, int count) const {
    for (int lane = 0; lane < count; ++lane) {
      claims[block.index[lane]] = static_cast<int8_t>(found.lowest(lane));
    }
  }
};

// Pairs that no box axis separates, until they fill all lanes.
class Queue {
 public:
  explicit Queue(const Job& job) : job_(job) {}

  void Add(int64_t index) {
    block_.index[count_++] = index;
    if (count_ == kLanes) Finish();
  }

  void Finish() {
    if (count_ == 0) return;
    // Unused lanes repeat the last pair.
    std::fill(block_.index + count_, block_.index + kLanes, block_.index[count_ - 1]);
    block_.Load(job_.pairs, job_.margins);
    job_.Store(block_, Examination(block_).Run(), count_);
    count_ = 0;
  }

 private:
  const Job& job_;
  Block block_;
  int count_ = 0;
};

void Run(const Job& job, int64_t n) {
  Queue undecided(job);
  for (int64_t i = 0; i < n; ++i) {
    const int32_t* pair = job.pairs + kCoordinates * i;
    int32_t last[kCoordinates + 1] = {};
    if (i == n - 1) {
      std::copy(pair, pair + kCoordinates, last);
      pair = last;
    }
    const int found = ByBoxes(pair, job.margins[i]);
    job.claims[i] = static_cast<int8_t>(found);
    if (found < 0) undecided.Add(i);
  }
  undecided.Finish();
}

}  // namespace
}  // namespace triaxis::bulk

// Writes the lowest-numbered separating axis, -1 where there is none, of n pairs (18 coordinates each).
extern "C" void triaxis_claims(const int32_t* pairs, const uint32_t* margins, int64_t n, int8_t* claims) {
  triaxis::bulk::Run({pairs, margins, claims}, n);
}
