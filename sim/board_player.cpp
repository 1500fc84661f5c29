// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The Verilated board (nexys4ddr_top) behind a C interface: a serial line at each side, pins, a clock, and what
// was seen on them clock by clock. Built as a shared library; see simulated_board.py. One clock is one period of
// the board's 100 MHz oscillator. Boards are independent of each other; triaxis_open powers one up, its line idle.
//
// Both lines are followed here, from the pins alone and by the definition: 8N1, sampled in the middle of each bit.

#include <cstdint>
#include <deque>
#include <vector>

#include "player.h"

namespace {

using triaxis::Bench;
using triaxis::Symptom;

constexpr int kDigits = 8;
constexpr int kBits = 10;  // start bit, 8 data bits, stop bit
constexpr uint8_t kEnd = 0xC0;
// The synchroniser of the reset, with room.
constexpr int64_t kResetClocks = 16;

// When Forward returns before its clocks are over: never; once the board has sent a byte or its go pin has changed;
// once it has ended a frame, its run has ended, or all that was queued is on the line.
enum Until : int32_t { kNever = 0, kSpoken, kSettled };

// What is seen, and its value: a byte to the board, one without a stop bit; the start of a frame from the board, a
// byte, one without a stop bit; the pins go, stop, the LEDs, beyond slow and warn, from bit 0 on, where one has
// changed; an edge of the beat; the reset button; the first digit lit after a reset.
enum Kind : int32_t { kRx = 0, kRxBroken, kBegin, kTx, kTxBroken, kPins, kBeat, kReset, kLit };

struct Event {
    int64_t clock;
    int32_t kind;
    int32_t value;
};

// Puts bytes on the board's line.
struct Sender {
    std::deque<uint8_t> queue;
    uint32_t frame = 0;  // bits left of the byte on the line, lowest first
    int bits = 0;
    int thirds = 0;  // of clocks, left of the bit on the line; less than a clock is the next bit's
    bool level = true;

    bool Idle() const { return queue.empty() && bits == 0 && thirds < 3; }

    bool Next() {
        if (thirds < 3) {
            if (bits == 0 && !queue.empty()) {
                frame = uint32_t{queue.front()} << 1 | 1u << 9;
                queue.pop_front();
                bits = kBits;
            }
            if (bits > 0) {
                level = frame & 1;
                frame >>= 1;
                --bits;
                thirds += CLOCKS_PER_THREE_BITS;
            } else {
                level = true;
                thirds = 0;
            }
        }
        if (thirds >= 3) thirds -= 3;
        return level;
    }
};

// Reads bytes from a line. A low level that is gone by the middle of the start bit starts nothing; a byte without a
// stop bit is broken, once for however long the line stays low.
struct Receiver {
    enum Seen { kNothing, kStarted, kByte, kBroken };

    int bit = kIdle;
    int clocks = 0;  // since the line fell
    uint8_t byte = 0;

    Seen Take(bool level) {
        if (bit == kIdle) {
            if (level) return kNothing;
            bit = kStart;
            clocks = 0;
            return kNothing;
        }
        if (bit == kLow) {
            if (level) bit = kIdle;
            return kNothing;
        }
        if (++clocks < (2 * (bit + 1) + 1) * CLOCKS_PER_THREE_BITS / 6) return kNothing;
        if (bit == kStart) {
            bit = level ? kIdle : 0;
            return level ? kNothing : kStarted;
        }
        if (bit < 8) {
            byte = static_cast<uint8_t>(byte >> 1 | (level ? 0x80 : 0));
            ++bit;
            return kNothing;
        }
        bit = level ? kIdle : kLow;
        return level ? kByte : kBroken;
    }

   private:
    static constexpr int kStart = -1, kIdle = -2, kLow = -3;
};

}  // namespace

extern "C" struct BoardPins {
    int64_t clocks;          // since power-up
    int64_t go_clocks;       // of them, those after which the go pin said go
    int64_t bad_clocks;      // those after which go and stop were not opposite
    int64_t bad_scans;       // those in which the displays were not scanned digit by digit, each equally long
    int64_t framing_errors;  // of what the board has sent
    int64_t beats;           // edges of the beat pin
    uint16_t leds;
    uint8_t go;
    uint8_t stop;
    uint8_t segments[kDigits];  // per digit, rightmost first: lit segments g..a, bit 7 the point
};

namespace {

class Player {
 public:
    Player(uint32_t selected, int64_t initial) : bench(selected, initial), top_(bench.model()) {
        top_.clk_100mhz_i = 0;
        top_.cpu_reset_ni = 1;
        top_.uart_rx_i = 1;
        bench.Eval();
        Note();
        // With two states the reset of power-up is no edge: registers have its values from the first clock on.
        bench.AssertOn(false);
        Clock();
        bench.AssertOn(true);
        for (int64_t i = 1; i < kResetClocks; ++i) Clock();
    }

    // Returns what is wrong, if anything; `done`: the clocks that were run.
    Symptom Forward(int64_t clocks, Until until, int64_t* done) {
        *done = 0;
        try {
            while (*done < clocks) {
                ++*done;
                Clock();
                if ((until == kSpoken && spoken_) || (until == kSettled && settled_)) break;
            }
        } catch (const std::exception&) {
            return triaxis::kDiverged;
        }
        return bench.asserted() ? triaxis::kAssertion : triaxis::kPassed;
    }

    // The button is pressed between two edges, and let go between two; the line stays idle, queued bytes wait.
    void Reset(int64_t clocks) {
        std::deque<uint8_t> waiting;
        waiting.swap(sender.queue);
        sender = Sender{};
        Button(false);
        for (int64_t i = 0; i < clocks; ++i) Clock();
        Button(true);
        for (int64_t i = 0; i < kResetClocks; ++i) Clock();
        sender.queue.swap(waiting);
    }

    BoardPins Pins() const {
        BoardPins pins = pins_;
        pins.leds = top_.led_o;
        pins.go = top_.go_o;
        pins.stop = top_.stop_o;
        return pins;
    }

    Bench bench;
    Sender sender;
    std::deque<uint8_t> received;
    std::vector<Event> events;
    bool notes = false;
    int64_t broken = 0;
    int64_t inverted = 0;

 private:
    void Clock() {
        spoken_ = settled_ = false;
        const bool was_idle = sender.Idle();
        bool level = sender.Next();
        if (inverted > 0) {
            --inverted;
            level = !level;
        }
        if (broken > 0) {
            --broken;
            level = false;
        }
        const bool still = top_.uart_rx_i == level;
        top_.uart_rx_i = level;
        bench.Clock(still);
        ++pins_.clocks;
        pins_.go_clocks += top_.go_o;
        settled_ = !was_idle && sender.Idle();
        if (top_.cpu_reset_ni) {
            const Receiver::Seen seen = to_board_.Take(level);
            if (seen == Receiver::kByte) Tell(kRx, to_board_.byte);
            if (seen == Receiver::kBroken) Tell(kRxBroken, 0);
            Listen(from_board_.Take(top_.uart_tx_o));
        }
        Scan();
        Note();
    }

    void Listen(Receiver::Seen seen) {
        if (seen == Receiver::kStarted && !in_frame_) {
            in_frame_ = true;
            in_body_ = false;
            Tell(kBegin, 0);
        } else if (seen == Receiver::kByte) {
            const uint8_t byte = from_board_.byte;
            received.push_back(byte);
            spoken_ = true;
            Tell(kTx, byte);
            settled_ |= in_body_ && byte == kEnd;
            if (in_body_ && byte == kEnd) in_frame_ = false;
            in_body_ = byte != kEnd;
        } else if (seen == Receiver::kBroken) {
            ++pins_.framing_errors;
            Tell(kTxBroken, 0);
        }
    }

    // Exactly one digit is lit, the next one to the left after so many clocks; none before the first.
    void Scan() {
        const uint8_t lit = static_cast<uint8_t>(~top_.an_no);
        if (lit == 0) {
            pins_.bad_scans += digit_ >= 0;
            return;
        }
        for (int digit = 0; digit < kDigits; ++digit) {
            if (lit >> digit & 1) pins_.segments[digit] = static_cast<uint8_t>(~top_.seg_no);
        }
        if (lit == (digit_ < 0 ? 1 : 1 << digit_) && digit_clocks_ > 0) {
            --digit_clocks_;
            pins_.bad_scans += first_;
        } else {
            const int next = (digit_ + 1) % kDigits;
            // The first digit after a reset is passed over in a clock.
            pins_.bad_scans += lit != 1 << next || (digit_clocks_ > 0 && !first_);
            first_ = digit_ < 0;
            if (first_) Tell(kLit, 0);
            digit_ = next;
            digit_clocks_ = DIGIT_CLOCKS - 1;
        }
    }

    void Button(bool up) {
        top_.cpu_reset_ni = up;
        bench.Eval();
        Tell(kReset, !up);
        if (!up) to_board_ = from_board_ = Receiver{};
        in_frame_ = false;
        digit_ = -1;
        digit_clocks_ = 0;
        Note();
    }

    void Note() {
        const bool go = top_.go_o;
        const uint32_t beyond = uint32_t{top_.beyond_warn_o} << 1 | top_.beyond_slow_o;
        const uint32_t seen = beyond << 18 | uint32_t{top_.led_o} << 2 | uint32_t{top_.stop_o} << 1 | go;
        if (seen != seen_) {
            spoken_ |= go != (seen_ & 1);
            // A run has ended.
            settled_ |= (seen_ & ~seen) >> kBusyBit & 1;
            seen_ = seen;
            Tell(kPins, static_cast<int32_t>(seen));
        }
        if (beat_ != top_.beat_o) {
            beat_ = top_.beat_o;
            ++pins_.beats;
            Tell(kBeat, beat_);
        }
        pins_.bad_clocks += top_.go_o == top_.stop_o;
    }

    void Tell(Kind kind, int32_t value) {
        if (notes) events.push_back({pins_.clocks, kind, value});
    }

    static constexpr int kBusyBit = 4;

    Vtop& top_;
    Receiver to_board_, from_board_;
    BoardPins pins_{};
    bool spoken_ = false, settled_ = false;
    bool in_frame_ = false, in_body_ = false;
    bool beat_ = false;
    uint32_t seen_ = 0b1010;  // stop, by pin and LED
    bool first_ = false;
    int digit_ = -1;
    int digit_clocks_ = 0;
};

Player& Of(void* player) { return *static_cast<Player*>(player); }

}  // namespace

TRIAXIS_PLAYER(Player)

extern "C" {

// Runs so many clocks, or until what is asked for. Returns the symptom.
int32_t triaxis_run(void* player, int64_t clocks, int32_t until, int64_t* done) {
    return Of(player).Forward(clocks, static_cast<Until>(until), done);
}

// Queues bytes for the line to the board.
void triaxis_send(void* player, const uint8_t* bytes, int64_t n) {
    std::deque<uint8_t>& queue = Of(player).sender.queue;
    queue.insert(queue.end(), bytes, bytes + n);
}

// Bytes queued and not yet wholly on the line.
int64_t triaxis_pending(void* player) {
    const Sender& sender = Of(player).sender;
    return static_cast<int64_t>(sender.queue.size()) + (sender.bits > 0 || sender.thirds >= 3);
}

// Takes up to n bytes that the board has sent.
int64_t triaxis_receive(void* player, uint8_t* bytes, int64_t n) {
    std::deque<uint8_t>& queue = Of(player).received;
    int64_t taken = 0;
    while (taken < n && !queue.empty()) {
        bytes[taken++] = queue.front();
        queue.pop_front();
    }
    return taken;
}

// Holds the line to the board low for the next n clocks, whatever is being sent: bits on it meanwhile are lost.
void triaxis_break(void* player, int64_t n) { Of(player).broken = n; }

// Inverts the line to the board for the next n clocks.
void triaxis_glitch(void* player, int64_t n) { Of(player).inverted = n; }

// Drops what is queued or half sent; the line goes idle.
void triaxis_unplug(void* player) { Of(player).sender = Sender{}; }

// Holds the reset button for n clocks, then lets go.
void triaxis_reset(void* player, int64_t n) { Of(player).Reset(n); }

void triaxis_pins(void* player, BoardPins* pins) { *pins = Of(player).Pins(); }

// Notes what is seen from here on, to be fetched.
void triaxis_note(void* player) { Of(player).notes = true; }

int64_t triaxis_noted(void* player) { return static_cast<int64_t>(Of(player).events.size()); }

// Copies all that was noted, and forgets it.
void triaxis_fetch(void* player, Event* events) {
    std::vector<Event>& from = Of(player).events;
    std::copy(from.begin(), from.end(), events);
    from.clear();
}

}  // extern "C"
