// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated core behind C functions: a bus-functional model of both its streams, for whole bursts. It offers
// pairs with gaps, takes results with stalls, and notes what moves on either stream. Everything is sampled
// before the rising edge and driven after it, as the pin agents do. Driver and monitors share nothing but the
// pins: the one packs coordinates into TDATA and the other unpacks them, each by code of its own, so that a
// fault in one shows against the other. See core_engine.py.

#include <cstring>
#include <type_traits>
#include <vector>

#include "player.h"

namespace {

using triaxis::Pattern;
using triaxis::Symptom;

constexpr int kCoordinates = 18;
constexpr int kUsedBits = kCoordinates * WIDTH;
constexpr int kDataBits = 8 * ((kUsedBits + 7) / 8);
constexpr int kDataWords = (kDataBits + 31) / 32;
constexpr uint64_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
static_assert(TAG_BITS <= 64, "a tag travels in 64 bits");
// TUSER: as Verilator keeps it, lowest word first.
using User = std::conditional_t<(TAG_BITS + MARGIN_BITS > 64), unsigned __int128, uint64_t>;

// Beats in a monitor's buffer at which they are to be fetched.
constexpr size_t kFull = size_t{1} << 16;

// A burst, as Python holds it: pairs with margins and tags, clocks on and off, the clocks that it may take.
struct Burst {
  const int32_t* pairs;
  const uint32_t* margins;
  const uint64_t* tags;
  int64_t count;
  const uint16_t* runs;
  int64_t num_runs;
  int64_t budget;
};

// How far things are: pairs of the burst that were accepted, whether it goes on, whether an assertion has
// failed, and all clocks, those of the first pair and of the last result.
struct Progress {
  int64_t accepted, active, asserted, clock, first, last;
};

// What a monitor saw: the beats that moved, and before which of them a reset began.
struct Monitor {
  std::vector<uint64_t> tags;
  std::vector<uint16_t> waits;
  std::vector<size_t> resets;
  size_t fetched = 0;
  size_t resets_fetched = 0;
  uint16_t wait = 0;
  bool in_reset = true;

  // A clock in reset.
  void Reset() {
    if (!in_reset) resets.push_back(tags.size());
    in_reset = true;
    wait = 0;
  }
  // A clock in which a beat is offered; returns whether it moves.
  bool Clock(uint64_t tag, bool ready) {
    if (!ready) {
      if (wait != UINT16_MAX) ++wait;
      return false;
    }
    tags.push_back(tag);
    waits.push_back(wait);
    wait = 0;
    return true;
  }
  bool full() const { return tags.size() - fetched >= kFull; }
  // Beats before the next reset, or before the end.
  int64_t Available() const {
    return (resets_fetched < resets.size() ? resets[resets_fetched] : tags.size()) - fetched;
  }
  void Fetch(int64_t count, uint64_t* to_tags, uint16_t* to_waits) const {
    std::memcpy(to_tags, tags.data() + fetched, sizeof *to_tags * count);
    std::memcpy(to_waits, waits.data() + fetched, sizeof *to_waits * count);
  }
  // Returns whether a reset follows what was fetched; it is then fetched too.
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

void Pack(const int32_t* pair, uint32_t padding, uint32_t* words) {
  std::memset(words, 0, sizeof *words * kDataWords);
  // Unrolled, all places are constants.
#pragma GCC unroll 18
  for (int i = 0; i < kCoordinates; ++i) {
    const uint64_t bits = static_cast<uint64_t>(int64_t{pair[i]}) & kCoordinateMask;
    const int word = i * WIDTH / 32;
    const int shift = i * WIDTH % 32;
    words[word] |= static_cast<uint32_t>(bits << shift);
    if (shift + WIDTH > 32) words[word + 1] |= static_cast<uint32_t>(bits >> (32 - shift));
  }
  // What is above the coordinates has no meaning: it is anything.
  if constexpr (kUsedBits < kDataBits) {
    const uint32_t unused = padding & ((uint32_t{1} << (kDataBits - kUsedBits)) - 1);
    words[kUsedBits / 32] |= unused << (kUsedBits % 32);
  }
}

// Takes coordinates off the low end of a window of bits that is filled word by word.
void Unpack(const uint32_t* words, int32_t* coordinates) {
  uint64_t window = 0;
  int filled = 0;
  int next = 0;
#pragma GCC unroll 18
  for (int i = 0; i < kCoordinates; ++i) {
    if (filled < WIDTH) {
      window |= static_cast<uint64_t>(words[next++]) << filled;
      filled += 32;
    }
    const uint32_t raw = static_cast<uint32_t>(window) << (32 - WIDTH);
    coordinates[i] = static_cast<int32_t>(raw) >> (32 - WIDTH);
    window >>= WIDTH;
    filled -= WIDTH;
  }
}

class Player {
 public:
  Player(uint32_t selected, int64_t initial) : bench(selected, initial), core_(bench.model()) {
    core_.s_axis_tvalid_i = core_.m_axis_tready_i = 0;
  }

  void Start(const Burst& burst) {
    burst_ = burst;
    offered_ = accepted_ = cycles_ = 0;
    gaps_.Set(burst.runs, burst.num_runs);
  }
  void SetPace(const uint16_t* runs, int64_t count) { stalls_.Set(runs, count); }
  // Between two edges, at once.
  void SetReset(bool active) {
    core_.rst_ni = !active;
    settled_ = false;
  }

  // Runs for some clocks, or to the end of the burst, or until there is something to be fetched or to be said.
  void Run(int64_t clocks) {
    if (!settled_) bench.Eval();
    settled_ = true;
    const bool burst = active();
    const bool asserted = bench.asserted();
    for (; clocks > 0; --clocks) {
      Clock();
      if (burst != active() || output.full() || input.full()) return;
      // To ask takes a lock.
      if (clock_ % 256 == 0 && asserted != bench.asserted()) return;
    }
  }

  Progress progress() const { return {accepted_, active(), bench.asserted(), clock_, first_, last_}; }

  triaxis::Bench bench;
  bool watched = true;
  Monitor input, output;
  std::vector<int32_t> coordinates;
  std::vector<uint32_t> margins;
  std::vector<uint16_t> words;
  // The clock at which each result was taken.
  std::vector<int64_t> taken;

 private:
  bool active() const { return accepted_ < burst_.count && cycles_ <= burst_.budget; }

  void Clock() {
    const bool reset = !core_.rst_ni;
    const bool offered = core_.s_axis_tvalid_i;
    const bool moves = offered && core_.s_axis_tready_o;
    if (active()) ++cycles_;
    if (reset) {
      input.Reset();
      output.Reset();
    } else {
      input.in_reset = output.in_reset = false;
      if (offered && watched) WatchInput(moves);
      if (core_.m_axis_tvalid_o) WatchOutput();
    }
    bench.Rise();
    Drive(reset, offered, moves);
    const bool ready = stalls_.On();
    if (ready) stalls_.Use();
    core_.m_axis_tready_i = ready;
    bench.Fall();
    ++clock_;
  }

  void WatchInput(bool moves) {
    uint32_t data[kDataWords];
    std::memcpy(data, &core_.s_axis_tdata_i, sizeof data);
    User user = 0;
    std::memcpy(&user, &core_.s_axis_tuser_i, sizeof core_.s_axis_tuser_i);
    if (!input.Clock(static_cast<uint64_t>(user >> MARGIN_BITS), moves)) return;
    margins.push_back(static_cast<uint32_t>(user & ((uint64_t{1} << MARGIN_BITS) - 1)));
    const size_t at = coordinates.size();
    coordinates.resize(at + kCoordinates);
    Unpack(data, coordinates.data() + at);
  }

  void WatchOutput() {
    if (!output.Clock(core_.m_axis_tuser_o, core_.m_axis_tready_i)) return;
    words.push_back(core_.m_axis_tdata_o);
    taken.push_back(clock_);
    last_ = clock_;
  }

  // A beat that was offered and not accepted when a reset strikes is offered again after it.
  void Drive(bool reset, bool offered, bool moves) {
    if (reset) {
      waiting_ = waiting_ || offered;
      core_.s_axis_tvalid_i = 0;
    } else if (waiting_) {
      core_.s_axis_tvalid_i = 1;
      waiting_ = false;
    } else if (!offered || moves) {
      if (moves) {
        ++accepted_;
        if (first_ < 0) first_ = clock_;
      }
      Offer();
    }
  }

  void Offer() {
    uint32_t data[kDataWords] = {};
    User user = 0;
    const bool next = offered_ < burst_.count && active() && gaps_.On();
    if (next) {
      gaps_.Use();
      padding_ = padding_ * 1664525u + 1013904223u;
      Pack(burst_.pairs + kCoordinates * offered_, padding_ >> 16, data);
      const User tag = burst_.tags[offered_];
      user = (tag << MARGIN_BITS) | (MARGIN_BITS ? burst_.margins[offered_] : 0u);
      ++offered_;
    }
    core_.s_axis_tvalid_i = next;
    std::memcpy(&core_.s_axis_tdata_i, data, sizeof data);
    std::memcpy(&core_.s_axis_tuser_i, &user, sizeof core_.s_axis_tuser_i);
  }

  Vtop& core_;
  Burst burst_ = {};
  Pattern gaps_, stalls_;
  int64_t offered_ = 0;
  int64_t accepted_ = 0;
  int64_t cycles_ = 0;
  int64_t clock_ = 0;
  int64_t first_ = -1;
  int64_t last_ = -1;
  uint32_t padding_ = 1;
  bool waiting_ = false;
  bool settled_ = false;
};

Player& Of(void* player) { return *static_cast<Player*>(player); }

}  // namespace

TRIAXIS_PLAYER(Player)

extern "C" {

// Whether the input is monitored.
void triaxis_watch(void* player, int32_t watched) { Of(player).watched = watched; }

// Starts a burst. Its arrays must live until it is over.
void triaxis_start(void* player, const Burst* burst) { Of(player).Start(*burst); }

// The pace at which results are taken: clocks on and off, alternating.
void triaxis_pace(void* player, const uint16_t* runs, int64_t count) { Of(player).SetPace(runs, count); }

void triaxis_reset(void* player, int32_t active) { Of(player).SetReset(active); }

// Runs for so many clocks at most. Returns the symptom.
int32_t triaxis_run(void* player, int64_t clocks, Progress* progress) {
  Symptom symptom = triaxis::kPassed;
  try {
    Of(player).Run(clocks);
  } catch (const std::runtime_error&) {
    // Combinational logic that does not settle.
    symptom = triaxis::kDiverged;
  }
  *progress = Of(player).progress();
  return symptom;
}

// Beats that the next fetch gives: those before the next reset.
int64_t triaxis_input_available(void* player) { return Of(player).input.Available(); }

int64_t triaxis_output_available(void* player) { return Of(player).output.Available(); }

// Copies exactly count beats; returns 1 where a reset follows them at once.
int32_t triaxis_input_fetch(void* player, int64_t count, int32_t* pairs, uint32_t* margins, uint64_t* tags,
                            uint16_t* waits) {
  Player& from = Of(player);
  const size_t at = from.input.fetched;
  from.input.Fetch(count, tags, waits);
  std::memcpy(pairs, from.coordinates.data() + kCoordinates * at, sizeof *pairs * kCoordinates * count);
  std::memcpy(margins, from.margins.data() + at, sizeof *margins * count);
  from.input.fetched += count;
  const bool reset = from.input.TakeReset();
  if (from.input.Recycle()) {
    from.coordinates.clear();
    from.margins.clear();
  }
  return reset;
}

int32_t triaxis_output_fetch(void* player, int64_t count, uint16_t* words, uint64_t* tags, uint16_t* waits,
                             int64_t* clocks) {
  Player& from = Of(player);
  const size_t at = from.output.fetched;
  from.output.Fetch(count, tags, waits);
  std::memcpy(words, from.words.data() + at, sizeof *words * count);
  std::memcpy(clocks, from.taken.data() + at, sizeof *clocks * count);
  from.output.fetched += count;
  const bool reset = from.output.TakeReset();
  if (from.output.Recycle()) {
    from.words.clear();
    from.taken.clear();
  }
  return reset;
}

}  // extern "C"
