// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated board (nexys4ddr_top) behind a C interface: a serial line at each side, pins, a
// clock. Built as a shared library; see simulated_board.py. One clock is one period of the board's
// 100 MHz oscillator. Boards are independent of each other.
//
//   Board* board_new()                      powered up and out of reset, the line idle
//   void board_delete(Board*)
//   int64_t board_step(Board*, n, until)    runs n clocks; where `until` is not 0, at most n: stops
//                                           after the clock in which the board has sent a byte or
//                                           its go pin has changed. Returns the clocks that were run
//   void board_send(Board*, bytes, n)       queues bytes for the line to the board
//   int64_t board_pending(Board*)           bytes queued and not yet wholly on the line
//   int64_t board_receive(Board*, bytes, n) takes up to n bytes that the board has sent
//   void board_break(Board*, n)             holds the line to the board low for the next n clocks,
//                                           whatever is being sent: bits on it meanwhile are lost
//   void board_glitch(Board*, n)            inverts the line to the board for the next n clocks
//   void board_unplug(Board*)               drops what is queued or half sent; the line goes idle
//   void board_reset(Board*, n)             holds the reset button for n clocks, then lets go; the
//                                           line stays idle, queued bytes wait
//   void board_pins(const Board*, BoardPins*)

#include <cstdint>
#include <deque>
#include <memory>

#include "player.h"

namespace {

constexpr int kDigits = 8;
constexpr int kBits = 10;  // start bit, 8 data bits, stop bit
// The synchroniser of the reset, with room.
constexpr int64_t kResetClocks = 16;

// Puts bytes on the board's line.
struct Sender {
    std::deque<uint8_t> queue;
    uint32_t frame = 0;  // bits left of the byte on the line, lowest first
    int bits = 0;
    int clocks = 0;  // left of the bit on the line
    bool level = true;

    bool Next() {
        if (clocks == 0) {
            if (bits == 0 && !queue.empty()) {
                frame = uint32_t{queue.front()} << 1 | 1u << 9;
                queue.pop_front();
                bits = kBits;
            }
            if (bits > 0) {
                level = frame & 1;
                frame >>= 1;
                --bits;
                clocks = CLOCKS_PER_BIT;
            } else {
                level = true;
            }
        }
        if (clocks > 0) --clocks;
        return level;
    }
};

// Reads bytes from the board's line, sampling the middle of each bit.
struct Receiver {
    std::deque<uint8_t> queue;
    int bit = -1;  // -1: idle
    int clocks = 0;
    uint8_t byte = 0;
    int64_t framing_errors = 0;

    bool Take(bool level) {
        if (bit < 0) {
            if (!level) {
                bit = 0;
                clocks = CLOCKS_PER_BIT + CLOCKS_PER_BIT / 2 - 1;
            }
            return false;
        }
        if (clocks-- > 0) return false;
        clocks = CLOCKS_PER_BIT - 1;
        if (bit < 8) {
            byte = static_cast<uint8_t>(byte >> 1 | (level ? 0x80 : 0));
            ++bit;
            return false;
        }
        bit = -1;
        if (!level) {
            ++framing_errors;
            return false;
        }
        queue.push_back(byte);
        return true;
    }
};

}  // namespace

extern "C" {

struct BoardPins {
    int64_t clocks;          // since board_new
    int64_t go_clocks;       // of them, those after which the go pin said go
    int64_t bad_clocks;      // those after which go and stop were not opposite
    int64_t framing_errors;  // of what the board has sent
    int64_t beats;           // edges of the beat pin
    uint16_t leds;
    uint8_t go;
    uint8_t stop;
    uint8_t segments[kDigits];  // per digit, rightmost first: lit segments g..a, bit 7 the point
};

struct Board {
    VerilatedContext context;
    Vtop top{&context};
    Sender sender;
    Receiver receiver;
    int64_t broken = 0;
    int64_t inverted = 0;
    BoardPins pins{};
};

static bool Clock(Board& board) {
    Vtop& top = board.top;
    const bool was_go = top.go_o;
    const bool was_beat = top.beat_o;
    bool level = board.sender.Next();
    if (board.inverted > 0) {
        --board.inverted;
        level = !level;
    }
    if (board.broken > 0) {
        --board.broken;
        level = false;
    }
    top.uart_rx_i = level;
    top.clk_100mhz_i = 1;
    top.eval();
    top.clk_100mhz_i = 0;
    top.eval();
    BoardPins& pins = board.pins;
    ++pins.clocks;
    pins.go_clocks += top.go_o;
    pins.beats += top.beat_o != was_beat;
    pins.bad_clocks += top.go_o == top.stop_o;
    for (int digit = 0; digit < kDigits; ++digit) {
        if (!(top.an_no >> digit & 1)) pins.segments[digit] = static_cast<uint8_t>(~top.seg_no);
    }
    return board.receiver.Take(top.uart_tx_o) || top.go_o != was_go;
}

Board* board_new() {
    auto board = std::make_unique<Board>();
    board->top.clk_100mhz_i = 0;
    board->top.cpu_reset_ni = 1;
    board->top.uart_rx_i = 1;
    board->top.eval();
    for (int64_t i = 0; i < kResetClocks; ++i) Clock(*board);
    return board.release();
}

void board_delete(Board* board) { delete board; }

int64_t board_step(Board* board, int64_t n, int until) {
    int64_t done = 0;
    while (done < n) {
        ++done;
        if (Clock(*board) && until) break;
    }
    return done;
}

void board_send(Board* board, const uint8_t* bytes, int64_t n) {
    board->sender.queue.insert(board->sender.queue.end(), bytes, bytes + n);
}

int64_t board_pending(Board* board) {
    const Sender& sender = board->sender;
    return static_cast<int64_t>(sender.queue.size()) + (sender.bits > 0 || sender.clocks > 0);
}

int64_t board_receive(Board* board, uint8_t* bytes, int64_t n) {
    std::deque<uint8_t>& queue = board->receiver.queue;
    int64_t taken = 0;
    while (taken < n && !queue.empty()) {
        bytes[taken++] = queue.front();
        queue.pop_front();
    }
    return taken;
}

void board_break(Board* board, int64_t n) { board->broken = n; }

void board_glitch(Board* board, int64_t n) { board->inverted = n; }

void board_unplug(Board* board) { board->sender = Sender{}; }

void board_reset(Board* board, int64_t n) {
    const Sender waiting = board->sender;
    board->sender = Sender{};
    board->top.cpu_reset_ni = 0;
    for (int64_t i = 0; i < n; ++i) Clock(*board);
    board->top.cpu_reset_ni = 1;
    for (int64_t i = 0; i < kResetClocks; ++i) Clock(*board);
    board->sender.queue = waiting.queue;
    board->receiver.bit = -1;
}

void board_pins(const Board* board, BoardPins* pins) {
    *pins = board->pins;
    pins->framing_errors = board->receiver.framing_errors;
    pins->leds = board->top.led_o;
    pins->go = board->top.go_o;
    pins->stop = board->top.stop_o;
}

}  // extern "C"
