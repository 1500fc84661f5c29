// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The bare Verilated mesh engine behind C functions: loads meshes, runs, takes near pairs and the
// summary, with stalls and an abort where they are asked for. Also notes which pairs reach the
// core, so that a user can account for all others. Built as a shared library; see mesh_engine.py.

#include <cstdint>
#include <cstring>
#include <memory>

#include "Vmesh.h"
#include "Vmesh___024root.h"

namespace {

constexpr int kCoordinates = 9;
constexpr uint64_t kCoordinateMask = (uint64_t{1} << WIDTH) - 1;
constexpr int kMoveBits = WIDTH + 1;
constexpr uint64_t kIndexMask = (uint64_t{1} << INDEX_BITS) - 1;

// Clocks without any near pair, tested pair or summary after which the engine is taken to hang: skipping takes at
// most one for each pair of triangles.
constexpr uint64_t kPatience = (uint64_t{1} << (2 * INDEX_BITS)) + 1024;

// Chance of a stall in 256 for each stream, decided by a generator of our own so that runs repeat.
struct Stalls {
    uint64_t state;
    uint32_t chance;
    bool Now() {
        if (chance == 0) return false;
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        return ((state >> 32) & 255) < chance;
    }
};

void PutBits(uint8_t* bytes, int position, int width, uint64_t value) {
    for (int bit = 0; bit < width; ++bit) {
        const int at = position + bit;
        const uint8_t mask = static_cast<uint8_t>(1u << (at % 8));
        if ((value >> bit) & 1) bytes[at / 8] |= mask;
        else bytes[at / 8] &= static_cast<uint8_t>(~mask);
    }
}

struct Engine {
    VerilatedContext context;
    Vmesh model{&context};

    // A model takes its scopes out of the thread's context: not out of another engine's, which may be gone.
    ~Engine() { Verilated::threadContextp(&context); }

    // Inputs that were changed since the last call settle before the edge.
    void Clock() {
        model.clk_i = 1;
        model.eval();
        model.clk_i = 0;
        model.eval();
    }

    void Reset() {
        model.clk_i = 0;
        model.s_axis_load_tvalid_i = 0;
        model.s_axis_run_tvalid_i = 0;
        model.abort_i = 0;
        model.m_axis_near_tready_i = 0;
        model.m_axis_done_tready_i = 0;
        model.rst_ni = 0;
        model.eval();
        Clock();
        model.rst_ni = 1;
        model.eval();
        Clock();
    }
};

}  // namespace

extern "C" {

struct Summary {
    int64_t status, cycles, group_pairs_skipped, group_pairs_opened, pairs_skipped, tested, near_count;
    // Pairs that reached the core, counted here.
    int64_t reached;
};

void* triaxis_mesh_new() {
    auto engine = std::make_unique<Engine>();
    engine->Reset();
    return engine.release();
}

void triaxis_mesh_delete(void* handle) { delete static_cast<Engine*>(handle); }

void triaxis_mesh_reset(void* handle) { static_cast<Engine*>(handle)->Reset(); }

// Empties mesh 0 or 1 and loads n triangles of nine coordinates. Returns what the engine then holds, or -1
// where it is not ready to load.
int64_t triaxis_mesh_load(void* handle, int mesh, const int32_t* triangles, int64_t n,
                          uint64_t stall_seed, uint32_t stall_chance) {
    auto& engine = *static_cast<Engine*>(handle);
    auto& model = engine.model;
    Stalls stalls{stall_seed | 1, stall_chance};
    for (int64_t i = -1; i < n;) {
        const bool send = !stalls.Now();
        model.s_axis_load_tvalid_i = send;
        model.s_axis_load_tuser_i = (i < 0 ? 2 : 0) | mesh;
        if (i >= 0) {
            auto* bytes = reinterpret_cast<uint8_t*>(&model.s_axis_load_tdata_i);
            for (int c = 0; c < kCoordinates; ++c) {
                const uint64_t value = static_cast<uint64_t>(int64_t{triangles[kCoordinates * i + c]});
                PutBits(bytes, c * WIDTH, WIDTH, value & kCoordinateMask);
            }
        }
        if (!model.s_axis_load_tready_o) return -1;
        engine.Clock();
        i += send;
    }
    model.s_axis_load_tvalid_i = 0;
    model.eval();
    return mesh ? model.count_b_o : model.count_a_o;
}

// Runs once. move: three numbers. near receives (index in A, index in B) of at most near_room near pairs, tested
// the pairs that reached the core, at most tested_room (0: not wanted). abort_at: clocks after acceptance, or
// negative. Returns the number of near pairs streamed, or -1: the engine hangs.
int64_t triaxis_mesh_run(void* handle, const int64_t* move, uint64_t margin, int mode,
                         int64_t abort_at, uint64_t stall_seed, uint32_t stall_chance,
                         uint32_t* near, int64_t near_room, uint32_t* tested, int64_t tested_room,
                         Summary* summary) {
    auto& engine = *static_cast<Engine*>(handle);
    auto& model = engine.model;
    Stalls stalls{stall_seed | 1, stall_chance};
    auto* bytes = reinterpret_cast<uint8_t*>(&model.s_axis_run_tdata_i);
    for (int k = 0; k < 3; ++k) {
        PutBits(bytes, k * kMoveBits, kMoveBits, static_cast<uint64_t>(move[k]));
    }
    const uint64_t user = (static_cast<uint64_t>(mode) << MARGIN_BITS) | margin;
    std::memcpy(&model.s_axis_run_tuser_i, &user, sizeof model.s_axis_run_tuser_i);
    model.s_axis_run_tvalid_i = 1;
    for (int wait = 0; !model.s_axis_run_tready_o; ++wait) {
        if (wait > 16) return -1;
        engine.Clock();
    }
    engine.Clock();
    model.s_axis_run_tvalid_i = 0;

    int64_t near_count = 0;
    int64_t tested_count = 0;
    uint64_t idle = 0;
    for (int64_t clock = 0;; ++clock) {
        model.abort_i = clock == abort_at;
        model.m_axis_near_tready_i = !stalls.Now();
        model.m_axis_done_tready_i = !stalls.Now();
        model.eval();
        const auto& root = *model.rootp;
        ++idle;
        if (root.triaxis_mesh__DOT__core_valid && root.triaxis_mesh__DOT__core_ready) {
            if (tested_count < tested_room) {
                tested[2 * tested_count] = root.triaxis_mesh__DOT__core_a;
                tested[2 * tested_count + 1] = root.triaxis_mesh__DOT__core_b;
            }
            ++tested_count;
            idle = 0;
        }
        if (model.m_axis_near_tvalid_o && model.m_axis_near_tready_i) {
            if (near_count < near_room) {
                const uint64_t pair = model.m_axis_near_tdata_o;
                near[2 * near_count] = static_cast<uint32_t>(pair & kIndexMask);
                near[2 * near_count + 1] = static_cast<uint32_t>(pair >> INDEX_BITS & kIndexMask);
            }
            ++near_count;
            idle = 0;
        }
        if (model.m_axis_done_tvalid_o && model.m_axis_done_tready_i) {
            *summary = {model.status_o, static_cast<int64_t>(model.cycles_o),
                        static_cast<int64_t>(model.group_pairs_skipped_o),
                        static_cast<int64_t>(model.group_pairs_opened_o),
                        static_cast<int64_t>(model.pairs_skipped_o),
                        static_cast<int64_t>(model.tested_o), static_cast<int64_t>(model.near_o),
                        tested_count};
            engine.Clock();
            model.abort_i = 0;
            return near_count;
        }
        if (idle > kPatience) return -1;
        engine.Clock();
    }
}

}  // extern "C"
