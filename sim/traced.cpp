// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A Verilated model that follows its own switching activity, behind the harness of the bare one, which knows
// nothing of it: it evaluates the model twice a clock, as always.

#include <cstdint>
#include <string>

#include "verilated_saif_c.h"
#ifdef TRACED_MESH
#include "Vmesh.h"
#include "Vmesh___024root.h"
#else
#include "Vcore.h"
#endif

namespace {

#ifdef TRACED_MESH
using Bare = Vmesh;
#else
using Bare = Vcore;
#endif

class Traced;

// Where activity is left, nowhere if empty, and the model that there is.
std::string file;
Traced* latest = nullptr;

class Traced : public Bare {
 public:
  explicit Traced(VerilatedContext* context) : Bare{Enabled(context)}, context_(context) {
    this->trace(&activity_, kAllLevels);
    latest = this;
    Follow();
  }
  ~Traced() {
    if (activity_.isOpen()) activity_.close();
    latest = nullptr;
  }

  // Time, and what toggled, count from here.
  void Follow() {
    if (activity_.isOpen()) activity_.close();
    if (!file.empty()) activity_.open(file.c_str());
  }

  // Inputs are changed between clocks: what they do is seen with the next edge.
  void eval() {
    Bare::eval();
    if (this->clk_i == level_) return;
    level_ = this->clk_i;
    if (!activity_.isOpen()) return;
    context_->timeInc(kHalfPeriod);
    activity_.dump(context_->time());
  }

 private:
  static constexpr int kAllLevels = 99;
  // Half a clock of 100 MHz in the model's time unit, a picosecond.
  static constexpr uint64_t kHalfPeriod = 5000;

  static VerilatedContext* Enabled(VerilatedContext* context) {
    context->traceEverOn(true);
    return context;
  }

  VerilatedContext* context_;
  VerilatedSaifC activity_;
  uint8_t level_ = 0;
};

}  // namespace

// What toggles from here on, of the model that there is or else of the next, is written to a file; with an
// empty name, that ends.
extern "C" void triaxis_trace(const char* name) {
  file = name;
  if (latest) latest->Follow();
}

#ifdef TRACED_MESH
#define Vmesh Traced
#include "mesh_harness.cpp"
#else
#define Vcore Traced
#include "core_harness.cpp"
#endif
