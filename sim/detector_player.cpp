// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The combinational wrapper CollisionDetector behind C functions; see detector.py.

#include "player.h"

namespace {

struct Player {
  Player(uint32_t selected, int64_t initial) : bench(selected, initial) {}

  bool Collides(const int64_t* inputs) {
    Vtop& top = bench.model();
    top.A1_x = inputs[0], top.A1_y = inputs[1], top.A1_z = inputs[2];
    top.A2_x = inputs[3], top.A2_y = inputs[4], top.A2_z = inputs[5];
    top.A3_x = inputs[6], top.A3_y = inputs[7], top.A3_z = inputs[8];
    top.B1_x = inputs[9], top.B1_y = inputs[10], top.B1_z = inputs[11];
    top.B2_x = inputs[12], top.B2_y = inputs[13], top.B2_z = inputs[14];
    top.B3_x = inputs[15], top.B3_y = inputs[16], top.B3_z = inputs[17];
    top.NA_x = inputs[18], top.NA_y = inputs[19], top.NA_z = inputs[20];
    top.NB_x = inputs[21], top.NB_y = inputs[22], top.NB_z = inputs[23];
    bench.Eval();
    return top.CollisionOccurs;
  }

  triaxis::Bench bench;
};

}  // namespace

TRIAXIS_PLAYER(Player)

// Runs count pairs, 24 numbers each: 18 coordinates and the two given normals. Returns the symptom.
extern "C" int32_t triaxis_detect(void* handle, const int64_t* inputs, int64_t count, uint8_t* collides) {
  Player& player = *static_cast<Player*>(handle);
  try {
    for (int64_t i = 0; i < count; ++i) collides[i] = player.Collides(inputs + 24 * i);
  } catch (const std::runtime_error&) {
    return triaxis::kDiverged;
  }
  return player.bench.asserted() ? triaxis::kAssertion : triaxis::kPassed;
}
