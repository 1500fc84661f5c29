// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The transaction side of the bus-functional model: holds the burst that the driver offers, the paces,
// and the buffers of both monitors. Python reaches the extern "C" functions through the simulator
// executable itself; see verif/core/burst_agents.py. The driver packs coordinates into TDATA and the
// monitor unpacks them, each by code of its own, so that a fault in one shows against the other.

#include "burst_bfm.h"

#include <cstdint>
#include <cstring>
#include <vector>

#include "svdpi.h"

namespace {

constexpr int kCoordinates = 18;
constexpr int kDataWords = (8 * ((kCoordinates * WIDTH + 7) / 8) + 31) / 32;
constexpr uint64_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
static_assert(TAG_BITS + MARGIN_BITS <= 64, "TUSER travels in 64 bits");

// Beats in a monitor's buffer at which Python is asked to fetch them.
constexpr size_t kWakeBeats = size_t{1} << 16;

bool wake_request = false;

// Alternating numbers of clocks on and off, used over and over. Empty: always on.
class Pattern {
   public:
    void Set(const uint16_t* runs, int64_t count) {
        runs_.assign(runs, runs + count);
        next_ = 0;
        left_ = runs_.empty() ? 0 : runs_[0];
        on_ = true;
    }
    // Whether the clock to come is on; an off clock is used up by asking, an on clock by Use().
    bool On() {
        if (runs_.empty()) return true;
        Settle();
        if (!on_) --left_;
        return on_;
    }
    void Use() {
        if (!runs_.empty()) --left_;
    }

   private:
    // Ends: Python gives no pattern without a clock on.
    void Settle() {
        while (left_ == 0) {
            next_ = (next_ + 1) % runs_.size();
            left_ = runs_[next_];
            on_ = !on_;
        }
    }
    std::vector<uint16_t> runs_;
    size_t next_ = 0;
    int left_ = 0;
    bool on_ = true;
};

struct Source {
    const int32_t* pairs = nullptr;
    const uint32_t* margins = nullptr;
    const uint32_t* tags = nullptr;
    int64_t count = 0;
    int64_t offered = 0;
    int64_t accepted = 0;
    int64_t cycles = 0;
    int64_t budget = 0;
    bool hung = false;
    Pattern pattern;

    bool active() const { return accepted < count && !hung; }
};

Source source;
Pattern sink_pattern;

// What a monitor saw: the beats that moved, and before which of them a reset began.
struct Monitor {
    std::vector<uint32_t> tags;
    std::vector<uint16_t> waits;
    std::vector<size_t> resets;
    size_t fetched = 0;
    size_t resets_fetched = 0;
    uint16_t wait = 0;

    void Reset() {
        resets.push_back(tags.size());
        wait = 0;
    }
    // Returns whether the beat moves.
    bool Clock(uint32_t tag, bool ready) {
        if (!ready) {
            if (wait != UINT16_MAX) ++wait;
            return false;
        }
        tags.push_back(tag);
        waits.push_back(wait);
        wait = 0;
        if (tags.size() == kWakeBeats) wake_request = true;
        return true;
    }
    // Beats before the next reset, or before the end.
    size_t Available() const {
        const size_t end =
            resets_fetched < resets.size() ? resets[resets_fetched] : tags.size();
        return end - fetched;
    }
    // True where a reset comes next; it is then fetched.
    bool TakeReset() {
        if (resets_fetched == resets.size() || resets[resets_fetched] != fetched) return false;
        ++resets_fetched;
        return true;
    }
    // True where everything was fetched and the buffers are empty again.
    bool Recycle() {
        if (fetched != tags.size() || resets_fetched != resets.size()) return false;
        tags.clear();
        waits.clear();
        resets.clear();
        fetched = resets_fetched = 0;
        return true;
    }
};

struct InputMonitor : Monitor {
    std::vector<int32_t> coordinates;
    std::vector<uint32_t> margins;
};

struct OutputMonitor : Monitor {
    std::vector<uint16_t> words;
};

InputMonitor input;
OutputMonitor output;

void Pack(const int32_t* pair, svBitVecVal* data) {
    std::memset(data, 0, sizeof(svBitVecVal) * kDataWords);
    for (int i = 0; i < kCoordinates; ++i) {
        const uint64_t bits = static_cast<uint64_t>(int64_t{pair[i]}) & kCoordinateMask;
        const int word = i * WIDTH / 32;
        const int shift = i * WIDTH % 32;
        data[word] |= static_cast<uint32_t>(bits << shift);
        if (shift + WIDTH > 32) data[word + 1] |= static_cast<uint32_t>(bits >> (32 - shift));
    }
}

// Takes coordinates off the low end of a window of bits that is filled word by word.
void Unpack(const svBitVecVal* data, int32_t* coordinates) {
    uint64_t window = 0;
    int filled = 0;
    int next = 0;
    for (int i = 0; i < kCoordinates; ++i) {
        if (filled < WIDTH) {
            window |= static_cast<uint64_t>(data[next++]) << filled;
            filled += 32;
        }
        const uint32_t raw = static_cast<uint32_t>(window) << (32 - WIDTH);
        coordinates[i] = static_cast<int32_t>(raw) >> (32 - WIDTH);
        window >>= WIDTH;
        filled -= WIDTH;
    }
}

}  // namespace

namespace triaxis {

bool BurstActive() { return source.active(); }

void CountCycle() {
    if (!source.active()) return;
    if (++source.cycles > source.budget) {
        source.hung = true;
        wake_request = true;
    }
}

bool WakeRequested() { return wake_request; }

bool TakeWakeRequest() {
    const bool request = wake_request;
    wake_request = false;
    return request;
}

}  // namespace triaxis

extern "C" {

// --- Called by SystemVerilog ----------------------------------------------------------------------

svBit triaxis_source_next(svBitVecVal* data, svBitVecVal* user) {
    if (source.offered == source.count || source.hung || !source.pattern.On()) {
        std::memset(data, 0, sizeof(svBitVecVal) * kDataWords);
        user[0] = user[1] = 0;
        return 0;
    }
    source.pattern.Use();
    Pack(source.pairs + kCoordinates * source.offered, data);
    const uint64_t tag = source.tags[source.offered];
    const uint64_t margin = MARGIN_BITS ? source.margins[source.offered] : 0u;
    const uint64_t both = (tag << MARGIN_BITS) | margin;
    user[0] = static_cast<uint32_t>(both);
    user[1] = static_cast<uint32_t>(both >> 32);
    ++source.offered;
    return 1;
}

void triaxis_source_accepted() {
    if (++source.accepted == source.count) wake_request = true;
}

svBit triaxis_sink_ready() {
    const bool ready = sink_pattern.On();
    if (ready) sink_pattern.Use();
    return ready;
}

void triaxis_input_beat(const svBitVecVal* data, const svBitVecVal* user, svBit ready) {
    const uint64_t both = user[0] | (static_cast<uint64_t>(user[1]) << 32);
    if (!input.Clock(static_cast<uint32_t>(both >> MARGIN_BITS), ready)) return;
    input.margins.push_back(static_cast<uint32_t>(both & ((uint64_t{1} << MARGIN_BITS) - 1)));
    const size_t at = input.coordinates.size();
    input.coordinates.resize(at + kCoordinates);
    Unpack(data, input.coordinates.data() + at);
}

void triaxis_output_beat(const svBitVecVal* data, const svBitVecVal* user, svBit ready) {
    if (output.Clock(user[0], ready)) output.words.push_back(static_cast<uint16_t>(data[0]));
}

void triaxis_input_reset() { input.Reset(); }

void triaxis_output_reset() { output.Reset(); }

// --- Called by Python -----------------------------------------------------------------------------

// Starts a burst. The arrays must live until it is over. runs: clocks on and off, alternating.
void triaxis_burst_start(const int32_t* pairs, const uint32_t* margins, const uint32_t* tags,
                         int64_t count, const uint16_t* runs, int64_t run_count,
                         int64_t budget) {
    source.pairs = pairs;
    source.margins = margins;
    source.tags = tags;
    source.count = count;
    source.offered = source.accepted = source.cycles = 0;
    source.budget = budget;
    source.hung = false;
    source.pattern.Set(runs, run_count);
}

int triaxis_burst_active() { return source.active(); }

int64_t triaxis_burst_accepted() { return source.accepted; }

void triaxis_sink_pace(const uint16_t* runs, int64_t run_count) { sink_pattern.Set(runs, run_count); }

// Beats that the next fetch gives at most: those before the next reset.
int64_t triaxis_input_available() { return static_cast<int64_t>(input.Available()); }

int64_t triaxis_output_available() { return static_cast<int64_t>(output.Available()); }

// Copies exactly count beats; returns 1 where a reset follows them at once.
int triaxis_input_fetch(int64_t count, int32_t* pairs, uint32_t* margins, uint32_t* tags,
                        uint16_t* waits) {
    const size_t at = input.fetched;
    std::memcpy(pairs, input.coordinates.data() + kCoordinates * at,
                sizeof(int32_t) * kCoordinates * count);
    std::memcpy(margins, input.margins.data() + at, sizeof(uint32_t) * count);
    std::memcpy(tags, input.tags.data() + at, sizeof(uint32_t) * count);
    std::memcpy(waits, input.waits.data() + at, sizeof(uint16_t) * count);
    input.fetched += count;
    const bool reset = input.TakeReset();
    if (input.Recycle()) {
        input.coordinates.clear();
        input.margins.clear();
    }
    return reset;
}

int triaxis_output_fetch(int64_t count, uint16_t* words, uint32_t* tags, uint16_t* waits) {
    const size_t at = output.fetched;
    std::memcpy(words, output.words.data() + at, sizeof(uint16_t) * count);
    std::memcpy(tags, output.tags.data() + at, sizeof(uint32_t) * count);
    std::memcpy(waits, output.waits.data() + at, sizeof(uint16_t) * count);
    output.fetched += count;
    const bool reset = output.TakeReset();
    if (output.Recycle()) output.words.clear();
    return reset;
}

}  // extern "C"
