// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated mesh engine behind C functions: a bus-functional model of all its streams. It offers triangles
// and runs, aborts runs, takes near pairs and summaries at given paces, and notes what it sees in one list of
// events, in order of time. Everything is sampled before the rising edge and driven after it, as the pin agents
// do. What is offered stays until it is accepted, or a reset strikes, after which it is offered again; while
// nothing is offered, the pins say something else than what was or comes next, so that an engine that takes it
// shows. See mesh_engine.py.

#include <algorithm>
#include <cstring>
#include <vector>

#include "Vtop___024root.h"
#include "player.h"

namespace {

using triaxis::Pattern;
using triaxis::Symptom;

constexpr int kCoordinates = 9;
constexpr int kMoveBits = WIDTH + 1;
constexpr int kTrialBits = 8;
constexpr int kZones = 3;
constexpr int kModeAt = kZones * MARGIN_BITS;
constexpr uint64_t kIndexMask = (uint64_t{1} << INDEX_BITS) - 1;
// Words that hold any stream's data, and what a reader of 64 bits reads beyond them.
constexpr int kWords = (kCoordinates * WIDTH + 31) / 32 + 2;

// Events at which they are to be fetched.
constexpr size_t kFull = size_t{1} << 16;
// Clocks that what was asked for may take, but for those in which the engine waits for its results to be taken:
// a scan takes little more than one for each pair of triangles.
constexpr int64_t kPatience = (int64_t{2} << (2 * INDEX_BITS)) + 2000;

// Kinds of events, and what their numbers are; mesh_engine.py has the same.
enum Kind : uint32_t {
  kLoaded,    // a: LoadedFlag; values: nine coordinates
  kAccepted,  // a: AcceptedFlag, since the run before; values: three moves, margins of the zones, mode, trial
  kAborted,   // a: the clock of the run
  kSummary,   // values: see NoteSummary
  kReset,
  kNear,     // a, b: indices in A and B; c: clocks that the pair waited
  kReached,  // a, b: indices in A and B of a pair that the core accepted
};
enum LoadedFlag : uint32_t { kOfB = 1, kClear = 2, kWithRun = 4 };
enum AcceptedFlag : uint32_t { kIdleAbort = 1, kAcknowledged = 2 };

struct Event {
  uint32_t kind, a, b, c;
};

// Triangles for a mesh, nine coordinates each, with clocks on and off, as Python holds them.
struct Load {
  int64_t mesh, clear, count;
  const int32_t* triangles;
  int64_t num_runs;
  const uint16_t* runs;
};

// A run, and the clocks after its acceptance in which it is aborted, in order. acknowledge, idle_abort: these are
// high for a clock before it is offered.
struct Run {
  int64_t move[3], margins[kZones], mode, trial, acknowledge, idle_abort, num_aborts;
  const int64_t* aborts;
};

// How far things are: whether an assertion has failed, whether nothing comes of what was asked for, all clocks,
// whether triangles are left to be loaded, runs accepted and ended, and the clocks of the last that ended.
struct Progress {
  int64_t asserted, hung, clock, loading, accepted, ended, clocks;
};

// Writes the lowest bits of a value.
void PutBits(uint32_t* words, int position, int width, int64_t value) {
  for (int done = 0; done < width;) {
    const int shift = (position + done) % 32;
    const int count = std::min(32 - shift, width - done);
    const auto mask = static_cast<uint32_t>(((uint64_t{1} << count) - 1) << shift);
    uint32_t& word = words[(position + done) / 32];
    word = (word & ~mask) | (static_cast<uint32_t>(static_cast<uint64_t>(value) >> done << shift) & mask);
    done += count;
  }
}

// Reads a signed number out of 64 bits from the byte on in which it begins.
int64_t TakeBits(const uint32_t* words, int position, int width) {
  uint64_t window;
  std::memcpy(&window, reinterpret_cast<const char*>(words) + position / 8, sizeof window);
  return static_cast<int64_t>(window << (64 - width - position % 8)) >> (64 - width);
}

// Reads a number without a sign.
int64_t TakeUnsigned(const uint32_t* words, int position, int width) {
  return width == 0 ? 0 : TakeBits(words, position, width) & ((int64_t{1} << width) - 1);
}

template <typename Pin>
void Set(Pin& pin, const uint32_t* words) {
  std::memcpy(&pin, words, sizeof pin);
}

template <typename Pin>
void Get(const Pin& pin, uint32_t* words) {
  std::memcpy(words, &pin, sizeof pin);
}

class Player {
 public:
  Player(uint32_t selected, int64_t initial) : bench(selected, initial), engine_(bench.model()), root_(*engine_.rootp) {
    engine_.m_axis_near_tready_i = engine_.m_axis_done_tready_i = 1;
    engine_.s_axis_load_tvalid_i = engine_.s_axis_run_tvalid_i = engine_.abort_i = engine_.acknowledge_i = 0;
    Guarded([this] { bench.Fall(); });
  }

  void Start(const Load& load) {
    load_ = load;
    next_word_ = load.clear ? -1 : 0;
    gaps_.Set(load.runs, load.num_runs);
    OfferWord();
    Settle();
  }

  void Start(const Run& run) {
    asked_ = run;
    asked_aborts_.assign(run.aborts, run.aborts + run.num_aborts);
    announced_ = run.idle_abort || run.acknowledge;
    if (announced_) {
      engine_.abort_i = run.idle_abort != 0;
      engine_.acknowledge_i = run.acknowledge != 0;
    } else {
      OfferRun();
    }
    Settle();
  }

  void SetPaces(const uint16_t* near, int64_t num_near, const uint16_t* done, int64_t num_done) {
    near_pace_.Set(near, num_near);
    done_pace_.Set(done, num_done);
  }

  // Between two edges, at once.
  void SetReset(bool active) {
    engine_.rst_ni = !active;
    Settle();
  }

  // Runs for some clocks, or until a load is over, a run is accepted or ended, or there is something to be said.
  Symptom Forward(int64_t clocks) {
    Guarded([=, this] { Go(clocks); });
    return diverged_ ? triaxis::kDiverged : triaxis::kPassed;
  }

  Progress progress() const {
    return {bench.asserted(), hung(), clock_, loading(), accepted_, ended_, clocks_};
  }
  int64_t held(int mesh) const { return mesh ? engine_.count_b_o : engine_.count_a_o; }

  triaxis::Bench bench;
  // What is noted besides runs: loads, pairs that reach the core.
  bool notes_loads = true;
  bool notes_core = true;
  std::vector<Event> events;
  std::vector<int64_t> values;

 private:
  // Combinational logic may not settle: the next run says so.
  template <typename Action>
  void Guarded(Action action) {
    try {
      action();
    } catch (const std::runtime_error&) {
      diverged_ = true;
    }
  }

  void Settle() {
    Guarded([this] { bench.Eval(); });
  }

  void Go(int64_t clocks) {
    const Progress before = progress();
    for (; clocks > 0; --clocks) {
      Clock();
      const bool moved = before.accepted != accepted_ || before.ended != ended_ || before.loading != loading();
      if (moved || events.size() >= kFull || hung()) return;
      // To ask takes a lock.
      if (clock_ % 256 == 0 && before.asserted != bench.asserted()) return;
    }
  }

  bool loading() const { return engine_.s_axis_load_tvalid_i || word_waits_ || next_word_ < load_.count; }
  bool hung() const { return patience_ < 0; }

  void Clock() {
    const bool reset = !engine_.rst_ni;
    const bool word_moves = !reset && engine_.s_axis_load_tvalid_i && engine_.s_axis_load_tready_o;
    const bool run_moves = !reset && engine_.s_axis_run_tvalid_i && engine_.s_axis_run_tready_o;
    const bool taken = !reset && engine_.m_axis_done_tvalid_o && engine_.m_axis_done_tready_i;
    if (reset) {
      NoteReset();
    } else {
      in_reset_ = false;
      Note(word_moves, run_moves);
    }
    Wait(reset || word_moves || run_moves || taken);
    bench.Rise();
    if (reset) {
      HoldBack();
    } else {
      OfferAgain();
    }
    if (word_moves || (!engine_.s_axis_load_tvalid_i && !word_waits_ && next_word_ < load_.count)) OfferWord();
    FollowRun(run_moves, taken || reset);
    engine_.m_axis_near_tready_i = Ready(near_pace_);
    engine_.m_axis_done_tready_i = Ready(done_pace_);
    bench.Fall();
    ++clock_;
  }

  static bool Ready(Pattern& pace) {
    const bool ready = pace.On();
    if (ready) pace.Use();
    return ready;
  }

  void Wait(bool moves) {
    const bool stalled = (engine_.m_axis_near_tvalid_o && !engine_.m_axis_near_tready_i) ||
                         (engine_.m_axis_done_tvalid_o && !engine_.m_axis_done_tready_i);
    const bool asked =
        running_ || engine_.s_axis_load_tvalid_i || engine_.s_axis_run_tvalid_i || word_waits_ || run_waits_;
    if (moves || !asked) {
      patience_ = kPatience;
    } else if (!stalled) {
      --patience_;
    }
  }

  // --- What is driven -------------------------------------------------------------------------------------

  void OfferWord() {
    const bool offered = engine_.s_axis_load_tvalid_i;
    const bool next = next_word_ < load_.count && gaps_.On();
    if (next) gaps_.Use();
    // What is not valid is a word to empty the other mesh.
    if (next || offered) PutWord(std::max<int64_t>(next_word_, 0), next && next_word_ >= 0 ? 0 : -1);
    const int64_t user = next && next_word_ >= 0 ? 0 : 2;
    engine_.s_axis_load_tuser_i = user | (next ? load_.mesh : load_.mesh ^ 1);
    engine_.s_axis_load_tvalid_i = next;
    next_word_ += next;
    HoldBack();
  }

  void OfferRun() {
    PutRun(0);
    engine_.s_axis_run_tvalid_i = 1;
    HoldBack();
  }

  // In a reset nothing is offered.
  void HoldBack() {
    if (engine_.rst_ni) return;
    word_waits_ |= engine_.s_axis_load_tvalid_i;
    run_waits_ |= engine_.s_axis_run_tvalid_i;
    engine_.s_axis_load_tvalid_i = engine_.s_axis_run_tvalid_i = 0;
  }

  void OfferAgain() {
    engine_.s_axis_load_tvalid_i |= word_waits_;
    engine_.s_axis_run_tvalid_i |= run_waits_;
    word_waits_ = run_waits_ = false;
  }

  // Triangle i, or the last, all bits flipped or none.
  void PutWord(int64_t i, int32_t flip) {
    if (load_.count == 0) return;
    const int32_t* triangle = load_.triangles + kCoordinates * std::min(i, load_.count - 1);
    uint32_t words[kWords] = {};
    for (int c = 0; c < kCoordinates; ++c) PutBits(words, c * WIDTH, WIDTH, triangle[c] ^ flip);
    Set(engine_.s_axis_load_tdata_i, words);
  }

  // All bits flipped, or none.
  void PutRun(int64_t flip) {
    uint32_t data[kWords] = {}, user[kWords] = {};
    for (int k = 0; k < 3; ++k) PutBits(data, k * kMoveBits, kMoveBits, asked_.move[k] ^ flip);
    for (int z = 0; z < kZones; ++z) PutBits(user, z * MARGIN_BITS, MARGIN_BITS, asked_.margins[z] ^ flip);
    PutBits(user, kModeAt, 2, asked_.mode ^ flip);
    PutBits(user, kModeAt + 2, kTrialBits, asked_.trial ^ flip);
    Set(engine_.s_axis_run_tdata_i, data);
    Set(engine_.s_axis_run_tuser_i, user);
  }

  void FollowRun(bool accepted, bool over) {
    if (running_) {
      ++run_clock_;
      if (over) {
        running_ = false;
        clocks_ = run_clock_;
        ++ended_;
      }
    }
    if (accepted) {
      running_ = true;
      run_clock_ = 0;
      aborts_.swap(asked_aborts_);
      next_abort_ = 0;
      ++accepted_;
      PutRun(-1);
      engine_.s_axis_run_tvalid_i = 0;
    } else if (announced_) {
      announced_ = false;
      OfferRun();
    }
    engine_.acknowledge_i = 0;
    engine_.abort_i = running_ && next_abort_ < aborts_.size() && aborts_[next_abort_] == run_clock_;
    next_abort_ += engine_.abort_i;
  }

  // --- What is seen ---------------------------------------------------------------------------------------

  void NoteReset() {
    if (!in_reset_) events.push_back({kReset});
    in_reset_ = true;
    aborted_idle_ = acknowledged_ = false;
    near_wait_ = seen_clocks_ = done_wait_ = 0;
  }

  void Note(bool word_moves, bool run_moves) {
    if (word_moves && notes_loads) NoteWord(run_moves);
    const bool busy = engine_.busy_o;
    if (busy) {
      if (engine_.abort_i) events.push_back({kAborted, seen_run_clock_});
      ++seen_run_clock_;
    } else {
      aborted_idle_ |= engine_.abort_i;
      acknowledged_ |= engine_.acknowledge_i;
      if (run_moves) NoteRun();
    }
    if (notes_core) NoteReached(root_);
    if (engine_.m_axis_near_tvalid_o) NoteNear();
    NoteSummary(busy);
  }

  void NoteWord(bool run_moves) {
    const uint32_t user = engine_.s_axis_load_tuser_i;
    events.push_back({kLoaded, (user & (kOfB | kClear)) | (run_moves ? kWithRun : 0)});
    uint32_t words[kWords];
    Get(engine_.s_axis_load_tdata_i, words);
    for (int c = 0; c < kCoordinates; ++c) values.push_back(TakeBits(words, c * WIDTH, WIDTH));
  }

  void NoteRun() {
    events.push_back({kAccepted, (aborted_idle_ ? kIdleAbort : 0u) | (acknowledged_ ? kAcknowledged : 0u)});
    uint32_t words[kWords];
    Get(engine_.s_axis_run_tdata_i, words);
    for (int k = 0; k < 3; ++k) values.push_back(TakeBits(words, k * kMoveBits, kMoveBits));
    Get(engine_.s_axis_run_tuser_i, words);
    for (int z = 0; z < kZones; ++z) values.push_back(TakeUnsigned(words, z * MARGIN_BITS, MARGIN_BITS));
    values.push_back(TakeUnsigned(words, kModeAt, 2));
    values.push_back(TakeUnsigned(words, kModeAt + 2, kTrialBits));
    seen_run_clock_ = 0;
    aborted_idle_ = acknowledged_ = false;
  }

  // Where the build lets it be seen: see mesh_public.vlt.
  template <typename Root>
  void NoteReached(const Root& root) {
    if constexpr (requires {
                    root.triaxis_mesh__DOT__core_valid;
                    root.triaxis_mesh__DOT__core_ready;
                    root.triaxis_mesh__DOT__core_a;
                    root.triaxis_mesh__DOT__core_b;
                  }) {
      if (!root.triaxis_mesh__DOT__core_valid || !root.triaxis_mesh__DOT__core_ready) return;
      events.push_back({kReached, root.triaxis_mesh__DOT__core_a, root.triaxis_mesh__DOT__core_b});
    }
  }

  void NoteNear() {
    if (!engine_.m_axis_near_tready_i) {
      ++near_wait_;
      return;
    }
    const uint64_t pair = engine_.m_axis_near_tdata_o;
    events.push_back({kNear, static_cast<uint32_t>(pair & kIndexMask), static_cast<uint32_t>(pair >> INDEX_BITS),
                      near_wait_});
    near_wait_ = 0;
  }

  // Counts the clocks of a run and of its summary's waiting, with the clock at which the run is accepted.
  void NoteSummary(bool busy) {
    const bool offered = engine_.m_axis_done_tvalid_o;
    if (!busy) {
      seen_clocks_ = 1;
      done_wait_ = 0;
      // A summary without a run is one too many.
      if (!offered) return;
    }
    if (!offered) {
      ++seen_clocks_;
    } else if (!engine_.m_axis_done_tready_i) {
      ++done_wait_;
    } else {
      events.push_back({kSummary});
      for (const uint64_t value : std::initializer_list<uint64_t>{
               engine_.status_o, engine_.cycles_o, engine_.group_pairs_skipped_o, engine_.group_pairs_opened_o,
               engine_.pairs_skipped_o, engine_.tested_o, engine_.near_o, engine_.zones_o, seen_clocks_, done_wait_,
               engine_.count_a_o, engine_.count_b_o, engine_.signature_a_o, engine_.signature_b_o, engine_.overfull_o,
               engine_.fault_o, static_cast<uint64_t>(clock_)}) {
        values.push_back(static_cast<int64_t>(value));
      }
    }
  }

  Vtop& engine_;
  const Vtop___024root& root_;
  Load load_ = {};
  Run asked_ = {};
  std::vector<int64_t> asked_aborts_, aborts_;
  Pattern gaps_, near_pace_, done_pace_;
  int64_t next_word_ = 0;
  size_t next_abort_ = 0;
  bool announced_ = false;
  bool word_waits_ = false;
  bool run_waits_ = false;
  bool running_ = false;
  int64_t run_clock_ = 0;
  int64_t accepted_ = 0;
  int64_t ended_ = 0;
  int64_t clocks_ = 0;
  int64_t clock_ = 0;
  int64_t patience_ = kPatience;
  bool diverged_ = false;
  bool in_reset_ = true;
  bool aborted_idle_ = false;
  bool acknowledged_ = false;
  uint32_t seen_run_clock_ = 0;
  uint32_t near_wait_ = 0;
  uint64_t seen_clocks_ = 0;
  uint64_t done_wait_ = 0;
};

Player& Of(void* player) { return *static_cast<Player*>(player); }

}  // namespace

TRIAXIS_PLAYER(Player)

extern "C" {

void triaxis_watch(void* player, int32_t loads, int32_t core) {
  Of(player).notes_loads = loads;
  Of(player).notes_core = core;
}

// Offers triangles. They must live until the last is accepted.
void triaxis_load(void* player, const Load* load) { Of(player).Start(*load); }

// Offers a run: while no other one is offered.
void triaxis_offer(void* player, const Run* run) { Of(player).Start(*run); }

// The paces at which near pairs and summaries are taken: clocks on and off, alternating.
void triaxis_paces(void* player, const uint16_t* near, int64_t num_near, const uint16_t* done, int64_t num_done) {
  Of(player).SetPaces(near, num_near, done, num_done);
}

void triaxis_reset(void* player, int32_t active) { Of(player).SetReset(active); }

// Runs for so many clocks at most. Returns the symptom.
int32_t triaxis_run(void* player, int64_t clocks, Progress* progress) {
  const Symptom symptom = Of(player).Forward(clocks);
  *progress = Of(player).progress();
  return symptom;
}

// How many events and values there are to be fetched.
void triaxis_noted(void* player, int64_t* num_events, int64_t* num_values) {
  *num_events = static_cast<int64_t>(Of(player).events.size());
  *num_values = static_cast<int64_t>(Of(player).values.size());
}

// Copies all of them, and forgets them.
void triaxis_fetch(void* player, Event* events, int64_t* values) {
  Player& from = Of(player);
  std::copy(from.events.begin(), from.events.end(), events);
  std::copy(from.values.begin(), from.values.end(), values);
  from.events.clear();
  from.values.clear();
}

// How many triangles the engine says that it holds of mesh 0 or 1.
int64_t triaxis_held(void* player, int32_t mesh) { return Of(player).held(mesh); }

}  // extern "C"
