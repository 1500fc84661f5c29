// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Whether a claimed axis separates a pair by more than its margin, by definition; see certificate.py. Nothing
// of the bulk checker is used.
//
// Let L >= 1 bound coordinates' differences and the margin, and 2 |x| <= L + 1 all coordinates x. A component of
// an axis is at most 2 L^2, its 1-norm 6 L^2, a projection and its partial sums 3 L^2 (L + 1), a gap, which is a
// product with a difference of vertices, 6 L^3, and margin * norm too. For L < 2^20, which is 20 bits, all are
// below 2^63; for L < 2^32 below 2^99.

#include <algorithm>
#include <cstdint>

namespace triaxis::certificate {
namespace {

constexpr int kCoordinates = 18, kAxes = 32;
constexpr int64_t kNarrow = int64_t{1} << 19;

// Points: six vertices, A first; the origin; one on each coordinate axis.
constexpr int kOrigin = 6, kUnit = 7, kPoints = 10;

// Every axis is the cross product of two vectors, each from one of the points to another: u0 -> u1, v0 -> v1.
struct Axis {
  uint8_t u0, u1, v0, v1;
};

struct Axes {
  Axis axis[kAxes];

  constexpr Axes() : axis{} {
    const auto unit = [](int k) { return static_cast<uint8_t>(kUnit + k % 3); };
    const auto from = [](int triangle, int edge) { return static_cast<uint8_t>(3 * triangle + edge % 3); };
    for (int k = 0; k < 3; ++k) axis[k] = {kOrigin, unit(k + 1), kOrigin, unit(k + 2)};
    for (int t = 0; t < 2; ++t) axis[3 + t] = {from(t, 0), from(t, 1), from(t, 1), from(t, 2)};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        axis[5 + 3 * i + j] = {from(0, i), from(0, i + 1), from(1, j), from(1, j + 1)};
        for (int t = 0; t < 2; ++t) axis[14 + 9 * t + 3 * i + j] = {from(t, i), from(t, i + 1), kOrigin, unit(j)};
      }
    }
  }
};

constexpr Axes kTable;

template <class Integer>
bool Separates(const int32_t* pair, int64_t margin, const Axis& axis) {
  Integer points[kPoints][3] = {};
  for (int i = 0; i < kCoordinates; ++i) points[i / 3][i % 3] = pair[i];
  for (int k = 0; k < 3; ++k) points[kUnit + k][k] = 1;
  Integer u[3], v[3], c[3], norm = 0;
  for (int k = 0; k < 3; ++k) {
    u[k] = points[axis.u1][k] - points[axis.u0][k];
    v[k] = points[axis.v1][k] - points[axis.v0][k];
  }
  for (int k = 0; k < 3; ++k) {
    const int next = (k + 1) % 3, last = (k + 2) % 3;
    c[k] = u[next] * v[last] - u[last] * v[next];
    norm += c[k] < 0 ? -c[k] : c[k];
  }
  Integer on[6];
  for (int i = 0; i < 6; ++i) on[i] = c[0] * points[i][0] + c[1] * points[i][1] + c[2] * points[i][2];
  const auto [low_a, high_a] = std::minmax({on[0], on[1], on[2]});
  const auto [low_b, high_b] = std::minmax({on[3], on[4], on[5]});
  return std::max(low_b - high_a, low_a - high_b) > margin * norm;
}

bool Fits(const int32_t* pair, uint32_t margin) {
  // |x|, or one less below 0.
  int32_t sizes = 0;
  for (int i = 0; i < kCoordinates; ++i) sizes |= pair[i] ^ (pair[i] >> 31);
  return sizes < kNarrow && margin < 2 * kNarrow;
}

}  // namespace
}  // namespace triaxis::certificate

// Writes 1 where the claimed axis of one of n pairs (18 coordinates each) separates it by more than its margin, 0
// where it does not; 0 as well for a claim below 0, which names no axis. Claims are at most 31.
extern "C" void triaxis_proven(const int32_t* pairs, const uint32_t* margins, const int8_t* claims, int64_t n,
                               uint8_t* proven) {
  using namespace triaxis::certificate;
  constexpr int64_t kBlock = 1024;
  for (int64_t start = 0; start < n; start += kBlock) {
    // Those that claim an axis, without a branch.
    int64_t claiming[kBlock], count = 0;
    for (int64_t i = start; i < std::min(start + kBlock, n); ++i) {
      proven[i] = 0;
      claiming[count] = i;
      count += claims[i] >= 0;
    }
    for (int64_t k = 0; k < count; ++k) {
      const int64_t i = claiming[k];
      const int32_t* pair = pairs + kCoordinates * i;
      const Axis& axis = kTable.axis[claims[i]];
      proven[i] = Fits(pair, margins[i]) ? Separates<int64_t>(pair, margins[i], axis)
                                         : Separates<__int128>(pair, margins[i], axis);
    }
  }
}
