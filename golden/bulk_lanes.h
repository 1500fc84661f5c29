// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// As many pairs at a time as a vector register holds doubles: one pair a lane.

#ifndef TRIAXIS_GOLDEN_BULK_LANES_H_
#define TRIAXIS_GOLDEN_BULK_LANES_H_

#include <cstdint>

#if defined(__AVX512F__)
#include <immintrin.h>
#endif

namespace triaxis::bulk {

#if defined(__AVX512F__)
inline constexpr int kLanes = 8;
#elif defined(__AVX__)
inline constexpr int kLanes = 4;
#else
inline constexpr int kLanes = 2;
#endif

// Numbers, and masks: comparisons of numbers give -1 or 0 in each lane.
typedef double Reals __attribute__((vector_size(8 * kLanes)));
typedef int64_t Masks __attribute__((vector_size(8 * kLanes)));

// Numbers of a pair.
inline constexpr int kCoordinates = 18;

// Loads the pairs and margins of these numbers, one a lane.
inline void LoadPairs(const int32_t* pairs, const uint32_t* margins, const int64_t (&index)[kLanes],
                      Reals (&a)[3][3], Reals (&b)[3][3], Reals& margin) {
#if defined(__AVX512F__)
  const __m512i places = _mm512_loadu_si512(index);
  const __m512i starts = _mm512_mullox_epi64(places, _mm512_set1_epi64(sizeof *pairs * kCoordinates));
  for (int i = 0; i < kCoordinates; ++i) {
    const __m256i column = _mm512_i64gather_epi32(starts, pairs + i, 1);
    (i < 9 ? a : b)[i % 9 / 3][i % 3] = (Reals)_mm512_cvtepi32_pd(column);
  }
  margin = (Reals)_mm512_cvtepu32_pd(_mm512_i64gather_epi32(places, margins, sizeof *margins));
#else
  for (int lane = 0; lane < kLanes; ++lane) {
    const int32_t* pair = pairs + kCoordinates * index[lane];
    for (int i = 0; i < kCoordinates; ++i) (i < 9 ? a : b)[i % 9 / 3][i % 3][lane] = pair[i];
    margin[lane] = margins[index[lane]];
  }
#endif
}

inline Reals AllLanes(double value) { return value - Reals{}; }

inline Reals Min(Reals x, Reals y) { return x < y ? x : y; }

inline Reals Max(Reals x, Reals y) { return x > y ? x : y; }

inline Reals Select(Masks mask, Reals x, Reals y) { return mask ? x : y; }

inline Reals Abs(Reals x) {
  return (Reals)((Masks)x & INT64_MAX);
}

// A number with the sign of x.
inline Reals Sign(Reals x) { return x; }

inline bool Any(Masks mask) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask((__m512i)mask, (__m512i)mask) != 0;
#else
  int64_t any = 0;
  for (int lane = 0; lane < kLanes; ++lane) any |= mask[lane];
  return any != 0;
#endif
}

// Rounds to a multiple of 2^kBits, for |x| <= 2^(kBits + 50): adding 1.5 * 2^(kBits + 52) leaves no
// finer bits, and subtracting it again is exact.
template <int kBits>
inline Reals Round(Reals x) {
  constexpr double kShift = 0x1.8p52 * static_cast<double>(uint64_t{1} << kBits);
  return (x + kShift) - kShift;
}

}  // namespace triaxis::bulk

#endif  // TRIAXIS_GOLDEN_BULK_LANES_H_
