// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Counts the bins of a cover item: how often each combination of codes comes up, and each bit of masks with it;
// see cover_model.py. A combination's place in the table: the last point's code varies fastest.

#include <algorithm>
#include <cstdint>
#include <vector>

namespace triaxis::coverage {
namespace {

// What is worked on at a time, in the fastest cache.
constexpr int64_t kBlock = 1024;
// Tables that are counted in at a time.
constexpr int64_t kWays = 4;

// Codes of n samples, an array for each point, each code below the point's radix.
struct Points {
  const uint8_t* const* codes;
  const int64_t* radices;
  int64_t count;

  // Puts together the codes of up to kBlock samples.
  void Join(int64_t start, int64_t size, uint32_t* joint) const {
    std::fill(joint, joint + size, 0);
    for (int64_t point = 0; point < count; ++point) {
      const uint8_t* own = codes[point] + start;
      const uint32_t radix = static_cast<uint32_t>(radices[point]);
      for (int64_t i = 0; i < size; ++i) joint[i] = joint[i] * radix + own[i];
    }
  }
};

// Calls count(first sample of a block, samples in it, their joint codes).
template <class Count>
void ForBlocks(const Points& points, int64_t n, Count count) {
  uint32_t joint[kBlock];
  for (int64_t start = 0; start < n; start += kBlock) {
    const int64_t size = std::min(kBlock, n - start);
    points.Join(start, size, joint);
    count(start, size, joint);
  }
}

}  // namespace
}  // namespace triaxis::coverage

using triaxis::coverage::kBlock, triaxis::coverage::kWays;

// Adds to a table with a place for each of `places` combinations of codes.
extern "C" void triaxis_count(const uint8_t* const* codes, const int64_t* radices, int64_t points, int64_t n,
                              int64_t places, int64_t* table) {
  // Many samples fall into the same place: each addition would wait for the one before.
  std::vector<int64_t> ways(kWays * places);
  triaxis::coverage::ForBlocks(
      {codes, radices, points}, n, [&ways](int64_t, int64_t size, const uint32_t* joint) {
        for (int64_t i = 0; i < size; ++i) ++ways[kWays * joint[i] + i % kWays];
      });
  for (size_t i = 0; i < ways.size(); ++i) table[i / kWays] += ways[i];
}

// Adds to a table with 32 places for each combination: one for each bit of a mask.
extern "C" void triaxis_count_masks(const uint32_t* masks, const uint8_t* const* codes, const int64_t* radices,
                                    int64_t points, int64_t n, int64_t* table) {
  triaxis::coverage::ForBlocks(
      {codes, radices, points}, n, [=](int64_t start, int64_t size, const uint32_t* joint) {
        // Most masks are 0: those that are not first, without a branch.
        int64_t chosen[kBlock], count = 0;
        for (int64_t i = 0; i < size; ++i) {
          chosen[count] = i;
          count += masks[start + i] != 0;
        }
        for (int64_t k = 0; k < count; ++k) {
          int64_t* place = table + 32 * int64_t{joint[chosen[k]]};
          for (uint32_t mask = masks[start + chosen[k]]; mask; mask &= mask - 1) ++place[__builtin_ctz(mask)];
        }
      });
}
