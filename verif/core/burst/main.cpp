// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Main program of the burst simulation. It drives the clock itself. While a burst is under way it runs
// clock cycles without a look at Python's triggers, up to the next time at which Python wants to wake
// (a Timer), or until the bus-functional model asks for it: then wake_i changes. Between bursts every
// half period is a time step like any other, so that all triggers work.

#include <algorithm>
#include <cstdint>
#include <memory>

#include "Vtop.h"
#include "burst_bfm.h"
#include "python_lock.h"
#include "verilated.h"
#include "verilated_vpi.h"

extern "C" void vlog_startup_routines_bootstrap(void);

namespace {

// In units of the time precision, 1 ps.
constexpr uint64_t kHalfPeriod = PERIOD_PS / 2;
constexpr uint64_t kNoDeadline = ~uint64_t{0};
// Clock edges without a burst or a timer after which nothing will happen any more.
constexpr int kPatience = 1000;

void RunValueCallbacks() {
    while (VerilatedVpi::callValueCbs()) {
    }
}

class Simulation {
   public:
    void Run() {
        VerilatedVpi::callCbs(cbStartOfSimulation);
        RunValueCallbacks();
        while (!context_->gotFinish()) {
            RunTimeStep();
            if (triaxis::BurstActive()) RunBurst(VerilatedVpi::cbNextDeadline());
            if (triaxis::TakeWakeRequest()) {
                top_->wake_i = !top_->wake_i;
                continue;
            }
            const uint64_t deadline = VerilatedVpi::cbNextDeadline();
            // Python may wait for a clock edge; where it waits for nothing that comes, it ends.
            idle_ = deadline == kNoDeadline && !triaxis::BurstActive() ? idle_ + 1 : 0;
            if (idle_ > kPatience) break;
            Advance(std::min(deadline, next_edge_));
        }
        top_->final();
        VerilatedVpi::callCbs(cbEndOfSimulation);
    }

   private:
    // Evaluates until nothing changes any more at the present time.
    void RunTimeStep() {
        do {
            do {
                top_->eval();
                VerilatedVpi::clearEvalNeeded();
                VerilatedVpi::doInertialPuts();
                RunValueCallbacks();
            } while (VerilatedVpi::evalNeeded());
            VerilatedVpi::callCbs(cbReadWriteSynch);
            VerilatedVpi::doInertialPuts();
            RunValueCallbacks();
        } while (VerilatedVpi::evalNeeded());
        VerilatedVpi::callCbs(cbReadOnlySynch);
    }

    // Runs clock edges while the burst is under way and Python is not due.
    void RunBurst(uint64_t deadline) {
        const triaxis::WithoutPythonLock others_may_have_it;
        while (next_edge_ < deadline && triaxis::BurstActive() && !triaxis::WakeRequested() &&
               !context_->gotFinish()) {
            context_->time(next_edge_);
            ToggleClock();
            top_->eval();
        }
    }

    // Goes on to the next time: a clock edge, or Python's timers.
    void Advance(uint64_t time) {
        context_->time(time);
        VerilatedVpi::callCbs(cbNextSimTime);
        RunValueCallbacks();
        if (time == next_edge_) ToggleClock();
        VerilatedVpi::callTimedCbs();
        RunValueCallbacks();
    }

    void ToggleClock() {
        top_->clk_i = !top_->clk_i;
        next_edge_ += kHalfPeriod;
        if (top_->clk_i) triaxis::CountCycle();
    }

    // The default context: Verilator's VPI knows no other.
    VerilatedContext* context_ = Verilated::threadContextp();
    std::unique_ptr<Vtop> top_ = std::make_unique<Vtop>("");
    uint64_t next_edge_ = kHalfPeriod;
    int idle_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
    Verilated::commandArgs(argc, argv);
    Verilated::fatalOnVpiError(false);
    Simulation simulation;
    vlog_startup_routines_bootstrap();
    simulation.Run();
    return Verilated::threadContextp()->errorCount() > 0 ? 1 : 0;
}
