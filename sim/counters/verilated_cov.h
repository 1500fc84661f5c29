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

template <typename Word>
void CountWord(uint32_t* counts, Word now, Word before) {
  for (Word changed = now ^ before; changed != 0; changed &= changed - 1) {
    const int bit = std::countr_zero(changed);
    ++counts[2 * bit + ((now >> bit) & 1)];
  }
}

// Not inlined: there are thousands of calls, and compiling them costs more than they do.
[[gnu::noinline]] inline void CountNarrow(int, uint32_t* counts, uint64_t now, uint64_t before) {
  CountWord(counts, now, before);
}

// Verilator keeps the unused bits of the highest word at zero, so they never change.
[[gnu::noinline]] inline void CountWide(int width, uint32_t* counts, WDataInP now, WDataInP before) {
  for (int word = 0; word < VL_WORDS_I(width); ++word) {
    CountWord<uint32_t>(counts + 2 * VL_EDATASIZE * word, now[word], before[word]);
  }
}

}  // namespace triaxis

#define VL_COV_TOGGLE_CHG_ST_I triaxis::CountNarrow
#define VL_COV_TOGGLE_CHG_ST_Q triaxis::CountNarrow
#define VL_COV_TOGGLE_CHG_ST_W triaxis::CountWide

#endif  // TRIAXIS_INSTRUMENTED_VERILATED_COV_H_
