// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The registers and memories of a model whose build makes them public, to be looked at and to be upset between two
// clocks. See player.h and player.py.

#ifndef TRIAXIS_SIM_REGISTERS_H_
#define TRIAXIS_SIM_REGISTERS_H_

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "verilated.h"
#include "verilated_sym_props.h"
#include "verilated_syms.h"

namespace triaxis {

// A register, or a memory of so many elements. `bytes`: from one element to the next.
struct Register {
  std::string name;
  uint8_t* data;
  uint32_t bytes;
  int32_t elements;
  int32_t bits;
};

// One bit is inverted; it keeps the value 0 or 1 from then on; its element misses the next edge.
enum Upset : int32_t { kFlip = 0, kStuckAt0, kStuckAt1, kMissedEdge };

class Registers {
 public:
  explicit Registers(VerilatedContext& context) {
    for (const auto& [scope_name, scope] : *context.scopeNameMap()) {
      if (!scope->varsp()) continue;
      for (const auto& [name, variable] : *scope->varsp()) {
        if (!variable.isPublicRW()) continue;
        int32_t elements = 1;
        for (const auto& range : variable.unpackedRanges()) elements *= range.elements();
        all_.push_back({std::string(scope->name()) + "." + name,
                        static_cast<uint8_t*>(variable.datap()), variable.entSize(), elements,
                        static_cast<int32_t>(variable.entBits())});
      }
    }
  }

  const std::vector<Register>& all() const { return all_; }

  // Whether nothing was disturbed since this was asked last.
  bool settled() { return !std::exchange(disturbed_, false); }

  void Disturb(Upset upset, int64_t number, int32_t element, int32_t bit) {
    disturbed_ = true;
    const Register& one = all_[number];
    uint8_t* const data = one.data + size_t{one.bytes} * element;
    if (upset == kMissedEdge) {
      missing_ = data;
      kept_.assign(data, data + one.bytes);
      return;
    }
    uint8_t* const byte = data + bit / 8;
    mask_ = static_cast<uint8_t>(1u << bit % 8);
    if (upset == kFlip) {
      *byte ^= mask_;
      return;
    }
    stuck_ = byte;
    value_ = upset == kStuckAt1 ? mask_ : 0;
    *byte = static_cast<uint8_t>((*byte & ~mask_) | value_);
  }

  // After an evaluation: puts back what must not have changed. Returns whether there may be more to evaluate.
  bool PutBack(bool rising) {
    if (stuck_ && (*stuck_ & mask_) != value_) {
      *stuck_ ^= mask_;
      return true;
    }
    if (!missing_ || !rising) return false;
    std::copy(kept_.begin(), kept_.end(), missing_);
    missing_ = nullptr;
    return true;
  }

  // From now on the state says nothing of this element.
  void Ignore(int64_t number, int32_t element) {
    const Register& one = all_[number];
    uint8_t* const data = one.data + size_t{one.bytes} * element;
    ignored_.push_back({data, std::vector<uint8_t>(one.bytes)});
  }

  // A hash of all registers and memories, but for those ignored; each bit of a word reaches every bit of it.
  uint64_t State() {
    for (auto& [data, kept] : ignored_) {
      std::copy(data, data + kept.size(), kept.begin());
    }
    for (auto& [data, kept] : ignored_) std::fill(data, data + kept.size(), uint8_t{0});
    const uint64_t state = Hash();
    for (auto& [data, kept] : ignored_) std::copy(kept.begin(), kept.end(), data);
    return state;
  }

 private:
  struct Ignored {
    uint8_t* data;
    std::vector<uint8_t> kept;
  };

  uint64_t Hash() const {
    uint64_t state = 0;
    for (const Register& one : all_) {
      const size_t size = size_t{one.bytes} * one.elements;
      for (size_t at = 0; at < size; at += 8) {
        uint64_t word = 0;
        std::memcpy(&word, one.data + at, size - at < 8 ? size - at : 8);
        state = (state ^ word) * 0x9e3779b97f4a7c15;
        state ^= state >> 32;
      }
    }
    return state;
  }

  std::vector<Register> all_;
  std::vector<Ignored> ignored_;
  bool disturbed_ = false;
  uint8_t* stuck_ = nullptr;
  uint8_t mask_ = 0, value_ = 0;
  uint8_t* missing_ = nullptr;
  std::vector<uint8_t> kept_;
};

}  // namespace triaxis

#endif  // TRIAXIS_SIM_REGISTERS_H_
