// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stands in front of Verilator's header of the same name and counts toggles in its place. Verilator
// 5.048 walks the words of a signal wider than 64 bits with a bit index that runs past 31: a change of
// bit b is counted at b + 32, b + 64, .. as well, so bits that never moved look covered. Here only the
// bits that changed are visited, which is faster too.
//
// The layout is Verilator's: two counters a bit, falling then rising.

#include_next "verilated_cov.h"

#ifndef TRIAXIS_INSTRUMENTED_VERILATED_COV_H_
#define TRIAXIS_INSTRUMENTED_VERILATED_COV_H_

#include <bit>
#include <cstdint>

namespace triaxis {

// Not inlined: there are thousands of calls, and compiling them costs more than they do. Bits above the width
// may hold anything: they are no bits of the signal, and their counters would be those of the next one.
[[gnu::noinline]] inline void CountNarrow(int width, uint32_t* counts, uint64_t now, uint64_t before) {
  const uint64_t mask = ~uint64_t{0} >> (64 - width);
  for (uint64_t changed = (now ^ before) & mask; changed != 0; changed &= changed - 1) {
    const int bit = std::countr_zero(changed);
    ++counts[2 * bit + ((now >> bit) & 1)];
  }
}

[[gnu::noinline]] inline void CountWide(int width, uint32_t* counts, WDataInP now, WDataInP before) {
  for (int word = 0; width > 0; ++word, width -= VL_EDATASIZE) {
    CountNarrow(width < VL_EDATASIZE ? width : VL_EDATASIZE, counts + 2 * VL_EDATASIZE * word, now[word],
                before[word]);
  }
}

}  // namespace triaxis

#define VL_COV_TOGGLE_CHG_ST_I triaxis::CountNarrow
#define VL_COV_TOGGLE_CHG_ST_Q triaxis::CountNarrow
#define VL_COV_TOGGLE_CHG_ST_W triaxis::CountWide

#endif  // TRIAXIS_INSTRUMENTED_VERILATED_COV_H_
