// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Compares arithmetic.h with what it replaces, for operands of all widths; its exit status says whether they agree.

#include <cstdio>
#include <cstdlib>
#include <random>

#include "verilated.h"

namespace verilator {

QData ExtendI(int to, int bits, QData a) { return VL_EXTENDS_II(to, bits, static_cast<IData>(a)); }
QData ExtendQ(int to, int bits, QData a) { return VL_EXTENDS_QQ(to, bits, a); }
QData MultiplyI(int bits, QData a, QData b) { return VL_MULS_III(bits, static_cast<IData>(a), static_cast<IData>(b)); }
QData MultiplyQ(int bits, QData a, QData b) { return VL_MULS_QQQ(bits, a, b); }
bool LessI(int bits, QData a, QData b) { return VL_LTS_III(bits, static_cast<IData>(a), static_cast<IData>(b)); }
bool LessQ(int bits, QData a, QData b) { return VL_LTS_IQQ(bits, a, b); }
bool LessW(int bits, const WDataInP a, const WDataInP b) { return VL_LTS_IWW(bits, a, b); }
bool GreaterW(int bits, const WDataInP a, const WDataInP b) { return VL_GTS_IWW(bits, a, b); }
void AddW(int words, WDataOutP to, const WDataInP a, const WDataInP b) { VL_ADD_W(words, to, a, b); }
void SubtractW(int words, WDataOutP to, const WDataInP a, const WDataInP b) { VL_SUB_W(words, to, a, b); }
void ExtendWI(int to, int bits, WDataOutP o, IData a) { VL_EXTENDS_WI(to, bits, o, a); }
void ExtendWQ(int to, int bits, WDataOutP o, QData a) { VL_EXTENDS_WQ(to, bits, o, a); }
void ExtendWW(int to, int bits, WDataOutP o, const WDataInP a) { VL_EXTENDS_WW(to, bits, o, a); }
void ShiftLeft(int bits, WDataOutP o, const WDataInP a, IData by) { VL_SHIFTL_WWI(bits, bits, 32, o, a, by); }

}  // namespace verilator

#include "arithmetic.h"

namespace {

constexpr int kMostWords = 6;
constexpr int kMostBits = 32 * kMostWords;

std::mt19937_64 random_words;

// A number of so many bits: any, or one at an end of its range, or near it.
void Draw(int bits, EData* words) {
  const auto kind = random_words() % 4;
  const auto fill = static_cast<EData>(kind == 1 ? 0 : ~0u);
  const int count = VL_WORDS_I(bits);
  for (int i = 0; i < count; ++i) words[i] = kind == 0 ? static_cast<EData>(random_words()) : fill;
  if (kind == 3) words[count - 1] ^= EData{1} << (bits - 1) % 32;
  if (random_words() % 2) words[0] ^= random_words() % 2;
  words[count - 1] &= VL_MASK_E(bits);
}

QData Draw64(int bits) {
  EData words[2] = {};
  Draw(bits, words);
  return QData{words[1]} << 32 | words[0];
}

// Of words that are written, the bits that are used must be the same.
bool Same(int bits, EData* one, EData* other) {
  const int count = VL_WORDS_I(bits);
  one[count - 1] &= VL_MASK_E(bits);
  other[count - 1] &= VL_MASK_E(bits);
  return std::memcmp(one, other, sizeof *one * count) == 0;
}

void Check(bool same, const char* what, int bits) {
  if (same) return;
  std::printf("%s of %d bits: not what Verilator's gives\n", what, bits);
  std::exit(1);
}

void CheckNarrow(int bits) {
  const QData a = Draw64(bits), b = random_words() % 8 ? Draw64(bits) : a;
  const auto mask = VL_MASK_Q(bits);
  for (int to = bits; to <= 64; ++to) {
    const auto kept = VL_MASK_Q(to);
    Check((verilator::ExtendQ(to, bits, a) & kept) == (VL_EXTENDS_QQ(to, bits, a) & kept), "extension", bits);
    Check((verilator::ExtendQ(to, bits, a) & kept) == (VL_EXTENDS_QI(to, bits, a) & kept), "extension", bits);
  }
  Check(((verilator::MultiplyQ(bits, a, b) ^ VL_MULS_QQQ(bits, a, b)) & mask) == 0, "product", bits);
  Check(verilator::LessQ(bits, a, b) == VL_LTS_IQQ(bits, a, b), "order", bits);
  Check(verilator::LessQ(bits, b, a) == VL_GTS_IQQ(bits, a, b), "order", bits);
  if (bits > 32) return;
  const auto i = static_cast<IData>(a), j = static_cast<IData>(b);
  Check(verilator::ExtendI(32, bits, a) == VL_EXTENDS_II(32, bits, i), "short extension", bits);
  Check(((verilator::MultiplyI(bits, a, b) ^ VL_MULS_III(bits, i, j)) & mask) == 0, "short product", bits);
  Check(verilator::LessI(bits, a, b) == VL_LTS_III(bits, i, j), "short order", bits);
  Check(verilator::LessI(bits, b, a) == VL_GTS_III(bits, i, j), "short order", bits);
}

void CheckWide(int bits) {
  EData a[kMostWords], b[kMostWords], one[kMostWords], other[kMostWords];
  Draw(bits, a);
  Draw(bits, b);
  if (random_words() % 8 == 0) std::memcpy(b, a, sizeof b);
  const int words = VL_WORDS_I(bits);
  verilator::AddW(words, one, a, b);
  VL_ADD_W(words, other, a, b);
  Check(Same(bits, one, other), "sum", bits);
  verilator::SubtractW(words, one, a, b);
  VL_SUB_W(words, other, a, b);
  Check(Same(bits, one, other), "difference", bits);
  Check(verilator::LessW(bits, a, b) == VL_LTS_IWW(bits, a, b), "order", bits);
  Check(verilator::GreaterW(bits, a, b) == VL_GTS_IWW(bits, a, b), "order", bits);
  for (const int by : {0, 1, 31, 32, 33, bits / 2, bits - 1, bits, bits + 40}) {
    verilator::ShiftLeft(bits, one, a, by);
    VL_SHIFTL_WWI(bits, bits, 32, other, a, by);
    Check(Same(bits, one, other), "shift", bits);
  }
  for (int from = 1; from <= bits; ++from) {
    Draw(from, a);
    const QData q = from <= 64 ? QData{from > 32 ? a[1] : 0} << 32 | a[0] : 0;
    if (from > 64) {
      verilator::ExtendWW(bits, from, one, a);
      VL_EXTENDS_WW(bits, from, other, a);
    } else if (from > 32) {
      verilator::ExtendWQ(bits, from, one, q);
      VL_EXTENDS_WQ(bits, from, other, q);
    } else {
      verilator::ExtendWI(bits, from, one, a[0]);
      VL_EXTENDS_WI(bits, from, other, a[0]);
    }
    Check(Same(bits, one, other), "wide extension", from);
  }
}

}  // namespace

int main(int, char** arguments) {
  random_words.seed(std::strtoull(arguments[1], nullptr, 10));
  for (int round = 0; round < 200; ++round) {
    for (int bits = 1; bits <= 64; ++bits) CheckNarrow(bits);
    for (int bits = 65; bits <= kMostBits; ++bits) CheckWide(bits);
  }
}
