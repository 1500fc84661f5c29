// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Plays the steps of a script, see engine_play.py, on a mesh engine, and stops at the first thing that is wrong:
// every clock is held against the rules of the streams; every run against what the script says must come of it.

#ifndef TRIAXIS_MUTATION_ENGINE_PLAYER_H_
#define TRIAXIS_MUTATION_ENGINE_PLAYER_H_

#include <algorithm>
#include <cstdint>

#include "harness.h"

namespace triaxis::engine {

// Of this file's own, never shared: libraries of several configurations are loaded at a time.
// Clocks of a run whose length is not known yet.
constexpr int64_t kPatience = 100000;
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

// Chance of a stall in 256, decided by a generator of our own so that scripts repeat.
class Stalls {
 public:
  Stalls(int64_t seed, int64_t chance) : state_(static_cast<uint64_t>(seed) * 2 + 1), chance_(chance) {}
  bool Now() {
    if (chance_ == 0) return false;
    state_ ^= state_ << 13;
    state_ ^= state_ >> 7;
    state_ ^= state_ << 17;
    return static_cast<int64_t>((state_ >> 32) & 255) < chance_;
  }

 private:
  uint64_t state_;
  int64_t chance_;
};

inline void PutBits(void* bytes, int position, int width, uint64_t value) {
  auto* target = static_cast<uint8_t*>(bytes);
  for (int bit = 0; bit < width; ++bit) {
    const int at = position + bit;
    const auto mask = static_cast<uint8_t>(1u << (at % 8));
    target[at / 8] = static_cast<uint8_t>((value >> bit) & 1 ? target[at / 8] | mask : target[at / 8] & ~mask);
  }
}

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

template <typename Model>
class Player {
 public:
  Player(Model& engine, const Script& script) : engine_(engine), script_(script) {}

  Symptom Play() {
    engine_.clk_i = 0;
    Symptom symptom = Reset();
    for (int64_t i = 0; symptom == kPassed && i < script_.num_steps; ++i) {
      const Step& step = script_.steps[i];
      const Step* next = i + 1 < script_.num_steps ? &script_.steps[i + 1] : nullptr;
      if (step.kind == kLoad) symptom = Load(step, next);
      if (step.kind == kRun) symptom = Run(step, next, script_.clocks[i]);
      if (step.kind == kReset) symptom = Reset();
      if (symptom == kPassed && !step.early) symptom = Held(step);
      if (symptom == kPassed && engine_.contextp()->errorCount() != 0) symptom = kAssertion;
    }
    return symptom;
  }

  int64_t checked() const { return checked_; }

 private:
  // The outputs of a clock settle; the rules that hold in every clock are checked.
  Symptom Settle() {
    engine_.eval();
    const bool idle = !busy_;
    if (engine_.busy_o != busy_) return kWrongHandshake;
    if (engine_.s_axis_load_tready_o != idle || engine_.s_axis_run_tready_o != idle) {
      return kWrongHandshake;
    }
    if (idle && (engine_.m_axis_near_tvalid_o || engine_.m_axis_done_tvalid_o)) return kUnexpected;
    if (idle && !(Said() == said_)) return kUnstable;
    if (near_waits_ && !(engine_.m_axis_near_tvalid_o && engine_.m_axis_near_tdata_o == near_word_)) {
      return kUnstable;
    }
    near_waits_ = engine_.m_axis_near_tvalid_o && !engine_.m_axis_near_tready_i;
    near_word_ = engine_.m_axis_near_tdata_o;
    return kPassed;
  }

  void Edge() {
    engine_.clk_i = 1;
    engine_.eval();
    engine_.clk_i = 0;
    engine_.eval();
  }

  // Two clocks: the first of reset, the second before the engine is awake.
  Symptom Reset() {
    engine_.rst_ni = 0;
    engine_.s_axis_load_tvalid_i = 0;
    engine_.s_axis_run_tvalid_i = 0;
    load_offered_ = false;
    engine_.m_axis_near_tready_i = 1;
    engine_.m_axis_done_tready_i = 1;
    engine_.abort_i = 0;
    busy_ = near_waits_ = false;
    for (int clock = 0; clock < 2; ++clock) {
      engine_.eval();
      if (engine_.s_axis_load_tready_o || engine_.s_axis_run_tready_o || engine_.m_axis_near_tvalid_o ||
          engine_.m_axis_done_tvalid_o || engine_.busy_o || engine_.count_a_o || engine_.count_b_o ||
          engine_.overfull_o || !(Said() == Summary{.cycles = engine_.cycles_o})) {
        return kNotQuiet;
      }
      Edge();
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
    engine_.eval();
    const bool right = engine_.count_a_o == step.held_a && engine_.count_b_o == step.held_b &&
                       engine_.overfull_o == step.overfull;
    return right ? kPassed : kWrongCount;
  }

  // Word i of a load: -1 empties the mesh.
  void OfferLoad(const Step& step, int64_t i) {
    engine_.s_axis_load_tuser_i = static_cast<uint8_t>((i < 0 ? 2 : 0) | step.mesh);
    const int64_t at = step.first + std::max<int64_t>(i, 0);
    for (int c = 0; c < 9 && step.count > 0; ++c) {
      const auto value = static_cast<uint64_t>(int64_t{script_.triangles[9 * at + c]});
      PutBits(&engine_.s_axis_load_tdata_i, c * WIDTH, WIDTH, value & kCoordinateMask);
    }
  }

  void OfferRun(const Step& step) {
    for (int k = 0; k < 3; ++k) {
      PutBits(&engine_.s_axis_run_tdata_i, k * (WIDTH + 1), WIDTH + 1,
              static_cast<uint64_t>(step.move[k]) & kMoveMask);
    }
    engine_.s_axis_run_tuser_i = static_cast<uint32_t>(step.mode << MARGIN_BITS | step.margin);
    engine_.s_axis_run_tvalid_i = 1;
  }

  // Words before the first are none, where the mesh is not emptied.
  static int64_t FirstWord(const Step& step) { return step.clear ? -1 : 0; }

  Symptom Load(const Step& step, const Step* next) {
    Stalls stalls(step.seed, step.stall);
    // An abort without a run is ignored.
    engine_.abort_i = step.seed & 1;
    for (int64_t i = FirstWord(step); i < step.count;) {
      // What was offered during the run before is not withdrawn.
      const bool send = load_offered_ || !stalls.Now();
      load_offered_ = false;
      engine_.s_axis_load_tvalid_i = send;
      OfferLoad(step, i);
      // What is not valid says to empty the other mesh.
      if (!send) engine_.s_axis_load_tuser_i = static_cast<uint8_t>(3 ^ step.mesh);
      const bool started = send && i + 1 == step.count && step.early && next && next->kind == kRun;
      if (started) OfferRun(*next);
      const Symptom symptom = Settle();
      if (symptom != kPassed) return symptom;
      running_ = started;
      Edge();
      i += send;
    }
    engine_.s_axis_load_tvalid_i = 0;
    engine_.abort_i = 0;
    return kPassed;
  }

  Symptom Run(const Step& step, const Step* next, int64_t& clocks) {
    if (!running_) {
      OfferRun(step);
      // In the clock of acceptance there is no run yet to be aborted.
      engine_.abort_i = step.seed >> 1 & 1;
      const Symptom symptom = Settle();
      if (symptom != kPassed) return symptom;
      Edge();
    }
    running_ = false;
    busy_ = true;
    engine_.s_axis_run_tvalid_i = 0;
    if (step.early && next && next->kind == kRun) OfferRun(*next);
    if (step.early && next && next->kind == kLoad && FirstWord(*next) < next->count) {
      OfferLoad(*next, FirstWord(*next));
      engine_.s_axis_load_tvalid_i = load_offered_ = true;
    }
    const Symptom symptom = Follow(step, clocks);
    engine_.abort_i = 0;
    checked_ += symptom == kPassed;
    return symptom;
  }

  // From the clock after acceptance until the summary is taken.
  Symptom Follow(const Step& step, int64_t& clocks) {
    Stalls near_stalls(step.seed, step.stall), done_stalls(step.seed + 1, step.stall);
    const int64_t patience = clocks == kNever ? kPatience : clocks + 1;
    int64_t offered = kNever;
    bool aborted = false;
    streamed_ = 0;
    for (int64_t clock = 0;; ++clock) {
      if (clock == step.cut) return Reset();
      const bool abort = clock >= step.abort_at && clock < step.abort_at + step.abort_clocks;
      engine_.abort_i = step.abort_at != kNever && abort;
      engine_.m_axis_near_tready_i = clock >= step.hold && !near_stalls.Now();
      engine_.m_axis_done_tready_i = !done_stalls.Now();
      Symptom symptom = Settle();
      if (symptom == kPassed) symptom = Near(step);
      if (symptom != kPassed) return symptom;
      const bool done = engine_.m_axis_done_tvalid_o;
      if (offered == kNever && !done) {
        aborted = aborted || engine_.abort_i;
        if (clock > patience) return kHang;
      } else {
        if (!done) return kUnstable;
        if (offered == kNever) offered = clock;
        // Nothing of it moves while it waits.
        symptom = Judge(step, aborted, offered);
        if (symptom != kPassed) return symptom;
        if (clocks == kNever) clocks = offered;
        if (clocks != offered) return kWrongClocks;
      }
      const bool taken = done && engine_.m_axis_done_tready_i;
      Edge();
      if (taken) {
        busy_ = false;
        said_ = Said();
        return step.cut == kNever ? kPassed : Reset();
      }
    }
  }

  Symptom Near(const Step& step) {
    if (!engine_.m_axis_near_tvalid_o) return kPassed;
    if (engine_.m_axis_done_tvalid_o) return kEarlySummary;
    if (streamed_ >= step.near_length) return kUnexpected;
    const uint32_t* pair = script_.near + 2 * (step.near_first + streamed_);
    const uint64_t word = engine_.m_axis_near_tdata_o;
    if ((word & kIndexMask) != pair[0] || word >> INDEX_BITS != pair[1]) return kWrongNear;
    streamed_ += engine_.m_axis_near_tready_i;
    return kPassed;
  }

  Symptom Judge(const Step& step, bool aborted, int64_t offered) const {
    if (engine_.cycles_o != std::min(offered + 1, kMostCycles)) return kWrongClocks;
    const int64_t status = engine_.status_o;
    const bool first = step.mode == kModeFirst && status == kStatusFirst && step.status == kStatusFirst;
    if (aborted ? status != kStatusAborted && !first : status != step.status) return kWrongStatus;
    // What ends early has skipped and tested a part.
    const bool whole = !aborted;
    const auto right = [](int64_t is, int64_t due, bool exact) { return exact ? is == due : is <= due; };
    if (!right(engine_.group_pairs_skipped_o, step.group_pairs_skipped, whole && step.exact) ||
        !right(engine_.group_pairs_opened_o, step.group_pairs_opened, whole && step.exact) ||
        !right(engine_.pairs_skipped_o, step.pairs_skipped, whole && step.exact) ||
        !right(engine_.tested_o, step.tested, whole) || !right(engine_.near_o, step.near_count, whole)) {
      return kWrongCounters;
    }
    if (step.mode == kModeAll && engine_.near_o != streamed_) return kLostNear;
    return right(streamed_, step.near_length, whole) ? kPassed : kLostNear;
  }

  Model& engine_;
  const Script script_;
  int64_t streamed_ = 0;
  int64_t checked_ = 0;
  uint64_t near_word_ = 0;
  Summary said_{};
  bool busy_ = false;
  bool running_ = false;
  bool load_offered_ = false;
  bool near_waits_ = false;
};

}  // namespace triaxis::engine

#endif  // TRIAXIS_MUTATION_ENGINE_PLAYER_H_
