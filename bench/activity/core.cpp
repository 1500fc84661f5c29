// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The harness of the bare core, on a core that follows its switching activity; see traced_core.py.

#include "Vcore.h"
#include "traced.h"

namespace {

// Where the next model leaves its activity.
const char* file = nullptr;

struct TracedCore : Traced<Vcore> {
  explicit TracedCore(VerilatedContext* context) : Traced<Vcore>{context} { Open(file); }
};

}  // namespace

#define Vcore TracedCore
#include "../../sim/core_harness.cpp"
#undef Vcore

// As triaxis_run, with what toggled from reset to the last result written to a file.
extern "C" int64_t triaxis_trace(const int32_t* pairs, const uint32_t* margins, int64_t n,
                                 uint16_t* results, const char* activity) {
  file = activity;
  return triaxis_run(pairs, margins, n, results);
}
