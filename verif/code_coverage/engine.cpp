// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The mesh engine with coverage counters behind C functions: plays scripts, as the engines of mutants do. Built
// as a shared library; see instrumented_engine.py.

#include "../mutation/engine_player.h"
#include "Vengine.h"
#include "coverage_file.h"

namespace {

struct Instrumented {
  VerilatedContext context;
  std::unique_ptr<Vengine> model;
};

}  // namespace

extern "C" void* triaxis_cover_open() {
  auto engine = std::make_unique<Instrumented>();
  engine->context.coveragep()->forcePerInstance(true);
  engine->model = std::make_unique<Vengine>(&engine->context);
  // What happens before the first clock in reset is no coverage: signals leave the simulator's initial
  // values there.
  Vengine& model = *engine->model;
  model.clk_i = 0;
  model.rst_ni = 0;
  model.eval();
  model.clk_i = 1;
  model.eval();
  model.clk_i = 0;
  model.eval();
  engine->context.coveragep()->zero();
  return engine.release();
}

// Plays a script; the arguments are those of triaxis_engine in ../mutation/engine.cpp.
extern "C" int32_t triaxis_cover_play(void* handle, const void* steps, int64_t num_steps,
                                      const int32_t* triangles, const uint32_t* near, int64_t* clocks,
                                      int64_t* checked) {
  triaxis::engine::Player player{
      *static_cast<Instrumented*>(handle)->model,
      {static_cast<const triaxis::engine::Step*>(steps), num_steps, triangles, near, clocks}};
  const triaxis::Symptom symptom = player.Play();
  *checked = player.checked();
  return symptom;
}

// Writes the coverage to a file, and frees the model.
extern "C" void triaxis_cover_close(void* handle, const char* file) {
  const std::unique_ptr<Instrumented> engine{static_cast<Instrumented*>(handle)};
  WriteCoverage(engine->context, file);
}
