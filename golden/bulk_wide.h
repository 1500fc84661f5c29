// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Exact arithmetic for all 32-bit coordinates: each number is the sum of two doubles.
//
// All values are integers. Let L < 2^32 bound the differences of coordinates, and let the margin be at
// most L + 2. A double holds k u exactly for integers |k| <= 2^53 and u a power of two, its unit. So a
// sum or product of doubles is exact, fused or not, where the result is at most 2^53 times its unit; the
// comments give "size / unit". Only `Carry` and `Sign` round.

#ifndef TRIAXIS_GOLDEN_BULK_WIDE_H_
#define TRIAXIS_GOLDEN_BULK_WIDE_H_

#include "bulk_lanes.h"

namespace triaxis::bulk {

// high + low, where high is a multiple of 2^kBits and low an integer.
template <int kBits>
struct Split {
  Reals high;
  Reals low;
};

template <int kBits>
inline Split<kBits> operator-(Split<kBits> x, Split<kBits> y) {
  return {x.high - y.high, x.low - y.low};
}

// A number with the sign of x: a rounded sum has the sign of the exact one, and is 0 only where it is.
template <int kBits>
inline Reals Sign(Split<kBits> x) {
  return x.high + x.low;
}

template <int kBits>
inline Split<kBits> Select(Masks mask, Split<kBits> x, Split<kBits> y) {
  return {mask ? x.high : y.high, mask ? x.low : y.low};
}

template <int kBits>
inline Split<kBits> Min(Split<kBits> x, Split<kBits> y) {
  return Select(Sign(x - y) < 0, x, y);
}

template <int kBits>
inline Split<kBits> Max(Split<kBits> x, Split<kBits> y) {
  return Select(Sign(x - y) > 0, x, y);
}

template <int kBits>
inline Split<kBits> Abs(Split<kBits> x) {
  const Masks sign = Sign(x) < 0;
  const Masks flip = sign & INT64_MIN;
  return {(Reals)((Masks)x.high ^ flip), (Reals)((Masks)x.low ^ flip)};
}

// coarse + fine with a multiple of 2^kBits in front. Whatever the multiple, the difference is added
// back: all that matters is that both steps of that are exact, which the caller shows. The low part is at
// most 2^(kBits - 1), for `Round`, and half a unit in the last place of the sum.
template <int kBits>
inline Split<kBits> Carry(Reals coarse, Reals fine) {
  const Reals high = Round<kBits>(coarse + fine);
  return {high, (coarse - high) + fine};
}

struct Wide {
  // A coordinate, an edge or a margin: |high| <= 2^32 / 2^16, |low| <= 2^15.
  struct Factor {
    Reals whole;
    Reals high;
    Reals low;
  };
  // A component or a norm of an axis: |high| <= 3 (2^65 + 2^33) / 2^33, |low| <= 3 * 2^33.
  using Component = Split<33>;
  // A projection relative to A1, or margin * norm: |high| <= 4 * 2^97 / 2^48, |low| <= 2^50. Sums of four
  // are exact.
  using Value = Split<48>;

  static Factor ToFactor(Reals x) {
    const Reals high = Round<16>(x);
    return {x, high, x - high};
  }
  static Reals ToReals(Factor x) { return x.whole; }
  static Value ToValue(Factor x) { return {Reals{}, x.whole}; }
  static Component ToComponent(Reals x) { return {Reals{}, x}; }

  // p q - r s. coarse: 2 * 2^32 * 2^32 / 2^16. fine: 2 * 2^15 * 2^32. In `Carry` the difference is at
  // most 2^48 + 2^32 + 2^12, its unit 2^16; then low is at most 2^32 + 2^12.
  static Component Minor(Factor p, Factor q, Factor r, Factor s) {
    return Carry<33>(p.high * q.whole - r.high * s.whole, p.low * q.whole - r.low * s.whole);
  }

  static Component Norm(const Component (&c)[3]) {
    const Component x = Abs(c[0]), y = Abs(c[1]), z = Abs(c[2]);
    return {x.high + y.high + z.high, x.low + y.low + z.low};
  }

  // Sums of up to three products, by unit: 2^49, 2^33, 2^16 and 1.
  struct Partial {
    Reals high_high;  // 3 (2^65 + 2^33) 2^32 / 2^49
    Reals high_low;   // 3 (2^65 + 2^33) 2^15 / 2^33
    Reals low_high;   // 3 * 2^33 * 2^32 / 2^16
    Reals low_low;    // 3 * 2^33 * 2^15

    // In `Carry` the difference is at most 2^67 + 2^47 + 2^30, its unit 2^33; then low is at most
    // 2^47 + 2^30, its unit 2^16.
    Value Total() const {
      const Value middle = Carry<48>(high_low, low_high);
      return {high_high + middle.high, middle.low + low_low};
    }
  };

  static Value Dot(const Component (&c)[3], const Factor (&x)[3]) {
    return Partial{c[0].high * x[0].high + c[1].high * x[1].high + c[2].high * x[2].high,
                   c[0].high * x[0].low + c[1].high * x[1].low + c[2].high * x[2].low,
                   c[0].low * x[0].high + c[1].low * x[1].high + c[2].low * x[2].high,
                   c[0].low * x[0].low + c[1].low * x[1].low + c[2].low * x[2].low}
        .Total();
  }

  // A norm has the bounds of three components, a margin those of a coordinate: as in `Dot`.
  static Value Times(Component norm, Factor margin) {
    return Partial{norm.high * margin.high, norm.high * margin.low, norm.low * margin.high,
                   norm.low * margin.low}
        .Total();
  }

  // c x + d y. coarse: 2 * 2^32 * 2^32 / 2^16. fine: 2 * 2^32 * 2^15. In `Carry` the difference is at
  // most 2^48 + 2^47 + 2^12, its unit 2^16; then low is at most 2^47 + 2^12.
  static Value EdgeDot(Reals c, Factor x, Reals d, Factor y) {
    return Carry<48>(c * x.high + d * y.high, c * x.low + d * y.low);
  }

  // norm <= 2^33: as in `EdgeDot`.
  static Value EdgeTimes(Reals norm, Factor margin) {
    return Carry<48>(norm * margin.high, norm * margin.low);
  }

  // Which of the lanes asked for have an excess, not 0, that divides these components; and whether that is
  // quicker than to look whether a lane asks.
  static constexpr bool kDividesFast = false;
  template <int kCount>
  static Masks Divides(Value excess, const Component (&c)[kCount], Masks asked) {
    for (int lane = 0; lane < kLanes; ++lane) {
      if (!asked[lane]) continue;
      const __int128 divisor = Lane(excess, lane);
      for (const Component& component : c) {
        if (Lane(component, lane) % divisor != 0) asked[lane] = 0;
      }
    }
    return asked;
  }

 private:
  template <int kBits>
  static __int128 Lane(Split<kBits> x, int lane) {
    return static_cast<__int128>(x.high[lane]) + static_cast<__int128>(x.low[lane]);
  }
};

}  // namespace triaxis::bulk

#endif  // TRIAXIS_GOLDEN_BULK_WIDE_H_
