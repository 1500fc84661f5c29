// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// CGAL's exact predicates on arrays of pairs, without Python in between; see native.py.

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Triangle_3.h>
#include <CGAL/intersections.h>
#include <CGAL/version.h>

#include <cstdint>
#include <vector>

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Triangles = std::vector<Kernel::Triangle_3>;

extern "C" {

// CGAL's version, as its headers number it.
int64_t triaxis_version() { return CGAL_VERSION_NR; }

void* triaxis_load(int, const double* x, int64_t n) {
  auto* made = new Triangles;
  made->reserve(n);
  for (const double* end = x + 9 * n; x != end; x += 9) {
    made->emplace_back(Kernel::Point_3(x[0], x[1], x[2]), Kernel::Point_3(x[3], x[4], x[5]),
                       Kernel::Point_3(x[6], x[7], x[8]));
  }
  return made;
}

void triaxis_free(int, void* triangles) { delete static_cast<Triangles*>(triangles); }

// Writes whether the triangles of each pair intersect.
int64_t triaxis_ask(int, const void* a, const void* b, int32_t* intersect, int64_t n, int64_t*) {
  const auto& first = *static_cast<const Triangles*>(a);
  const auto& second = *static_cast<const Triangles*>(b);
  for (int64_t i = 0; i < n; ++i) intersect[i] = CGAL::do_intersect(first[i], second[i]);
  return n;
}

}  // extern "C"
