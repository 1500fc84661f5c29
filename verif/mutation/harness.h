// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What the harnesses of mutants share: how a mutant is found out, and what becomes of errors that would end
// the process.

#ifndef TRIAXIS_MUTATION_HARNESS_H_
#define TRIAXIS_MUTATION_HARNESS_H_

#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>

#include "verilated.h"

#ifdef SELECTABLE
#include TRIAXIS_MODEL_SELECTION
#endif

namespace triaxis {

// How a run ends; verif/mutation/models.py names them.
enum Symptom : int32_t {
  kPassed = 0,
  kWrongWord,
  kWrongTag,
  kUnexpected,
  kHang,
  kWrongLatency,
  kNotReady,
  kUnstable,
  kNotQuiet,
  kAssertion,
  kDiverged,
  kWrongStatus,
  kWrongClocks,
  kWrongCounters,
  kWrongNear,
  kLostNear,
  kWrongCount,
  kWrongHandshake,
  kEarlySummary,
};

// A model and its context, with mutant number `selected` where the build holds mutants.
template <typename Model>
class Mutated {
 public:
  explicit Mutated(uint32_t selected) {
    // An assertion that fails counts an error; it must not end the process.
    context_.errorLimit(std::numeric_limits<int>::max());
    model_ = std::make_unique<Model>(&context_);
#ifdef SELECTABLE
    model_->__PVT__triaxis_mutant->selected = selected;
#else
    (void)selected;
#endif
  }
  Model& model() { return *model_; }
  bool asserted() const { return context_.errorCount() != 0; }

 private:
  VerilatedContext context_;
  std::unique_ptr<Model> model_;
};

}  // namespace triaxis

#endif  // TRIAXIS_MUTATION_HARNESS_H_
