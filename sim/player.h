// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the players of all blocks share: the Verilated model with what its build has of mutants, coverage
// counters and a trace; patterns of clocks; and what becomes of errors that would end the process. Included by
// the one source of each library; see verilate.py and player.py.

#ifndef TRIAXIS_SIM_PLAYER_H_
#define TRIAXIS_SIM_PLAYER_H_

#include <cstdint>
#include <fstream>
#include <limits>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "Vtop.h"
#include "verilated.h"

#ifdef UPSETS
#include "Vtop___024root.h"
#include "registers.h"
// Two of the three steps of which a model's evaluation is made.
bool Vtop___024root___eval_phase__act(Vtop___024root* model);
bool Vtop___024root___eval_phase__nba(Vtop___024root* model);
#endif

#if VM_COVERAGE
#include "verilated_cov.h"
#endif
#if VM_TRACE_SAIF
#include "verilated_saif_c.h"
#endif
#ifdef SELECTABLE
#include "Vtop_triaxis_mutant.h"
#endif

// What Verilator's library calls where it would end the process: a mutant's combinational logic may run in a
// circle and never settle.
void vl_fatal(const char*, int, const char*, const char* message) { throw std::runtime_error(message); }

namespace triaxis {

// What is wrong with a play, if anything; player.py names them.
enum Symptom : int32_t {
  kPassed = 0,
  kAssertion,
  kDiverged,
};

// Half a clock of 100 MHz in the model's time unit, a picosecond.
constexpr uint64_t kHalfPeriod = 5000;
// After so many that change something, Verilator is asked, which tells of logic that does not settle.
constexpr int kMostEvaluations = 100;
// So many assertions that fail are reported by a model, and no more are checked.
constexpr int kMostErrors = 1000;

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

#if VM_TRACE_SAIF
class Followed;

// Where what toggles is left, nowhere if empty, and the model that there is.
static std::string trace_file;
static Followed* latest = nullptr;

// A model that follows its own switching activity.
class Followed {
 public:
  explicit Followed(Vtop& model, VerilatedContext& context) : context_(context) {
    model.trace(&activity_, kAllLevels);
    latest = this;
    Follow();
  }
  ~Followed() {
    if (activity_.isOpen()) activity_.close();
    latest = nullptr;
  }

  // Time, and what toggled, count from here.
  void Follow() {
    if (activity_.isOpen()) activity_.close();
    if (!trace_file.empty()) activity_.open(trace_file.c_str());
  }

  // Inputs are changed between clocks: what they do is seen with the next edge.
  void Note(bool level) {
    if (level == level_) return;
    level_ = level;
    if (!activity_.isOpen()) return;
    context_.timeInc(kHalfPeriod);
    activity_.dump(context_.time());
  }

 private:
  static constexpr int kAllLevels = 99;

  VerilatedContext& context_;
  VerilatedSaifC activity_;
  bool level_ = false;
};
#endif

// A model and its context, with mutant number `selected` where the build holds mutants. `initial`: the seed of
// what registers without a reset and memories begin with; 0 in all of them where it is negative.
class Bench {
 public:
  explicit Bench(uint32_t selected = 0, int64_t initial = -1) {
    if (initial >= 0) {
      context_.randReset(2);
      context_.randSeed(static_cast<int>(initial));
    }
    // An assertion that fails counts an error; it must not end the process.
    context_.errorLimit(std::numeric_limits<int>::max());
#if VM_COVERAGE
    context_.coveragep()->forcePerInstance(true);
#endif
#if VM_TRACE_SAIF
    context_.traceEverOn(true);
#endif
    model_ = std::make_unique<Vtop>(&context_);
#if VM_TRACE_SAIF
    followed_ = std::make_unique<Followed>(*model_, context_);
#endif
#ifdef SELECTABLE
    model_->__PVT__triaxis_mutant->selected = selected;
#else
    (void)selected;
#endif
#ifdef UPSETS
    registers_ = std::make_unique<Registers>(context_);
#endif
    if (initial >= 0) FallIntoReset(*model_);
#if VM_COVERAGE
    LeaveInitialValues(*model_);
    context_.coveragep()->zero();
#endif
  }

  // A model takes its scopes out of the thread's context: not out of another one's, which may be gone.
  ~Bench() { Verilated::threadContextp(&context_); }

  Vtop& model() { return *model_; }
  bool asserted() const { return context_.errorCount() != 0; }
  void AssertOn(bool on) { context_.assertOn(on); }

  void Eval() { model_->eval(); }

  // Inputs that were changed since the last call settle before the edge, in the same evaluation.
  void Rise() { Level(true); }
  void Fall() { Level(false); }
  // `still`: no input was changed.
  void Clock([[maybe_unused]] bool still = false) {
#ifdef UPSETS
    settled_ = still && registers_->settled();
    Rise();
    settled_ = true;
    Fall();
    settled_ = false;
#else
    Rise();
    Fall();
#endif
  }

#ifdef UPSETS
  Registers& registers() { return *registers_; }
#endif

#if VM_COVERAGE
  // Ends the file with a line by which the reader sees that it is whole: Verilator does not notice a full disk.
  void WriteCoverage(const char* file) {
    context_.coveragep()->write(file);
    std::ofstream(file, std::ios::app) << "# end\n";
  }
#endif

 private:
  template <typename Model>
  void SetClock(Model& model, bool level) {
    if constexpr (requires { model.clk_i; }) model.clk_i = level;
    if constexpr (requires { model.clk_100mhz_i; }) model.clk_100mhz_i = level;
  }

#ifdef UPSETS
  // An evaluation of which no input was changed, and no register by another hand: else all logic is computed before
  // the edge as well, as all registers are public.
  void Edge() {
    for (int again = 0; again < kMostEvaluations; ++again) {
      for (int more = 0; more < kMostEvaluations && Vtop___024root___eval_phase__act(model_->rootp); ++more) {
      }
      if (!Vtop___024root___eval_phase__nba(model_->rootp)) return;
    }
    model_->eval();
  }
#endif

  void Level(bool level) {
    SetClock(*model_, level);
#ifdef UPSETS
    if (settled_) {
      Edge();
    } else {
      model_->eval();
    }
    if (registers_->PutBack(level)) model_->eval();
#else
    model_->eval();
#endif
#if VM_TRACE_SAIF
    followed_->Note(level);
#else
    // What assertions report comes with the time.
    context_.timeInc(kHalfPeriod);
#endif
    // One that fails at every clock would fill the disk; the model stays one of which an assertion failed.
    if (context_.errorCount() >= kMostErrors) context_.assertOn(false);
  }

  // With two states a reset that is there from the start is no edge, and resets nothing until the first clock;
  // what asserts the opposite is asked after it. Logic that does not settle shows again in the first run.
  template <typename Model>
  void FallIntoReset(Model& model) {
    SetClock(model, false);
    if constexpr (requires { model.rst_ni; }) {
      context_.assertOn(false);
      try {
        for (const bool released : {true, false}) {
          model.rst_ni = released;
          model.eval();
        }
      } catch (const std::runtime_error&) {
      }
      context_.assertOn(true);
    }
  }

  // What happens before the first clock in reset is no coverage: signals leave the simulator's initial values. Nor
  // is it asserted: a reset that is no edge gives registers their values with this clock.
  template <typename Model>
  void LeaveInitialValues(Model& model) {
    if constexpr (requires { model.rst_ni; }) model.rst_ni = 0;
    if constexpr (requires { model.cpu_reset_ni; }) model.cpu_reset_ni = 0;
    SetClock(model, false);
    model.eval();
    AssertOn(false);
    Clock();
    AssertOn(true);
  }

  VerilatedContext context_;
  std::unique_ptr<Vtop> model_;
#ifdef UPSETS
  std::unique_ptr<Registers> registers_;
  bool settled_ = false;
#endif
#if VM_TRACE_SAIF
  std::unique_ptr<Followed> followed_;
#endif
};

}  // namespace triaxis

#if VM_TRACE_SAIF
// What toggles from here on is written to a file, until an empty name is given.
extern "C" void triaxis_trace(const char* file) {
  triaxis::trace_file = file;
  if (triaxis::latest) triaxis::latest->Follow();
}
#endif

// The functions by which a library's models are made, freed and asked for their coverage.
#define TRIAXIS_PLAYER(Player)                                                             \
  extern "C" void* triaxis_open(uint32_t selected, int64_t initial) {                      \
    return new Player(selected, initial);                                                  \
  }                                                                                        \
  extern "C" void triaxis_close(void* player) { delete static_cast<Player*>(player); }     \
  TRIAXIS_COVERAGE(Player)                                                                 \
  TRIAXIS_UPSETS(Player)
#if VM_COVERAGE
#define TRIAXIS_COVERAGE(Player)                                                           \
  extern "C" void triaxis_coverage(void* player, const char* file) {                       \
    static_cast<Player*>(player)->bench.WriteCoverage(file);                               \
  }
#else
#define TRIAXIS_COVERAGE(Player)
#endif
#ifdef UPSETS
// The registers in turn, nullptr after the last; `sizes`: elements, and bits of each.
#define TRIAXIS_UPSETS(Player)                                                             \
  extern "C" const char* triaxis_register(void* player, int64_t number, int32_t* sizes) {  \
    const auto& all = static_cast<Player*>(player)->bench.registers().all();               \
    if (number >= static_cast<int64_t>(all.size())) return nullptr;                        \
    sizes[0] = all[number].elements;                                                       \
    sizes[1] = all[number].bits;                                                           \
    return all[number].name.c_str();                                                       \
  }                                                                                        \
  extern "C" void triaxis_upset(void* player, int32_t upset, int64_t number,               \
                                int32_t element, int32_t bit) {                            \
    triaxis::Bench& bench = static_cast<Player*>(player)->bench;                           \
    const auto kind = static_cast<triaxis::Upset>(upset);                                  \
    bench.registers().Disturb(kind, number, element, bit);                                 \
    bench.Eval();                                                                          \
  }                                                                                        \
  extern "C" void triaxis_ignore(void* player, int64_t number, int32_t element) {          \
    static_cast<Player*>(player)->bench.registers().Ignore(number, element);               \
  }                                                                                        \
  extern "C" uint64_t triaxis_state(void* player) {                                        \
    return static_cast<Player*>(player)->bench.registers().State();                        \
  }
#else
#define TRIAXIS_UPSETS(Player)
#endif

#endif  // TRIAXIS_SIM_PLAYER_H_
