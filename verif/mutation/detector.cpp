// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// A mutated wrapper CollisionDetector behind C functions.

#include "Vmutant.h"
#include "harness.h"

using Detector = triaxis::Mutated<Vmutant>;

extern "C" void* triaxis_open(uint32_t selected) { return new Detector(selected); }

extern "C" void triaxis_close(void* mutated) { delete static_cast<Detector*>(mutated); }

// Runs count pairs, 24 numbers each: 18 coordinates and the two given normals. Returns the symptom; checked
// receives the number of right results before it.
extern "C" int32_t triaxis_detect(void* mutated, const int64_t* inputs, const uint8_t* expected, int64_t count,
                                  int64_t* checked) {
  Detector& detector = *static_cast<Detector*>(mutated);
  Vmutant& model = detector.model();
  *checked = 0;
  try {
    for (int64_t i = 0; i < count; ++i, inputs += 24) {
      model.A1_x = inputs[0], model.A1_y = inputs[1], model.A1_z = inputs[2];
      model.A2_x = inputs[3], model.A2_y = inputs[4], model.A2_z = inputs[5];
      model.A3_x = inputs[6], model.A3_y = inputs[7], model.A3_z = inputs[8];
      model.B1_x = inputs[9], model.B1_y = inputs[10], model.B1_z = inputs[11];
      model.B2_x = inputs[12], model.B2_y = inputs[13], model.B2_z = inputs[14];
      model.B3_x = inputs[15], model.B3_y = inputs[16], model.B3_z = inputs[17];
      model.NA_x = inputs[18], model.NA_y = inputs[19], model.NA_z = inputs[20];
      model.NB_x = inputs[21], model.NB_y = inputs[22], model.NB_z = inputs[23];
      model.eval();
      if (model.CollisionOccurs != expected[i]) return triaxis::kWrongWord;
      if (detector.asserted()) return triaxis::kAssertion;
      ++*checked;
    }
  } catch (const std::runtime_error&) {
    return triaxis::kDiverged;
  }
  return triaxis::kPassed;
}
