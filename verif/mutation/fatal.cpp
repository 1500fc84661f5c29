// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// What Verilator's library calls where it would end the process (it is built with VL_USER_FATAL): a mutant's
// combinational logic may run in a circle and never settle.

#include <stdexcept>

#include "verilated.h"

void vl_fatal(const char*, int, const char*, const char* message) { throw std::runtime_error(message); }
