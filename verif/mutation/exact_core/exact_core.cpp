// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The exact checker of golden/ as the function that triaxis_datapath.sv of this folder asks.

#include "bulk_claims.cpp"
#include "svdpi.h"

extern "C" int triaxis_claim(const svBitVecVal* pair, uint32_t margin) {
  int8_t claim;
  triaxis_claims(reinterpret_cast<const int32_t*>(pair), &margin, 1, &claim);
  return claim;
}
