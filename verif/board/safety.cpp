// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated safety module behind a C function. Built as a shared library; see safety.py.

#include <cstdint>

#include "player.h"

namespace {

template <typename Top>
void Choose(Top& top, int mutant) {
    if constexpr (requires { top.mutant_i; }) top.mutant_i = mutant;
}

}  // namespace

// Runs n clocks after power-up. inputs: a word a clock, bits 0..4 hello, load, move, run, abort, 5 link
// error, 6 refused, 7 alive, 8 done, 9..11 engine status, 12 near pairs, 13 reset. outputs: after each
// clock bit 0 go, bit 1 stop. Returns what the outputs say before the first clock.
extern "C" int safety_run(int mutant, const uint16_t* inputs, uint8_t* outputs, int64_t n) {
    VerilatedContext context;
    Vtop top{&context};
    Choose(top, mutant);
    top.clk_i = 0;
    top.rst_ni = 1;
    top.eval();
    const int before = top.go_o | top.stop_o << 1;
    for (int64_t i = 0; i < n; ++i) {
        const uint32_t word = inputs[i];
        top.hello_i = word & 1;
        top.load_i = word >> 1 & 1;
        top.move_i = word >> 2 & 1;
        top.run_i = word >> 3 & 1;
        top.abort_i = word >> 4 & 1;
        top.link_error_i = word >> 5 & 1;
        top.refused_i = word >> 6 & 1;
        top.alive_i = word >> 7 & 1;
        top.done_i = word >> 8 & 1;
        top.engine_status_i = word >> 9 & 7;
        top.near_i = word >> 12 & 1;
        top.rst_ni = !(word >> 13 & 1);
        top.eval();
        top.clk_i = 1;
        top.eval();
        outputs[i] = static_cast<uint8_t>(top.go_o | top.stop_o << 1);
        top.clk_i = 0;
        top.eval();
    }
    return before;
}
