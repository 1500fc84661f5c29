// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Variants of pairs, in one pass over them; see symmetry.py, which has the tables. Pairs are 18 numbers each, of
// 32 bits or of 64.

#include <algorithm>
#include <cstdint>

namespace triaxis::symmetry {
namespace {

constexpr int kVertices = 6, kNumbers = 18, kAhead = 12;

// The vertex at each place of an order; the coordinate at each place of a symmetry, and what is xored onto it, 0
// or -1.
struct Tables {
  const uint8_t* vertices;
  const uint8_t* coordinates;
  const int8_t* complements;
};

// out[i] is pairs[rows[i]], in the order of number orders[i], under the symmetry of number symmetries[i].
template <class Integer>
void Rearrange(const Integer* pairs, const uint32_t* rows, const uint8_t* orders, const uint8_t* symmetries,
               int64_t n, const Tables& tables, Integer* out) {
  for (int64_t i = 0; i < n; ++i) {
    const Integer* pair = pairs + int64_t{kNumbers} * rows[i];
    // Rows are anywhere in memory.
    const Integer* later = pairs + int64_t{kNumbers} * rows[std::min(i + kAhead, n - 1)];
    __builtin_prefetch(later);
    __builtin_prefetch(later + kNumbers - 1);
    const uint8_t* order = tables.vertices + kVertices * orders[i];
    const uint8_t* from = tables.coordinates + 3 * symmetries[i];
    const int8_t* complement = tables.complements + 3 * symmetries[i];
    for (int place = 0; place < kVertices; ++place) {
      const Integer* vertex = pair + 3 * order[place];
      for (int k = 0; k < 3; ++k) *out++ = vertex[from[k]] ^ complement[k];
    }
  }
}

struct Interval {
  int64_t low, high;
};

template <class Integer>
Interval Bounds(const Integer* pair, int k) {
  Integer low = pair[k], high = pair[k];
  for (int i = k + 3; i < kNumbers; i += 3) {
    low = std::min(low, pair[i]);
    high = std::max(high, pair[i]);
  }
  return {low, high};
}

// out[i] is pairs[i], moved along each coordinate to the place of number draw / 2^32 * places of those in range,
// for a draw of 32 bits, one of draws (3, n). There are at most 2^32 places: the product fits.
template <class Integer>
void Place(const Integer* pairs, const uint32_t* draws, int64_t n, Interval range, Integer* out) {
  for (int64_t i = 0; i < n; ++i) {
    for (int k = 0; k < 3; ++k) {
      const Interval bounds = Bounds(pairs + kNumbers * i, k);
      const uint64_t places = range.high - range.low + 1 - (bounds.high - bounds.low);
      const int64_t shift = range.low - bounds.low + static_cast<int64_t>((draws[n * k + i] * places) >> 32);
      for (int j = k; j < kNumbers; j += 3) {
        out[kNumbers * i + j] = static_cast<Integer>(pairs[kNumbers * i + j] + shift);
      }
    }
  }
}

}  // namespace
}  // namespace triaxis::symmetry

#define TRIAXIS_VARIANTS(BITS)                                                                         \
  extern "C" void triaxis_rearranged_##BITS(                                                           \
      const int##BITS##_t* pairs, const uint32_t* rows, const uint8_t* orders,                         \
      const uint8_t* symmetries, int64_t n, const uint8_t* vertices, const uint8_t* coordinates,       \
      const int8_t* complements, int##BITS##_t* out) {                                                 \
    triaxis::symmetry::Rearrange(pairs, rows, orders, symmetries, n,                                   \
                                 {vertices, coordinates, complements}, out);                           \
  }                                                                                                    \
  extern "C" void triaxis_placed_##BITS(const int##BITS##_t* pairs, const uint32_t* draws, int64_t n,  \
                                        int64_t low, int64_t high, int##BITS##_t* out) {               \
    triaxis::symmetry::Place(pairs, draws, n, {low, high}, out);                                       \
  }

TRIAXIS_VARIANTS(32)
TRIAXIS_VARIANTS(64)

// out[i] is pairs[i], moved so that zero is in the middle of its box, rounded such that all stays in range.
extern "C" void triaxis_centred_32(const int32_t* pairs, int64_t n, int32_t* out) {
  using namespace triaxis::symmetry;
  for (int64_t i = 0; i < n; ++i, pairs += kNumbers, out += kNumbers) {
    for (int k = 0; k < 3; ++k) {
      const Interval bounds = Bounds(pairs, k);
      const int64_t middle = (bounds.low + bounds.high + 1) >> 1;
      for (int j = k; j < kNumbers; j += 3) out[j] = static_cast<int32_t>(pairs[j] - middle);
    }
  }
}
