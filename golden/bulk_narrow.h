// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Exact arithmetic in doubles, for pairs that fit a cube of side 2^16.
//
// All values are integers. Let L <= 2^16 bound the differences of coordinates, and let the margin be at
// most L + 2. A component of an axis is at most 2 L^2, its 1-norm at most 6 L^2, a projection relative to
// A1, and each partial sum of one, at most 6 L^3. So a gap is at most 12 L^3, margin * norm at most
// 6 L^2 (L + 2), and no value exceeds 12 L^3 + 6 L^2 (L + 2) < 18.1 * 2^48 < 2^53: each is exact, in
// whatever order it is summed, with or without fused multiplication.

#ifndef TRIAXIS_GOLDEN_BULK_NARROW_H_
#define TRIAXIS_GOLDEN_BULK_NARROW_H_

#include "bulk_lanes.h"

namespace triaxis::bulk {

struct Narrow {
  static constexpr double kLargestExtent = 0x1p16;

  // A coordinate, an edge or a margin; a component or a norm of an axis; a projection.
  using Factor = Reals;
  using Component = Reals;
  using Value = Reals;

  static Factor ToFactor(Reals x) { return x; }
  static Reals ToReals(Factor x) { return x; }
  static Value ToValue(Factor x) { return x; }
  static Component ToComponent(Reals x) { return x; }

  // p q - r s.
  static Component Minor(Factor p, Factor q, Factor r, Factor s) { return p * q - r * s; }

  static Component Norm(const Component (&c)[3]) { return Abs(c[0]) + Abs(c[1]) + Abs(c[2]); }

  static Value Dot(const Component (&c)[3], const Factor (&x)[3]) {
    return c[0] * x[0] + c[1] * x[1] + c[2] * x[2];
  }

  // c x + d y.
  static Value EdgeDot(Reals c, Factor x, Reals d, Factor y) { return c * x + d * y; }

  static Value Times(Component norm, Factor margin) { return norm * margin; }

  static Value EdgeTimes(Reals norm, Factor margin) { return norm * margin; }

  // Which of the lanes asked for have an excess, not 0, that divides these components; and whether that is
  // quicker than to look whether a lane asks.
  static constexpr bool kDividesFast = true;
  template <int kCount>
  static Masks Divides(Value excess, const Component (&c)[kCount], Masks asked) {
    const Reals reciprocal = 1.0 / excess;
    for (const Component& component : c) {
      // Where it divides, the quotient, at most 2^33, is an integer and its error below 1/2, so that
      // rounding finds it. Where it does not, no integer passes. The product is at most |c| + |excess|.
      const Reals quotient = Round<0>(component * reciprocal);
      asked &= quotient * excess == component;
    }
    return asked;
  }
};

}  // namespace triaxis::bulk

#endif  // TRIAXIS_GOLDEN_BULK_NARROW_H_
