// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The combinational wrapper CollisionDetector behind a C function. Built as a shared library; see
// detector.py.

#include <cstdint>

#include "Vdetector.h"

// Runs n pairs: 24 numbers each, 18 coordinates and the two given normals.
extern "C" void triaxis_detect(const int64_t* inputs, int64_t n, uint8_t* collides) {
    VerilatedContext context;
    Vdetector detector{&context};
    for (int64_t i = 0; i < n; ++i, inputs += 24) {
        detector.A1_x = inputs[0], detector.A1_y = inputs[1], detector.A1_z = inputs[2];
        detector.A2_x = inputs[3], detector.A2_y = inputs[4], detector.A2_z = inputs[5];
        detector.A3_x = inputs[6], detector.A3_y = inputs[7], detector.A3_z = inputs[8];
        detector.B1_x = inputs[9], detector.B1_y = inputs[10], detector.B1_z = inputs[11];
        detector.B2_x = inputs[12], detector.B2_y = inputs[13], detector.B2_z = inputs[14];
        detector.B3_x = inputs[15], detector.B3_y = inputs[16], detector.B3_z = inputs[17];
        detector.NA_x = inputs[18], detector.NA_y = inputs[19], detector.NA_z = inputs[20];
        detector.NB_x = inputs[21], detector.NB_y = inputs[22], detector.NB_z = inputs[23];
        detector.eval();
        collides[i] = detector.CollisionOccurs;
    }
}
