// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated core behind C functions: plays words into the AXI4-Stream ports as a schedule says, with gaps,
// back-pressure and resets, takes what comes of them, and stops at the first thing that is wrong. See
// core_engine.py.

#include <cstring>

#include "player.h"

namespace {

using triaxis::Symptom;

// Clocks without an accepted pair or a result after which the core is taken to hang: far above any latency
// plus any gap in a schedule.
constexpr int64_t kPatience = 1000;
// Clocks after the last result in which no other one may come: more than the queue holds.
constexpr int64_t kTail = 80;

constexpr uint8_t kOffer = 1;  // a new pair is offered
constexpr uint8_t kTake = 2;   // a result is taken
constexpr uint8_t kReset = 4;  // reset is asserted

constexpr uint8_t kDelivered = 1;
constexpr uint8_t kDiscarded = 2;

struct Traffic {
  // What is sent: the words of TDATA and TUSER as the model holds them, and how, over and over.
  const uint8_t* data;
  const uint64_t* user;
  int64_t count;
  const uint8_t* steps;
  int64_t num_steps;
  // The words that must come back and after how many clocks, none and negative where nobody knows: then the
  // core is trusted with the rules of the streams, and only its tags are looked at.
  const uint16_t* expected;
  int64_t latency;
  // What came of each pair: its word, and whether it was delivered or discarded.
  uint16_t* words;
  uint8_t* states;
};

struct Counts {
  int64_t checked;  // results that were right
  int64_t clocks;   // from the first pair that was accepted to the last result
};

struct Player {
  explicit Player(uint32_t selected) : bench(selected) {}
  triaxis::Bench bench;
};

class Play {
 public:
  Play(triaxis::Bench& bench, const Traffic& traffic)
      : bench_(bench), core_(bench.model()), traffic_(traffic), careful_(traffic.expected != nullptr) {}

  Symptom Run() {
    core_.clk_i = 0;
    core_.s_axis_tvalid_i = 0;
    Symptom symptom = Clock(kReset);
    for (int64_t at = 0; symptom == triaxis::kPassed && !done();) {
      symptom = Clock(traffic_.steps[at]);
      if (++at == traffic_.num_steps) at = 0;
      if (idle_ > kPatience) symptom = triaxis::kHang;
    }
    for (int64_t i = 0; careful_ && symptom == triaxis::kPassed && i < kTail; ++i) symptom = Clock(kTake);
    return symptom;
  }

  Counts counts() const { return {checked_, last_ - first_ + 1}; }

 private:
  bool done() const { return oldest_ == traffic_.count && !offered_; }

  Symptom Clock(uint8_t step) {
    const bool reset = (step & kReset) != 0;
    if (reset) Discard();
    if (!reset && !offered_ && next_ < traffic_.count && (step & kOffer)) Load();
    // The outputs come from registers: those of a core that is trusted do not wait for its inputs to settle.
    const bool settles = careful_ || core_.rst_ni == reset;
    core_.rst_ni = !reset;
    core_.s_axis_tvalid_i = offered_;
    core_.m_axis_tready_i = (step & kTake) != 0;
    if (settles) bench_.Eval();
    const Symptom symptom = reset ? Quiet() : Exchange();
    bench_.Clock();
    ++clock_;
    if (symptom != triaxis::kPassed) return symptom;
    return bench_.asserted() ? triaxis::kAssertion : triaxis::kPassed;
  }

  void Load() {
    std::memcpy(&core_.s_axis_tdata_i, traffic_.data + next_ * sizeof core_.s_axis_tdata_i,
                sizeof core_.s_axis_tdata_i);
    std::memcpy(&core_.s_axis_tuser_i, traffic_.user + next_, sizeof core_.s_axis_tuser_i);
    offered_ = true;
  }

  // An offered pair is withdrawn and offered again later; what the core holds is lost.
  void Discard() {
    offered_ = waiting_ = false;
    for (; oldest_ < next_; ++oldest_) traffic_.states[oldest_] = kDiscarded;
    eager_ = true;
    awake_ = 0;
  }

  Symptom Quiet() const {
    return core_.s_axis_tready_o || core_.m_axis_tvalid_o ? triaxis::kNotQuiet : triaxis::kPassed;
  }

  Symptom Exchange() {
    ++idle_;
    if (careful_) {
      const Symptom symptom = KeepsRules();
      if (symptom != triaxis::kPassed) return symptom;
    }
    if (core_.m_axis_tvalid_o && core_.m_axis_tready_i) {
      const Symptom symptom = Deliver();
      if (symptom != triaxis::kPassed) return symptom;
    }
    eager_ = eager_ && core_.m_axis_tready_i;
    if (offered_ && core_.s_axis_tready_o) {
      if (first_ < 0) first_ = clock_;
      accepted_[next_++ % kRemembered] = clock_;
      offered_ = false;
      idle_ = 0;
    }
    return triaxis::kPassed;
  }

  Symptom KeepsRules() {
    // Ready from the second clock on after reset, for a user who has taken every result at once so far.
    if (eager_ && awake_ > 0 && !core_.s_axis_tready_o) return triaxis::kNotReady;
    ++awake_;
    if (waiting_ && !(core_.m_axis_tvalid_o && core_.m_axis_tdata_o == word_ && core_.m_axis_tuser_o == tag_)) {
      return triaxis::kUnstable;
    }
    waiting_ = core_.m_axis_tvalid_o && !core_.m_axis_tready_i;
    word_ = core_.m_axis_tdata_o;
    tag_ = core_.m_axis_tuser_o;
    return triaxis::kPassed;
  }

  Symptom Deliver() {
    if (oldest_ == next_) return triaxis::kUnexpected;
    const int64_t pair = oldest_++;
    idle_ = 0;
    last_ = clock_;
    if (core_.m_axis_tuser_o != traffic_.user[pair] >> MARGIN_BITS) return triaxis::kWrongTag;
    traffic_.words[pair] = core_.m_axis_tdata_o;
    traffic_.states[pair] = kDelivered;
    if (careful_) {
      if (core_.m_axis_tdata_o != traffic_.expected[pair]) return triaxis::kWrongWord;
      const int64_t taken = clock_ - accepted_[pair % kRemembered];
      if (eager_ && traffic_.latency >= 0 && taken != traffic_.latency) return triaxis::kWrongLatency;
    }
    ++checked_;
    return triaxis::kPassed;
  }

  // Far more than can be in flight.
  static constexpr int64_t kRemembered = 1024;

  triaxis::Bench& bench_;
  Vtop& core_;
  const Traffic traffic_;
  const bool careful_;
  int64_t accepted_[kRemembered] = {};
  // Pairs before `next_` were accepted, those before `oldest_` are no longer in flight.
  int64_t next_ = 0;
  int64_t oldest_ = 0;
  int64_t idle_ = 0;
  int64_t clock_ = 0;
  int64_t first_ = -1;
  int64_t last_ = -1;
  int64_t checked_ = 0;
  int64_t awake_ = 0;
  uint64_t tag_ = 0;
  uint16_t word_ = 0;
  bool offered_ = false;
  bool waiting_ = false;
  bool eager_ = true;
};

}  // namespace

TRIAXIS_PLAYER(Player)

// The size of one element of `data`.
extern "C" int64_t triaxis_data_bytes() { return sizeof Vtop::s_axis_tdata_i; }

// Plays pairs from reset on. Returns the symptom.
extern "C" int32_t triaxis_play(void* player, const Traffic* traffic, Counts* counts) {
  Play play{static_cast<Player*>(player)->bench, *traffic};
  Symptom symptom = triaxis::kDiverged;
  try {
    symptom = play.Run();
  } catch (const std::runtime_error&) {
    // Combinational logic that does not settle.
  }
  *counts = play.counts();
  return symptom;
}
