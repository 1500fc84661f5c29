// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The harness of the bare mesh engine, on an engine that follows its switching activity; see
// traced_mesh.py.

#include "Vmesh.h"
#include "Vmesh___024root.h"
#include "traced.h"

namespace {

using TracedMesh = Traced<Vmesh>;

}  // namespace

#define Vmesh TracedMesh
#include "../../sim/mesh_harness.cpp"
#undef Vmesh

// What toggles from here on, until closed, is written to a file.
extern "C" void triaxis_trace_open(void* handle, const char* activity) {
  static_cast<Engine*>(handle)->model.Open(activity);
}

extern "C" void triaxis_trace_close(void* handle) { static_cast<Engine*>(handle)->model.Close(); }
