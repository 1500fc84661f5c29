// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mutated mesh engine behind C functions.

#include "Vmutant.h"
#include "engine_player.h"

using Mutated = triaxis::Mutated<Vmutant>;

extern "C" void* triaxis_open(uint32_t selected) { return new Mutated(selected); }

extern "C" void triaxis_close(void* mutated) { delete static_cast<Mutated*>(mutated); }

// Plays a script from reset on. clocks: of each step, those of a run, or -1 where they are to be measured.
// Returns the symptom; checked receives the number of right runs before it.
extern "C" int32_t triaxis_engine(void* mutated, const void* steps, int64_t num_steps, const int32_t* triangles,
                                  const uint32_t* near, int64_t* clocks, int64_t* checked) {
  triaxis::engine::Player player{
      static_cast<Mutated*>(mutated)->model(),
      {static_cast<const triaxis::engine::Step*>(steps), num_steps, triangles, near, clocks}};
  triaxis::Symptom symptom = triaxis::kDiverged;
  try {
    symptom = player.Play();
  } catch (const std::runtime_error&) {
    // Combinational logic that does not settle: see fatal.cpp.
  }
  *checked = player.checked();
  return symptom;
}
