// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Stand-ins, with the real ones' headers, for what decides in the certified core, in the proofs
// `certified` and `certified_upset`. Signals named free_* have no driver: the prover chooses them anew
// each clock, which allows more than any data path or certifier does.

// That the real one gives the verdict of a pair, datapath_latency(W, M) clocks later: `axes_*`.
module triaxis_datapath;

  verdict_t free_verdict;
  assign verdict_o = free_verdict;

endmodule

// That the real one answers certifier_latency(W) clocks later, and what, is shown by `certificate`.
// verilog_lint: waive module-filename
module triaxis_certifier;

  logic free_holds;
  assign holds_o = free_holds;

endmodule
