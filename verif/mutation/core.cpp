// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mutated core behind C functions: plays words into the AXI4-Stream ports as a schedule says, and stops at
// the first sign of the mutant.

#include <cstring>
#include <deque>

#include "Vmutant.h"
#include "harness.h"

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

// What is sent and what must come back.
struct Traffic {
  const uint8_t* data;
  const uint64_t* user;
  const uint16_t* expected;
  int64_t count;
  const uint8_t* steps;
  int64_t num_steps;
  int64_t latency;
};

class Player {
 public:
  Player(triaxis::Mutated<Vmutant>& mutated, const Traffic& traffic)
      : mutated_(mutated), core_(mutated.model()), traffic_(traffic) {}

  Symptom Play() {
    core_.clk_i = 0;
    Symptom symptom = Clock(kReset);
    for (int64_t clock = 0; symptom == triaxis::kPassed && !done(); ++clock) {
      symptom = Clock(traffic_.steps[clock % traffic_.num_steps]);
      if (idle_ > kPatience) symptom = triaxis::kHang;
    }
    for (int64_t clock = 0; symptom == triaxis::kPassed && clock < kTail; ++clock) symptom = Clock(kTake);
    return symptom;
  }

  int64_t checked() const { return checked_; }

 private:
  struct Flying {
    int64_t pair;
    int64_t accepted;
  };

  bool done() const { return next_ == traffic_.count && !offered_ && in_flight_.empty(); }

  Symptom Clock(uint8_t step) {
    const bool reset = (step & kReset) != 0;
    if (reset) Discard();
    if (!reset && !offered_ && next_ < traffic_.count && (step & kOffer)) Load();
    core_.rst_ni = !reset;
    core_.s_axis_tvalid_i = offered_;
    core_.m_axis_tready_i = (step & kTake) != 0;
    core_.eval();
    const Symptom symptom = reset ? Quiet() : Exchange();
    core_.clk_i = 1;
    core_.eval();
    core_.clk_i = 0;
    core_.eval();
    ++clock_;
    if (symptom != triaxis::kPassed) return symptom;
    return mutated_.asserted() ? triaxis::kAssertion : triaxis::kPassed;
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
    in_flight_.clear();
    eager_ = true;
    awake_ = 0;
  }

  Symptom Quiet() const {
    return core_.s_axis_tready_o || core_.m_axis_tvalid_o ? triaxis::kNotQuiet : triaxis::kPassed;
  }

  Symptom Exchange() {
    ++idle_;
    // Ready from the second clock on after reset, for a user who has taken every result at once so far.
    if (eager_ && awake_ > 0 && !core_.s_axis_tready_o) return triaxis::kNotReady;
    ++awake_;
    if (waiting_ && !(core_.m_axis_tvalid_o && core_.m_axis_tdata_o == word_ && core_.m_axis_tuser_o == tag_)) {
      return triaxis::kUnstable;
    }
    waiting_ = core_.m_axis_tvalid_o && !core_.m_axis_tready_i;
    word_ = core_.m_axis_tdata_o;
    tag_ = core_.m_axis_tuser_o;
    if (core_.m_axis_tvalid_o && core_.m_axis_tready_i) {
      const Symptom symptom = Deliver();
      if (symptom != triaxis::kPassed) return symptom;
    }
    eager_ = eager_ && core_.m_axis_tready_i;
    if (offered_ && core_.s_axis_tready_o) {
      in_flight_.push_back({next_++, clock_});
      offered_ = false;
      idle_ = 0;
    }
    return triaxis::kPassed;
  }

  Symptom Deliver() {
    if (in_flight_.empty()) return triaxis::kUnexpected;
    const Flying oldest = in_flight_.front();
    in_flight_.pop_front();
    idle_ = 0;
    if (core_.m_axis_tuser_o != traffic_.user[oldest.pair] >> MARGIN_BITS) return triaxis::kWrongTag;
    if (core_.m_axis_tdata_o != traffic_.expected[oldest.pair]) return triaxis::kWrongWord;
    if (eager_ && clock_ - oldest.accepted != traffic_.latency) return triaxis::kWrongLatency;
    ++checked_;
    return triaxis::kPassed;
  }

  triaxis::Mutated<Vmutant>& mutated_;
  Vmutant& core_;
  const Traffic traffic_;
  std::deque<Flying> in_flight_;
  int64_t next_ = 0;
  int64_t idle_ = 0;
  int64_t clock_ = 0;
  int64_t checked_ = 0;
  int64_t awake_ = 0;
  uint64_t tag_ = 0;
  uint16_t word_ = 0;
  bool offered_ = false;
  bool waiting_ = false;
  bool eager_ = true;
};

}  // namespace

extern "C" int64_t triaxis_data_bytes() { return sizeof Vmutant::s_axis_tdata_i; }

extern "C" void* triaxis_open(uint32_t selected) { return new triaxis::Mutated<Vmutant>(selected); }

extern "C" void triaxis_close(void* mutated) { delete static_cast<triaxis::Mutated<Vmutant>*>(mutated); }

// Plays pairs from reset on. Returns the symptom; checked receives the number of right results before it.
extern "C" int32_t triaxis_play(void* mutated, const uint8_t* data, const uint64_t* user,
                                const uint16_t* expected, int64_t count, const uint8_t* steps,
                                int64_t num_steps, int64_t latency, int64_t* checked) {
  Player player{*static_cast<triaxis::Mutated<Vmutant>*>(mutated),
                Traffic{data, user, expected, count, steps, num_steps, latency}};
  Symptom symptom = triaxis::kDiverged;
  try {
    symptom = player.Play();
  } catch (const std::runtime_error&) {
    // Combinational logic that does not settle: see fatal.cpp.
  }
  *checked = player.checked();
  return symptom;
}
