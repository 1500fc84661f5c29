// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The exact checker of golden/ as the function that triaxis_datapath.sv of this folder asks.

#include "bulk.cpp"
#include "svdpi.h"

extern "C" svBit triaxis_is_near(const svBitVecVal* pair, uint32_t margin) {
  // Of one pair; only the first two are looked at.
  uint32_t numbers[8], extent;
  uint8_t bytes[9];
  int32_t low, high;
  const triaxis::bulk::FactArrays out{
      &numbers[0], &numbers[1], &numbers[2], &numbers[3], &numbers[4], &numbers[5], &numbers[6],
      &numbers[7], &bytes[0],   &bytes[1],   &bytes[2],   &bytes[3],   &bytes[4],   &bytes[5],
      &bytes[6],   &bytes[7],   &bytes[8],   &low,        &high,       &extent};
  triaxis_facts(reinterpret_cast<const int32_t*>(pair), &margin, 1, &out);
  const uint32_t separating = numbers[0] | numbers[1];
  return separating == 0;
}
