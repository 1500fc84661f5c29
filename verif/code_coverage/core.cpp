// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The core with coverage counters behind a C function: plays words into the AXI4-Stream ports as a
// schedule says, with gaps, back-pressure and resets. Built as a shared library; see
// code_coverage.py.

#include <cstdint>
#include <cstring>
#include <deque>

#include "Vcore.h"
#include "coverage_file.h"

namespace {

// Clocks without an accepted pair or a result after which the core is taken to hang: far above any
// latency plus any gap in a schedule.
constexpr int64_t kPatience = 20000;

constexpr uint8_t kOffer = 1;  // a new pair is offered
constexpr uint8_t kTake = 2;   // a result is taken
constexpr uint8_t kReset = 4;  // reset is asserted

constexpr uint8_t kDelivered = 1;
constexpr uint8_t kDiscarded = 2;

// What happens to the pairs between the ports.
class Player {
 public:
  Player(Vcore& core, const uint8_t* data, const uint64_t* user, int64_t count, uint16_t* results,
         uint8_t* states)
      : core_(core), data_(data), user_(user), count_(count), results_(results), states_(states) {}

  // Plays one clock. Returns whether the core answered as it must.
  bool Clock(uint8_t step) {
    Drive(step);
    core_.eval();
    const bool good = (step & kReset) ? QuietInReset() : Exchange();
    core_.clk_i = 1;
    core_.eval();
    core_.clk_i = 0;
    core_.eval();
    return good;
  }

  bool done() const { return next_ == count_ && !offered_ && in_flight_.empty(); }
  int64_t idle() const { return idle_; }

 private:
  void Drive(uint8_t step) {
    core_.rst_ni = !(step & kReset);
    if (step & kReset) Discard();
    if (!offered_ && next_ < count_ && (step & kOffer) && !(step & kReset)) Load();
    core_.s_axis_tvalid_i = offered_;
    core_.m_axis_tready_i = (step & kTake) != 0;
  }

  void Load() {
    std::memcpy(&core_.s_axis_tdata_i, data_ + next_ * sizeof core_.s_axis_tdata_i,
                sizeof core_.s_axis_tdata_i);
    std::memcpy(&core_.s_axis_tuser_i, user_ + next_, sizeof core_.s_axis_tuser_i);
    offered_ = true;
  }

  // An offered pair is withdrawn and offered again later; what the core holds is lost.
  void Discard() {
    offered_ = false;
    for (const int64_t pair : in_flight_) states_[pair] = kDiscarded;
    in_flight_.clear();
  }

  bool QuietInReset() const { return !core_.s_axis_tready_o && !core_.m_axis_tvalid_o; }

  bool Exchange() {
    ++idle_;
    if (core_.m_axis_tvalid_o && core_.m_axis_tready_i) {
      if (in_flight_.empty()) return false;
      const int64_t pair = in_flight_.front();
      in_flight_.pop_front();
      if (core_.m_axis_tuser_o != (user_[pair] >> MARGIN_BITS)) return false;
      results_[pair] = core_.m_axis_tdata_o;
      states_[pair] = kDelivered;
      idle_ = 0;
    }
    if (offered_ && core_.s_axis_tready_o) {
      in_flight_.push_back(next_++);
      offered_ = false;
      idle_ = 0;
    }
    return true;
  }

  Vcore& core_;
  const uint8_t* const data_;
  const uint64_t* const user_;
  const int64_t count_;
  uint16_t* const results_;
  uint8_t* const states_;
  std::deque<int64_t> in_flight_;
  int64_t next_ = 0;
  int64_t idle_ = 0;
  bool offered_ = false;
};

}  // namespace

// The size of one element of `data` in triaxis_cover.
extern "C" int64_t triaxis_data_bytes() { return sizeof Vcore::s_axis_tdata_i; }

// Plays count pairs, given as the words of TDATA and TUSER, with the steps of a schedule over and over.
// results receives TDATA of the output, states what became of each pair. Writes the coverage to a
// file. Returns the number of clocks, or a negative number: -1 the core hangs, -2 a result is
// unexpected, has a wrong tag or comes in reset.
extern "C" int64_t triaxis_cover(const uint8_t* data, const uint64_t* user, int64_t count,
                                 const uint8_t* steps, int64_t num_steps, uint16_t* results,
                                 uint8_t* states, const char* file) {
  VerilatedContext context;
  context.coveragep()->forcePerInstance(true);
  Vcore core{&context};
  core.clk_i = 0;
  Player player{core, data, user, count, results, states};
  int64_t clocks = 0;
  // What happens before the first clock after reset is no coverage: signals leave the simulator's
  // initial values there.
  player.Clock(kReset);
  context.coveragep()->zero();
  for (; !player.done(); ++clocks) {
    if (!player.Clock(steps[clocks % num_steps])) return -2;
    if (player.idle() > kPatience) return -1;
  }
  WriteCoverage(context, file);
  return clocks;
}
