// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Writes the coverage counters of a model, for coverage/code_coverage.py to read.

#ifndef TRIAXIS_INSTRUMENTED_COVERAGE_FILE_H_
#define TRIAXIS_INSTRUMENTED_COVERAGE_FILE_H_

#include <fstream>

#include "verilated_cov.h"

// Ends the file with a line by which the reader sees that it is whole: Verilator does not notice a full
// disk.
inline void WriteCoverage(VerilatedContext& context, const char* file) {
  context.coveragep()->write(file);
  std::ofstream(file, std::ios::app) << "# end\n";
}

#endif  // TRIAXIS_INSTRUMENTED_COVERAGE_FILE_H_
