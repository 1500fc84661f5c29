// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What each of the 32 axes says of a pair, by definition: the axis is made of the edges, all six vertices
// are projected on it, and their intervals compared. The numbers are those of axes.py, the facts those of
// facts.py; Number is the arithmetic, Narrow or Wide.

#ifndef TRIAXIS_GOLDEN_BULK_AXES_H_
#define TRIAXIS_GOLDEN_BULK_AXES_H_

#include "bulk_lanes.h"

namespace triaxis::bulk {

// What the axes say; bit n of a mask over the axes is axis n.
struct AxisFacts {
  Masks above{}, below{}, upper{}, lower{}, level{}, clear_step{}, near_step{}, flat{}, not_zero{};
  Masks support_a = Masks{} + 7, support_b = Masks{} + 7;
  Masks a_in_b = ~Masks{}, b_in_a = ~Masks{};
};

template <class Number>
using Point = typename Number::Factor[3];

template <class Number>
struct Pair {
  // Relative to A1.
  Point<Number> a[3], b[3];
  // Edge i runs from vertex i to the next.
  Point<Number> edges_a[3], edges_b[3];
  typename Number::Factor margin;
};

// Coordinate k.
template <class Number>
struct BoxAxis {
  using Value = typename Number::Value;
  using Component = typename Number::Component;

  int k;

  Value Project(const Point<Number>& x) const { return Number::ToValue(x[k]); }
  Reals Norm() const { return AllLanes(1); }
  Value Reach(typename Number::Factor margin) const { return Number::ToValue(margin); }
  Masks Divisible(Value excess, Masks asked) const {
    const Component one[1] = {Number::ToComponent(AllLanes(1))};
    return Number::Divides(excess, one, asked);
  }
};

// The cross product of an edge with a coordinate, of which one component is 0.
template <class Number>
struct EdgeAxis {
  using Value = typename Number::Value;
  using Component = typename Number::Component;

  // The other two coordinates, cyclically, and the components along them.
  int next, last;
  Reals c, d;

  EdgeAxis(const Point<Number>& edge, int k)
      : next((k + 1) % 3),
        last((k + 2) % 3),
        c(Number::ToReals(edge[last])),
        d(-Number::ToReals(edge[next])) {}

  Value Project(const Point<Number>& x) const { return Number::EdgeDot(c, x[next], d, x[last]); }
  Reals Norm() const { return Abs(c) + Abs(d); }
  Value Reach(typename Number::Factor margin) const { return Number::EdgeTimes(Norm(), margin); }
  Masks Divisible(Value excess, Masks asked) const {
    const Component components[2] = {Number::ToComponent(c), Number::ToComponent(d)};
    return Number::Divides(excess, components, asked);
  }
};

// The cross product of two edges.
template <class Number>
struct CrossAxis {
  using Value = typename Number::Value;
  using Component = typename Number::Component;

  Component c[3];
  Component norm;

  CrossAxis(const Point<Number>& x, const Point<Number>& y)
      : c{Number::Minor(x[1], y[2], x[2], y[1]), Number::Minor(x[2], y[0], x[0], y[2]),
          Number::Minor(x[0], y[1], x[1], y[0])},
        norm(Number::Norm(c)) {}

  Value Project(const Point<Number>& x) const { return Number::Dot(c, x); }
  Reals Norm() const { return Sign(norm); }
  Value Reach(typename Number::Factor margin) const { return Number::Times(norm, margin); }
  Masks Divisible(Value excess, Masks asked) const { return Number::Divides(excess, c, asked); }
};

// The vertices, as bits, whose projections are equal to the extreme.
template <class Value>
inline Masks Attaining(const Value (&on)[3], Value extreme) {
  return ((Sign(on[0] - extreme) == 0) & 1) | ((Sign(on[1] - extreme) == 0) & 2) |
         ((Sign(on[2] - extreme) == 0) & 4);
}

template <class Number, class Axis>
[[gnu::always_inline]] inline void Examine(const Pair<Number>& pair, const Axis& axis, int number,
                               AxisFacts& facts) {
  using Value = typename Number::Value;
  const int64_t bit = int64_t{1} << number;
  const Value on_a[3] = {axis.Project(pair.a[0]), axis.Project(pair.a[1]), axis.Project(pair.a[2])};
  const Value on_b[3] = {axis.Project(pair.b[0]), axis.Project(pair.b[1]), axis.Project(pair.b[2])};
  const Value low_a = Min(Min(on_a[0], on_a[1]), on_a[2]);
  const Value high_a = Max(Max(on_a[0], on_a[1]), on_a[2]);
  const Value low_b = Min(Min(on_b[0], on_b[1]), on_b[2]);
  const Value high_b = Max(Max(on_b[0], on_b[1]), on_b[2]);

  // A's interval is in B's on all 32 axes exactly when A is a part of B. If B is a triangle, its normal
  // puts A in its plane, and of the axes (edge) x (coordinate), which span the plane perpendicular to the
  // edge, one is not parallel to the normal: within B's plane, it is perpendicular to the edge, and puts A
  // on B's side of it. If B is a segment, these axes put A on its line, and a box axis that is not
  // perpendicular to the line puts A between the ends. If B is a point, the box axes put A there.
  const Reals lows = Sign(low_a - low_b);
  const Reals highs = Sign(high_a - high_b);
  facts.a_in_b &= (lows >= 0) & (highs <= 0);
  facts.b_in_a &= (lows <= 0) & (highs >= 0);

  const Value up = low_b - high_a;
  const Value down = low_a - high_b;
  const Value reach = axis.Reach(pair.margin);
  const Reals beyond_up = Sign(up - reach);
  const Reals beyond_down = Sign(down - reach);
  facts.above |= (beyond_up > 0) & bit;
  facts.below |= (beyond_down > 0) & bit;
  const Reals side = Sign(up - down);
  facts.upper |= (side >= 0) & bit;
  facts.lower |= (side <= 0) & bit;

  // up + down is less than 0 by the lengths of the two intervals, so both are 0 exactly where all six
  // vertices fall together: on a zero axis and on a flat one.
  const Masks together = (Sign(up) == 0) & (Sign(down) == 0);
  const Masks not_zero = axis.Norm() > 0;
  facts.not_zero |= not_zero & bit;
  facts.flat |= together & not_zero & bit;

  // Rounding keeps the order of numbers, so this is the excess, rounded, and 0 only where the excess is.
  const Reals excess = Max(beyond_up, beyond_down);
  const Masks level = (excess == 0) & ~together;
  facts.level |= level & bit;
  // Not together, so only one of the two is level: their sum is less than 0, and reach is not.
  const Masks upward = beyond_up == 0;
  facts.support_a &= Attaining(on_a, Select(upward, high_a, low_a)) | ~level;
  facts.support_b &= Attaining(on_b, Select(upward, low_b, high_b)) | ~level;

  // The excess is a multiple of g, so it is g or -g exactly where it divides all components; then it is at
  // most the norm, also when both are rounded.
  const Masks small = (Abs(excess) <= axis.Norm()) & (excess != 0) & ~together;
  if (Number::kDividesFast || Any(small)) {
    const Masks step = axis.Divisible(Max(up, down) - reach, small) & bit;
    facts.clear_step |= step & (excess > 0);
    facts.near_step |= step & (excess < 0);
  }
}

template <class Number>
AxisFacts ExamineAll(const Pair<Number>& pair) {
  AxisFacts facts;
  for (int k = 0; k < 3; ++k) Examine(pair, BoxAxis<Number>{k}, k, facts);
  using Cross = CrossAxis<Number>;
  Examine(pair, Cross(pair.edges_a[0], pair.edges_a[1]), 3, facts);
  Examine(pair, Cross(pair.edges_b[0], pair.edges_b[1]), 4, facts);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      Examine(pair, Cross(pair.edges_a[i], pair.edges_b[j]), 5 + 3 * i + j, facts);
      Examine(pair, EdgeAxis<Number>(pair.edges_a[i], j), 14 + 3 * i + j, facts);
      Examine(pair, EdgeAxis<Number>(pair.edges_b[i], j), 23 + 3 * i + j, facts);
    }
  }
  return facts;
}

}  // namespace triaxis::bulk

#endif  // TRIAXIS_GOLDEN_BULK_AXES_H_
