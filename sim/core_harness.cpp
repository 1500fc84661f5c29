// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The bare Verilated core behind a C function: feeds pairs through the AXI4-Stream ports with no
// gaps and takes results as they come. Built as a shared library; see core_engine.py.

#include <cstdint>
#include <cstring>

#include "Vcore.h"

namespace {

constexpr int kCoordinates = 18;
constexpr int kWords = (kCoordinates * WIDTH + 31) / 32;
constexpr uint64_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
constexpr uint64_t kTagMask = TAG_BITS >= 64 ? ~uint64_t{0} : (uint64_t{1} << TAG_BITS) - 1;
static_assert(TAG_BITS + MARGIN_BITS <= 64, "the harness keeps TUSER in 64 bits");

// Cycles without a result after which the core is taken to hang: far above any latency.
constexpr uint64_t kPatience = 1000;

void Pack(const int32_t* pair, uint32_t* words) {
    std::memset(words, 0, 4 * kWords);
    for (int i = 0; i < kCoordinates; ++i) {
        const uint64_t bits = static_cast<uint64_t>(int64_t{pair[i]}) & kCoordinateMask;
        const int word = i * WIDTH / 32;
        const int shift = i * WIDTH % 32;
        words[word] |= static_cast<uint32_t>(bits << shift);
        if (shift + WIDTH > 32) words[word + 1] |= static_cast<uint32_t>(bits >> (32 - shift));
    }
}

// Inputs that were changed since the last call settle before the edge, in the same evaluation.
void Clock(Vcore& core) {
    core.clk_i = 1;
    core.eval();
    core.clk_i = 0;
    core.eval();
}

}  // namespace

// Runs n pairs (18 coordinates each) with their margins. results receives TDATA. Returns the number
// of clock cycles, or a negative number: -1 the core hangs, -2 a tag comes back wrong.
extern "C" int64_t triaxis_run(const int32_t* pairs, const uint32_t* margins, int64_t n,
                               uint16_t* results) {
    VerilatedContext context;
    Vcore core{&context};
    core.rst_ni = 0;
    core.clk_i = 0;
    core.s_axis_tvalid_i = 0;
    core.m_axis_tready_i = 1;
    core.eval();
    Clock(core);
    core.rst_ni = 1;
    core.eval();
    Clock(core);

    int64_t sent = 0;
    int64_t received = 0;
    int64_t cycles = 0;
    uint64_t idle = 0;
    int64_t loaded = -1;
    while (received < n) {
        core.s_axis_tvalid_i = sent < n;
        if (sent < n && loaded != sent) {
            uint32_t words[kWords];
            Pack(pairs + kCoordinates * sent, words);
            std::memcpy(&core.s_axis_tdata_i, words, sizeof words);
            const uint64_t tag = static_cast<uint64_t>(sent) & kTagMask;
            const uint64_t user = (tag << MARGIN_BITS) | (MARGIN_BITS ? margins[sent] : 0u);
            std::memcpy(&core.s_axis_tuser_i, &user, sizeof core.s_axis_tuser_i);
            loaded = sent;
        }
        // Both handshake outputs come from registers: they do not wait for the inputs to settle.
        const bool accepted = core.s_axis_tvalid_i && core.s_axis_tready_o;
        const bool delivered = core.m_axis_tvalid_o;
        if (delivered) {
            if (core.m_axis_tuser_o != (static_cast<uint64_t>(received) & kTagMask)) return -2;
            results[received++] = core.m_axis_tdata_o;
            idle = 0;
        } else if (++idle > kPatience) {
            return -1;
        }
        sent += accepted;
        ++cycles;
        Clock(core);
    }
    return cycles;
}
