// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The core's answers in C: near(A, B, m) of pairs of triangles, the axis that a clear is shown by, and a
// second look at such an axis by other code. Exact for all coordinates of 32 bits and margins of 32 bits. To build:
//
//   c++ -O3 -march=native -std=c++20 -c golden/bulk_claims.cpp golden/certificate.cpp
//   cc -Idocs program.c bulk_claims.o certificate.o -lstdc++
//
// A pair is 18 numbers: x, y, z of A1, A2, A3, B1, B2, B3. Nothing is kept between calls, which may go on at the same
// time. Axes are numbered as in docs/theory.md, section 2.

#ifndef TRIAXIS_H_
#define TRIAXIS_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum { TRIAXIS_COORDINATES = 18, TRIAXIS_NEAR = -1 };

// Writes for each of n pairs the first axis that separates it by more than its margin, or TRIAXIS_NEAR.
void triaxis_claims(const int32_t* pairs, const uint32_t* margins, int64_t n, int8_t* claims);

// Writes 1 for each of n pairs that the axis claimed, 0..31, separates by more than the margin; 0 for others, and
// where none is claimed.
void triaxis_proven(const int32_t* pairs, const uint32_t* margins, const int8_t* claims, int64_t n, uint8_t* proven);

// Returns 1 where the Chebyshev distance of both triangles is at most the margin, 0 where it is more.
static inline int triaxis_near(const int32_t pair[TRIAXIS_COORDINATES], uint32_t margin) {
  int8_t claim;
  triaxis_claims(pair, &margin, 1, &claim);
  return claim == TRIAXIS_NEAR;
}

#ifdef __cplusplus
}
#endif

#endif  // TRIAXIS_H_
