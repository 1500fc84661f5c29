// Copyright Triaxis contributors.
// SPDX-License-Identifier: Apache-2.0
//
// Verilator's signed and wide arithmetic in forms that a compiler sees through; included by every model after
// Verilator's own, which they replace by name. What they return is what Verilator's return for operands whose
// unused upper bits are 0, which Verilator promises here, in all bits that are used. Extension of a sign is a
// pair of shifts, which fold into what stands around them; products need no sign, as their upper half is never
// asked for; words of up to 128 bits are one number of the compiler, without branches on signs.

#ifndef TRIAXIS_SIM_ARITHMETIC_H_
#define TRIAXIS_SIM_ARITHMETIC_H_

#include <cstdint>
#include <cstring>

#include "verilated.h"

#define TRIAXIS_INLINE [[gnu::always_inline]] static inline

namespace triaxis {

using Wide = unsigned __int128;

constexpr int kWideBits = 128;

TRIAXIS_INLINE int32_t Signed32(int bits, IData value) {
  return static_cast<int32_t>(value << (32 - bits)) >> (32 - bits);
}

TRIAXIS_INLINE int64_t Signed64(int bits, QData value) {
  return static_cast<int64_t>(value << (64 - bits)) >> (64 - bits);
}

TRIAXIS_INLINE __int128 SignedWide(int bits, Wide value) {
  return static_cast<__int128>(value << (kWideBits - bits)) >> (kWideBits - bits);
}

// Whether words of 32 bits are one number here: the others are left to Verilator.
TRIAXIS_INLINE bool Fits(int words) { return words >= 2 && words <= 4; }

TRIAXIS_INLINE Wide Load(int words, const EData* from) {
  uint64_t low;
  uint64_t high = 0;
  std::memcpy(&low, from, sizeof low);
  if (words == 3) high = from[2];
  if (words == 4) std::memcpy(&high, from + 2, sizeof high);
  return Wide{high} << 64 | low;
}

TRIAXIS_INLINE WDataOutP Store(int words, WDataOutP to, Wide value) {
  const auto low = static_cast<uint64_t>(value);
  const auto high = static_cast<uint64_t>(value >> 64);
  std::memcpy(to, &low, sizeof low);
  if (words == 3) to[2] = static_cast<EData>(high);
  if (words == 4) std::memcpy(to + 2, &high, sizeof high);
  return to;
}

TRIAXIS_INLINE IData ExtendII(int, int bits, IData value) { return Signed32(bits, value); }
// A number that fits 32 bits is told to be one: the product of two of them is one instruction of vectors.
TRIAXIS_INLINE QData ExtendQI(int, int bits, QData value) {
  return bits > 32 ? Signed64(bits, value) : int64_t{Signed32(bits, static_cast<IData>(value))};
}
TRIAXIS_INLINE QData ExtendQQ(int, int bits, QData value) { return Signed64(bits, value); }

TRIAXIS_INLINE WDataOutP ExtendWQ(int to_bits, int bits, WDataOutP to, QData value) {
  if (!Fits(VL_WORDS_I(to_bits))) return VL_EXTENDS_WQ(to_bits, bits, to, value);
  return Store(VL_WORDS_I(to_bits), to, SignedWide(bits, value));
}

TRIAXIS_INLINE WDataOutP ExtendWI(int to_bits, int bits, WDataOutP to, IData value) {
  if (!Fits(VL_WORDS_I(to_bits))) return VL_EXTENDS_WI(to_bits, bits, to, value);
  return Store(VL_WORDS_I(to_bits), to, SignedWide(bits, value));
}

TRIAXIS_INLINE WDataOutP ExtendWW(int to_bits, int bits, WDataOutP to, const WDataInP value) {
  if (!Fits(VL_WORDS_I(to_bits)) || VL_WORDS_I(bits) < 2) return VL_EXTENDS_WW(to_bits, bits, to, value);
  return Store(VL_WORDS_I(to_bits), to, SignedWide(bits, Load(VL_WORDS_I(bits), value)));
}

TRIAXIS_INLINE IData MultiplyI(int, IData one, IData other) { return one * other; }
TRIAXIS_INLINE QData MultiplyQ(int, QData one, QData other) { return one * other; }

TRIAXIS_INLINE IData LessI(int bits, IData one, IData other) {
  return static_cast<int32_t>(one << (32 - bits)) < static_cast<int32_t>(other << (32 - bits));
}

TRIAXIS_INLINE IData LessQ(int bits, QData one, QData other) {
  return static_cast<int64_t>(one << (64 - bits)) < static_cast<int64_t>(other << (64 - bits));
}

TRIAXIS_INLINE IData LessW(int bits, const WDataInP one, const WDataInP other) {
  const int words = VL_WORDS_I(bits);
  if (!Fits(words)) return _vl_cmps_w(bits, one, other) < 0;
  const int unused = kWideBits - bits;
  return static_cast<__int128>(Load(words, one) << unused) < static_cast<__int128>(Load(words, other) << unused);
}

TRIAXIS_INLINE WDataOutP AddW(int words, WDataOutP to, const WDataInP one, const WDataInP other) {
  if (!Fits(words)) return VL_ADD_W(words, to, one, other);
  return Store(words, to, Load(words, one) + Load(words, other));
}

TRIAXIS_INLINE WDataOutP SubtractW(int words, WDataOutP to, const WDataInP one, const WDataInP other) {
  if (!Fits(words)) return VL_SUB_W(words, to, one, other);
  return Store(words, to, Load(words, one) - Load(words, other));
}

// Bits above the word's are cut off, as Verilator does.
TRIAXIS_INLINE WDataOutP ShiftLeftW(int bits, int from, int by_bits, WDataOutP to, const WDataInP value,
                                    IData by) {
  const int words = VL_WORDS_I(bits);
  if (!Fits(words) || by >= static_cast<IData>(bits)) return VL_SHIFTL_WWI(bits, from, by_bits, to, value, by);
  const int unused = kWideBits - bits;
  return Store(words, to, Load(words, value) << by << unused >> unused);
}

}  // namespace triaxis

#undef VL_LTS_IWW
#undef VL_GTS_IWW
#define VL_EXTENDS_II triaxis::ExtendII
#define VL_EXTENDS_QI triaxis::ExtendQI
#define VL_EXTENDS_QQ triaxis::ExtendQQ
#define VL_EXTENDS_WI triaxis::ExtendWI
#define VL_EXTENDS_WQ triaxis::ExtendWQ
#define VL_EXTENDS_WW triaxis::ExtendWW
#define VL_MULS_III triaxis::MultiplyI
#define VL_MULS_QQQ triaxis::MultiplyQ
#define VL_LTS_III triaxis::LessI
#define VL_LTS_IQQ triaxis::LessQ
#define VL_LTS_IWW triaxis::LessW
#define VL_GTS_III(bits, one, other) triaxis::LessI(bits, other, one)
#define VL_GTS_IQQ(bits, one, other) triaxis::LessQ(bits, other, one)
#define VL_GTS_IWW(bits, one, other) triaxis::LessW(bits, other, one)
#define VL_ADD_W triaxis::AddW
#define VL_SUB_W triaxis::SubtractW
#define VL_SHIFTL_WWI triaxis::ShiftLeftW

#endif  // TRIAXIS_SIM_ARITHMETIC_H_
