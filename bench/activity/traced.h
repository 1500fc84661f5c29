// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A Verilated model that follows its own switching activity, for harnesses that know nothing of it:
// they evaluate the model twice a clock, as always.

#ifndef TRIAXIS_TRACED_TRACED_H_
#define TRIAXIS_TRACED_TRACED_H_

#include <cstdint>

#include "verilated_saif_c.h"

template <typename Model>
class Traced : public Model {
 public:
  // Half a clock of 100 MHz in the model's time unit, a picosecond.
  static constexpr uint64_t kHalfPeriod = 5000;

  explicit Traced(VerilatedContext* context) : Model{Enabled(context)}, context_(context) {
    this->trace(&activity_, kAllLevels);
  }
  ~Traced() { Close(); }

  // Time, and what toggled, count from here.
  void Open(const char* file) { activity_.open(file); }
  void Close() {
    if (activity_.isOpen()) activity_.close();
  }

  // Inputs are changed between clocks: what they do is seen with the next edge.
  void eval() {
    Model::eval();
    if (this->clk_i == level_) return;
    level_ = this->clk_i;
    if (!activity_.isOpen()) return;
    context_->timeInc(kHalfPeriod);
    activity_.dump(context_->time());
  }

 private:
  static constexpr int kAllLevels = 99;

  static VerilatedContext* Enabled(VerilatedContext* context) {
    context->traceEverOn(true);
    return context;
  }

  VerilatedContext* context_;
  VerilatedSaifC activity_;
  uint8_t level_ = 0;
};

#endif  // TRIAXIS_TRACED_TRACED_H_
