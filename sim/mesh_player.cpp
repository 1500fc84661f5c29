// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated mesh engine behind C functions; see mesh_engine.py. It loads meshes, runs and resets, step by
// step, and takes what comes of them. A script of steps, each with what must come of it, is played on an engine
// that is not trusted: every clock is held against the rules of the streams, every run against the script, and
// the first thing that is wrong ends it. A single step is done on an engine that is trusted with the rules: what
// it answers, and which pairs reach the core, so that a user can account for all others, is handed out.

#include <algorithm>
#include <cstring>

#include "Vtop___024root.h"
#include "player.h"

namespace {

using triaxis::Stalls;
using triaxis::Symptom;
using triaxis::kPassed;

// Clocks of a run whose length is not known yet.
constexpr int64_t kPatience = 100000;
// Clocks without any near pair, tested pair or summary after which an engine is taken to hang: skipping takes at
// most one for each pair of triangles.
constexpr int64_t kMostIdle = (int64_t{1} << (2 * INDEX_BITS)) + 1024;
// Clocks after which it must be ready for a run.
constexpr int kMostBusy = 16;
constexpr int64_t kNever = -1;
constexpr uint64_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
constexpr uint64_t kMoveMask = (uint64_t{1} << (WIDTH + 1)) - 1;
constexpr uint64_t kIndexMask = (uint64_t{1} << INDEX_BITS) - 1;
constexpr int64_t kMostCycles = (int64_t{1} << CYCLE_BITS) - 1;

enum Kind : int64_t { kLoad, kRun, kReset };
enum Mode : int64_t { kModeFirst, kModeAll };
enum Status : int64_t { kStatusFirst = 2, kStatusAborted = 3 };

struct Step {
  int64_t kind;
  int64_t mesh, clear, first, count;
  int64_t held_a, held_b, overfull;
  int64_t move[3], margin, mode;
  int64_t abort_at, abort_clocks;
  int64_t status, exact, group_pairs_skipped, group_pairs_opened, pairs_skipped, tested, near_count;
  int64_t near_first, near_length;
  int64_t seed, stall, hold, early, cut;
};

// Triangles and near pairs that steps name; the clocks of each run, or kNever where they are to be measured.
struct Script {
  const Step* steps;
  int64_t num_steps;
  const int32_t* triangles;
  const uint32_t* near;
  int64_t* clocks;
};

// What the engine says of a run, at all times.
struct Summary {
  uint64_t status, cycles, group_pairs_skipped, group_pairs_opened, pairs_skipped, tested, near_count;
  bool operator==(const Summary&) const = default;
};

// What a run of a trusted engine answers: near pairs and pairs that reached the core, as (index in A, index in B).
struct Answer {
  uint32_t* near;
  int64_t near_room;
  uint32_t* reached;
  int64_t reached_room;
  int64_t near_count, reached_count;
  Summary summary;

  void Near(uint64_t a, uint64_t b) { Put(near, near_room, near_count++, a, b); }
  void Reached(uint64_t a, uint64_t b) { Put(reached, reached_room, reached_count++, a, b); }

 private:
  static void Put(uint32_t* pairs, int64_t room, int64_t at, uint64_t a, uint64_t b) {
    if (at >= room) return;
    pairs[2 * at] = static_cast<uint32_t>(a);
    pairs[2 * at + 1] = static_cast<uint32_t>(b);
  }
};

void PutBits(void* bytes, int position, int width, uint64_t value) {
  auto* target = static_cast<uint8_t*>(bytes);
  for (int bit = 0; bit < width; ++bit) {
    const int at = position + bit;
    const auto mask = static_cast<uint8_t>(1u << (at % 8));
    target[at / 8] = static_cast<uint8_t>((value >> bit) & 1 ? target[at / 8] | mask : target[at / 8] & ~mask);
  }
}

// Notes the pair that reaches the core, where the build lets it be seen: see mesh_public.vlt.
template <typename Root>
bool NoteReached(const Root& root, Answer& answer) {
  if constexpr (requires {
                  root.triaxis_mesh__DOT__core_valid;
                  root.triaxis_mesh__DOT__core_ready;
                  root.triaxis_mesh__DOT__core_a;
                  root.triaxis_mesh__DOT__core_b;
                }) {
    if (!root.triaxis_mesh__DOT__core_valid || !root.triaxis_mesh__DOT__core_ready) return false;
    answer.Reached(root.triaxis_mesh__DOT__core_a, root.triaxis_mesh__DOT__core_b);
    return true;
  }
  return false;
}

class Player {
 public:
  explicit Player(uint32_t selected) : bench(selected), engine_(bench.model()) {}

  Symptom Play(const Script& script) {
    checked_ = 0;
    Symptom symptom = Reset();
    for (int64_t i = 0; symptom == kPassed && i < script.num_steps; ++i) {
      const Step& step = script.steps[i];
      const Step* next = i + 1 < script.num_steps ? &script.steps[i + 1] : nullptr;
      if (step.kind == kLoad) symptom = Load(script, step, next);
      if (step.kind == kRun) symptom = Run(script, step, next, script.clocks[i]);
      if (step.kind == kReset) symptom = Reset();
      if (symptom == kPassed && !step.early) symptom = Held(step);
      if (symptom == kPassed && bench.asserted()) symptom = triaxis::kAssertion;
    }
    return symptom;
  }

  // Does one step on a trusted engine.
  Symptom Do(const Step& step, const int32_t* triangles, Answer& answer) {
    const Script script{&step, 1, triangles, nullptr, nullptr};
    if (!begun_) Reset();
    answer_ = &answer;
    answer.near_count = answer.reached_count = 0;
    int64_t clocks = kNever;
    const Symptom symptom = step.kind == kLoad ? Load(script, step, nullptr) : Run(script, step, nullptr, clocks);
    answer.summary = said_;
    answer_ = nullptr;
    bench.Eval();
    return symptom;
  }

  int64_t checked() const { return checked_; }
  int64_t held(int mesh) const { return mesh ? engine_.count_b_o : engine_.count_a_o; }

  triaxis::Bench bench;

 private:
  bool trusted() const { return answer_ != nullptr; }

  // The outputs of a clock settle; the rules that hold in every clock are checked.
  Symptom Settle() {
    bench.Eval();
    if (trusted()) return kPassed;
    const bool idle = !busy_;
    if (engine_.busy_o != busy_) return triaxis::kWrongHandshake;
    if (engine_.s_axis_load_tready_o != idle || engine_.s_axis_run_tready_o != idle) {
      return triaxis::kWrongHandshake;
    }
    if (idle && (engine_.m_axis_near_tvalid_o || engine_.m_axis_done_tvalid_o)) return triaxis::kUnexpected;
    if (idle && !(Said() == said_)) return triaxis::kUnstable;
    if (near_waits_ && !(engine_.m_axis_near_tvalid_o && engine_.m_axis_near_tdata_o == near_word_)) {
      return triaxis::kUnstable;
    }
    near_waits_ = engine_.m_axis_near_tvalid_o && !engine_.m_axis_near_tready_i;
    near_word_ = engine_.m_axis_near_tdata_o;
    return kPassed;
  }

  // Two clocks: the first of reset, the second before the engine is awake.
  Symptom Reset() {
    begun_ = true;
    engine_.clk_i = 0;
    engine_.rst_ni = 0;
    engine_.s_axis_load_tvalid_i = 0;
    engine_.s_axis_run_tvalid_i = 0;
    load_offered_ = running_ = false;
    engine_.m_axis_near_tready_i = 1;
    engine_.m_axis_done_tready_i = 1;
    engine_.abort_i = 0;
    busy_ = near_waits_ = false;
    for (int clock = 0; clock < 2; ++clock) {
      bench.Eval();
      if (engine_.s_axis_load_tready_o || engine_.s_axis_run_tready_o || engine_.m_axis_near_tvalid_o ||
          engine_.m_axis_done_tvalid_o || engine_.busy_o || engine_.count_a_o || engine_.count_b_o ||
          engine_.overfull_o || !(Said() == Summary{.cycles = engine_.cycles_o})) {
        return triaxis::kNotQuiet;
      }
      bench.Clock();
      engine_.rst_ni = 1;
    }
    said_ = Said();
    return kPassed;
  }

  Summary Said() const {
    return {engine_.status_o,        engine_.cycles_o, engine_.group_pairs_skipped_o,
            engine_.group_pairs_opened_o, engine_.pairs_skipped_o, engine_.tested_o, engine_.near_o};
  }

  Symptom Held(const Step& step) {
    bench.Eval();
    const bool right = engine_.count_a_o == step.held_a && engine_.count_b_o == step.held_b &&
                       engine_.overfull_o == step.overfull;
    return right ? kPassed : triaxis::kWrongCount;
  }

  // Word i of a load: -1 empties the mesh.
  void OfferLoad(const Script& script, const Step& step, int64_t i) {
    engine_.s_axis_load_tuser_i = static_cast<uint8_t>((i < 0 ? 2 : 0) | step.mesh);
    const int64_t at = step.first + std::max<int64_t>(i, 0);
    for (int c = 0; c < 9 && step.count > 0; ++c) {
      const auto value = static_cast<uint64_t>(int64_t{script.triangles[9 * at + c]});
      PutBits(&engine_.s_axis_load_tdata_i, c * WIDTH, WIDTH, value & kCoordinateMask);
    }
  }

  void OfferRun(const Step& step) {
    for (int k = 0; k < 3; ++k) {
      PutBits(&engine_.s_axis_run_tdata_i, k * (WIDTH + 1), WIDTH + 1,
              static_cast<uint64_t>(step.move[k]) & kMoveMask);
    }
    const auto user = static_cast<uint64_t>(step.mode) << MARGIN_BITS | static_cast<uint64_t>(step.margin);
    std::memcpy(&engine_.s_axis_run_tuser_i, &user, sizeof engine_.s_axis_run_tuser_i);
    engine_.s_axis_run_tvalid_i = 1;
  }

  // Words before the first are none, where the mesh is not emptied.
  static int64_t FirstWord(const Step& step) { return step.clear ? -1 : 0; }

  Symptom Load(const Script& script, const Step& step, const Step* next) {
    Stalls stalls(step.seed, step.stall);
    // An abort without a run is ignored.
    engine_.abort_i = !trusted() && step.seed & 1;
    for (int64_t i = FirstWord(step); i < step.count;) {
      // What was offered during the run before is not withdrawn.
      const bool send = load_offered_ || !stalls.Now();
      load_offered_ = false;
      engine_.s_axis_load_tvalid_i = send;
      OfferLoad(script, step, i);
      // What is not valid says to empty the other mesh.
      if (!send) engine_.s_axis_load_tuser_i = static_cast<uint8_t>(3 ^ step.mesh);
      const bool started = send && i + 1 == step.count && step.early && next && next->kind == kRun;
      if (started) OfferRun(*next);
      const Symptom symptom = Settle();
      if (symptom != kPassed) return symptom;
      if (!engine_.s_axis_load_tready_o) return triaxis::kNotReady;
      running_ = started;
      bench.Clock();
      i += send;
    }
    engine_.s_axis_load_tvalid_i = 0;
    engine_.abort_i = 0;
    return kPassed;
  }

  Symptom Run(const Script& script, const Step& step, const Step* next, int64_t& clocks) {
    if (!running_) {
      OfferRun(step);
      // In the clock of acceptance there is no run yet to be aborted.
      engine_.abort_i = !trusted() && step.seed >> 1 & 1;
      const Symptom symptom = Accepted();
      if (symptom != kPassed) return symptom;
    }
    running_ = false;
    busy_ = true;
    engine_.s_axis_run_tvalid_i = 0;
    if (step.early && next && next->kind == kRun) OfferRun(*next);
    if (step.early && next && next->kind == kLoad && FirstWord(*next) < next->count) {
      OfferLoad(script, *next, FirstWord(*next));
      engine_.s_axis_load_tvalid_i = load_offered_ = true;
    }
    const Symptom symptom = Follow(script, step, clocks);
    engine_.abort_i = 0;
    checked_ += symptom == kPassed;
    return symptom;
  }

  // The clock in which a run is accepted: the first, where the engine keeps the rules.
  Symptom Accepted() {
    for (int wait = 0;; ++wait) {
      const Symptom symptom = Settle();
      if (symptom != kPassed) return symptom;
      const bool ready = engine_.s_axis_run_tready_o;
      if (!ready && wait == kMostBusy) return triaxis::kNotReady;
      bench.Clock();
      if (ready) return kPassed;
    }
  }

  // From the clock after acceptance until the summary is taken.
  Symptom Follow(const Script& script, const Step& step, int64_t& clocks) {
    Stalls near_stalls(step.seed, step.stall), done_stalls(step.seed + 1, step.stall);
    const int64_t patience = clocks == kNever ? kPatience : clocks + 1;
    int64_t offered = kNever;
    bool aborted = false;
    streamed_ = idle_ = 0;
    for (int64_t clock = 0;; ++clock) {
      if (clock == step.cut) return Reset();
      const bool abort = clock >= step.abort_at && clock < step.abort_at + step.abort_clocks;
      engine_.abort_i = step.abort_at != kNever && abort;
      engine_.m_axis_near_tready_i = clock >= step.hold && !near_stalls.Now();
      engine_.m_axis_done_tready_i = !done_stalls.Now();
      Symptom symptom = Settle();
      if (symptom == kPassed) symptom = trusted() ? Note() : Near(script, step);
      if (symptom != kPassed) return symptom;
      const bool done = engine_.m_axis_done_tvalid_o;
      if (!trusted()) {
        if (offered == kNever && !done) {
          aborted = aborted || engine_.abort_i;
          if (clock > patience) return triaxis::kHang;
        } else {
          if (!done) return triaxis::kUnstable;
          if (offered == kNever) offered = clock;
          // Nothing of it moves while it waits.
          symptom = Judge(step, aborted, offered);
          if (symptom != kPassed) return symptom;
          if (clocks == kNever) clocks = offered;
          if (clocks != offered) return triaxis::kWrongClocks;
        }
      }
      const bool taken = done && engine_.m_axis_done_tready_i;
      if (taken && trusted()) said_ = Said();
      bench.Clock();
      if (taken) {
        busy_ = false;
        if (!trusted()) said_ = Said();
        return step.cut == kNever ? kPassed : Reset();
      }
    }
  }

  // Takes note of what a trusted engine does in this clock.
  Symptom Note() {
    ++idle_;
    if (NoteReached(*engine_.rootp, *answer_)) idle_ = 0;
    if (engine_.m_axis_near_tvalid_o && engine_.m_axis_near_tready_i) {
      const uint64_t pair = engine_.m_axis_near_tdata_o;
      answer_->Near(pair & kIndexMask, pair >> INDEX_BITS & kIndexMask);
      idle_ = 0;
    }
    return idle_ > kMostIdle ? triaxis::kHang : kPassed;
  }

  Symptom Near(const Script& script, const Step& step) {
    if (!engine_.m_axis_near_tvalid_o) return kPassed;
    if (engine_.m_axis_done_tvalid_o) return triaxis::kEarlySummary;
    if (streamed_ >= step.near_length) return triaxis::kUnexpected;
    const uint32_t* pair = script.near + 2 * (step.near_first + streamed_);
    const uint64_t word = engine_.m_axis_near_tdata_o;
    if ((word & kIndexMask) != pair[0] || word >> INDEX_BITS != pair[1]) return triaxis::kWrongNear;
    streamed_ += engine_.m_axis_near_tready_i;
    return kPassed;
  }

  Symptom Judge(const Step& step, bool aborted, int64_t offered) const {
    if (engine_.cycles_o != std::min(offered + 1, kMostCycles)) return triaxis::kWrongClocks;
    const int64_t status = engine_.status_o;
    const bool first = step.mode == kModeFirst && status == kStatusFirst && step.status == kStatusFirst;
    if (aborted ? status != kStatusAborted && !first : status != step.status) return triaxis::kWrongStatus;
    // What ends early has skipped and tested a part.
    const bool whole = !aborted;
    const auto right = [](int64_t is, int64_t due, bool exact) { return exact ? is == due : is <= due; };
    if (!right(engine_.group_pairs_skipped_o, step.group_pairs_skipped, whole && step.exact) ||
        !right(engine_.group_pairs_opened_o, step.group_pairs_opened, whole && step.exact) ||
        !right(engine_.pairs_skipped_o, step.pairs_skipped, whole && step.exact) ||
        !right(engine_.tested_o, step.tested, whole) || !right(engine_.near_o, step.near_count, whole)) {
      return triaxis::kWrongCounters;
    }
    if (step.mode == kModeAll && engine_.near_o != streamed_) return triaxis::kLostNear;
    return right(streamed_, step.near_length, whole) ? kPassed : triaxis::kLostNear;
  }

  Vtop& engine_;
  Answer* answer_ = nullptr;
  int64_t streamed_ = 0;
  int64_t idle_ = 0;
  int64_t checked_ = 0;
  uint64_t near_word_ = 0;
  Summary said_{};
  bool begun_ = false;
  bool busy_ = false;
  bool running_ = false;
  bool load_offered_ = false;
  bool near_waits_ = false;
};

}  // namespace

TRIAXIS_PLAYER(Player)

// Does one step, a load or a run, on an engine that is trusted with the rules. Returns the symptom.
extern "C" int32_t triaxis_mesh_step(void* player, const Step* step, const int32_t* triangles, Answer* answer) {
  return static_cast<Player*>(player)->Do(*step, triangles, *answer);
}

// How many triangles the engine says that it holds of mesh 0 or 1.
extern "C" int64_t triaxis_mesh_held(void* player, int mesh) { return static_cast<Player*>(player)->held(mesh); }

// Plays a script from reset on. Returns the symptom; checked receives the number of right runs before it.
extern "C" int32_t triaxis_mesh_play(void* player, const Script* script, int64_t* checked) {
  auto& played = *static_cast<Player*>(player);
  Symptom symptom = triaxis::kDiverged;
  try {
    symptom = played.Play(*script);
  } catch (const std::runtime_error&) {
    // Combinational logic that does not settle.
  }
  *checked = played.checked();
  return symptom;
}
