// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// The registers and memories of a model whose build makes them public, to be looked at and to be upset: one bit of
// one of them inverted between two clocks. See player.h and player.py.

#ifndef TRIAXIS_SIM_REGISTERS_H_
#define TRIAXIS_SIM_REGISTERS_H_

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "verilated.h"
#include "verilated_sym_props.h"
#include "verilated_syms.h"

namespace triaxis {

// A register, or a memory of so many elements. `bytes`: from one element to the next.
struct Register {
  std::string name;
  std::string module;
  uint8_t* data;
  uint32_t bytes;
  int32_t elements;
  int32_t bits;
};

class Registers {
 public:
  explicit Registers(VerilatedContext& context) {
    for (const auto& [scope_name, scope] : *context.scopeNameMap()) {
      if (!scope->varsp()) continue;
      for (const auto& [name, variable] : *scope->varsp()) {
        if (!variable.isPublicRW()) continue;
        int32_t elements = 1;
        for (const auto& range : variable.unpackedRanges()) elements *= range.elements();
        all_.push_back({std::string(scope->name()) + "." + name, scope->defname(),
                        static_cast<uint8_t*>(variable.datap()), variable.entSize(), elements,
                        static_cast<int32_t>(variable.entBits())});
      }
    }
  }

  const std::vector<Register>& all() const { return all_; }

  void Flip(int64_t number, int32_t element, int32_t bit) {
    const Register& one = all_[number];
    one.data[size_t{one.bytes} * element + bit / 8] ^= static_cast<uint8_t>(1u << bit % 8);
  }

  // FNV-1a over words: the same in two models where all their registers and memories are.
  uint64_t State() const {
    uint64_t state = 0xcbf29ce484222325;
    for (const Register& one : all_) {
      const size_t size = size_t{one.bytes} * one.elements;
      for (size_t at = 0; at < size; at += 8) {
        uint64_t word = 0;
        std::memcpy(&word, one.data + at, size - at < 8 ? size - at : 8);
        state = (state ^ word) * 0x100000001b3;
      }
    }
    return state;
  }

 private:
  std::vector<Register> all_;
};

}  // namespace triaxis

#endif  // TRIAXIS_SIM_REGISTERS_H_
