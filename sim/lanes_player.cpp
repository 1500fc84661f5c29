// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Many cores in lockstep behind one C function: pairs at full speed from reset, their result words. Lane l gets
// the l-th part of the pairs, in order. All lanes take their pairs, and give their results, in the same clock:
// where one of them does not, or gives another tag, the core breaks its interface. See lanes.py.

#include <algorithm>
#include <cstring>
#include <memory>

#include "Vtop_lanes.h"
#include "player.h"

namespace {

constexpr int kCoordinates = 18;
constexpr int kDataWords = (kCoordinates * WIDTH + 31) / 32;
constexpr uint32_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
static_assert(TAG_BITS < 64 && TAG_BITS + MARGIN_BITS <= 64, "TUSER travels in 64 bits");
constexpr uint64_t kTagMask = (uint64_t{1} << TAG_BITS) - 1;
constexpr int kClocksInReset = 4;
// Clocks without a result after which a core hangs: far above any latency.
constexpr int kPatience = 1000;

// Copies what a model is after reset into all lanes.
void Reset(Lanes& lanes) {
  triaxis::Bench bench;
  Vtop& core = bench.model();
  core.rst_ni = 0;
  core.s_axis_tvalid_i = 0;
  core.m_axis_tready_i = 1;
  for (int clock = 0; clock < kClocksInReset; ++clock) bench.Clock();
  core.rst_ni = 1;
  bench.Clock();
  Copy(lanes, *core.rootp);
}

void Offer(Lanes& s, const int32_t* pairs, const uint32_t* margins, int64_t part, int64_t last, int64_t number) {
  uint32_t data[kDataWords][kLanes] = {};
  for (int l = 0; l < kLanes; ++l) {
    const int64_t at = std::min(l * part + number, last);
    const int32_t* pair = pairs + kCoordinates * at;
#pragma GCC unroll 18
    for (int i = 0; i < kCoordinates; ++i) {
      const uint32_t bits = static_cast<uint32_t>(pair[i]) & kCoordinateMask;
      const int word = i * WIDTH / 32;
      const int shift = i * WIDTH % 32;
      data[word][l] |= bits << shift;
      if (shift + WIDTH > 32) data[word + 1][l] |= bits >> (32 - shift);
    }
    s.s_axis_tuser_i[l] =
        (static_cast<uint64_t>(number) & kTagMask) << MARGIN_BITS | (MARGIN_BITS ? margins[at] : 0u);
  }
  std::memcpy(s.s_axis_tdata_i, data, sizeof data);
}

}  // namespace

// Returns the clocks, or -1 where a core hangs, is not in step, or gives a tag that is not that of the pair.
extern "C" int64_t triaxis_lockstep(const int32_t* pairs, const uint32_t* margins, int64_t count, uint16_t* words) {
  const auto lanes = std::make_unique<Lanes>();
  Lanes& s = *lanes;
  Reset(s);
  const int64_t part = (count + kLanes - 1) / kLanes;
  int64_t sent = 0;
  int64_t received = 0;
  int64_t clocks = 0;
  for (int idle = 0; received < part; ++idle) {
    if (idle > kPatience) return -1;
    const bool offered = sent < part;
    for (int l = 0; l < kLanes; ++l) s.s_axis_tvalid_i[l] = offered;
    if (offered) Offer(s, pairs, margins, part, count - 1, sent);
    Inputs(s);
    for (int l = 1; l < kLanes; ++l) {
      if (s.s_axis_tready_o[l] != s.s_axis_tready_o[0] || s.m_axis_tvalid_o[l] != s.m_axis_tvalid_o[0]) return -1;
    }
    if (s.m_axis_tvalid_o[0]) {
      for (int l = 0; l < kLanes; ++l) {
        if (s.m_axis_tuser_o[l] != (static_cast<uint64_t>(received) & kTagMask)) return -1;
        const int64_t at = l * part + received;
        if (at < count) words[at] = static_cast<uint16_t>(s.m_axis_tdata_o[l]);
      }
      ++received;
      idle = 0;
    }
    sent += offered && s.s_axis_tready_o[0];
    Clock(s);
    ++clocks;
  }
  return clocks;
}
