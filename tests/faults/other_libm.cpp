// SPDX-License-Identifier: Apache-2.0
/// @file other_libm.cpp
/// A library to be preloaded, which stands for another C library: functions whose last bits IEEE 754 leaves open give
/// another last bit. Results of few digits stay, for every library has those right: exp(0), log2(8).
#include <dlfcn.h>

#include <bit>
#include <cmath>
#include <cstdint>

namespace {

double otherwise(double x) {
  constexpr std::uint64_t kLastDigits = 0xfffff;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  return std::isfinite(x) && (bits & kLastDigits) != 0 ? std::bit_cast<double>(bits ^ 1) : x;
}

float otherwise(float x) {
  constexpr std::uint32_t kLastDigits = 0xff;
  const auto bits = std::bit_cast<std::uint32_t>(x);
  return std::isfinite(x) && (bits & kLastDigits) != 0 ? std::bit_cast<float>(bits ^ 1) : x;
}

long double otherwise(long double x) {
  // A result of few digits is a float.
  const bool isExact = x == static_cast<long double>(static_cast<float>(x));
  return std::isfinite(x) && !isExact ? x * (1 + 0x1p-63L) : x;
}

template <class Function>
Function* next(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

}  // namespace

extern "C" {

#define OTHER_ONE(type, name)                             \
  type name(type x) {                                     \
    static const auto function = next<type(type)>(#name); \
    return otherwise(function(x));                        \
  }
#define OTHER_TWO(type, name)                                   \
  type name(type x, type y) {                                   \
    static const auto function = next<type(type, type)>(#name); \
    return otherwise(function(x, y));                           \
  }
#define OTHER_SINCOS(type, name)                                        \
  void name(type x, type* sine, type* cosine) {                         \
    static const auto function = next<void(type, type*, type*)>(#name); \
    function(x, sine, cosine);                                          \
    *sine = otherwise(*sine);                                           \
    *cosine = otherwise(*cosine);                                       \
  }
#define OTHER(one, name) one(double, name) one(float, name##f) one(long double, name##l)

OTHER(OTHER_ONE, acos)
OTHER(OTHER_ONE, acosh)
OTHER(OTHER_ONE, asin)
OTHER(OTHER_ONE, asinh)
OTHER(OTHER_ONE, atan)
OTHER(OTHER_ONE, atanh)
OTHER(OTHER_ONE, cbrt)
OTHER(OTHER_ONE, cos)
OTHER(OTHER_ONE, cosh)
OTHER(OTHER_ONE, erf)
OTHER(OTHER_ONE, erfc)
OTHER(OTHER_ONE, exp)
OTHER(OTHER_ONE, exp2)
OTHER(OTHER_ONE, exp10)
OTHER(OTHER_ONE, expm1)
OTHER(OTHER_ONE, lgamma)
OTHER(OTHER_ONE, log)
OTHER(OTHER_ONE, log10)
OTHER(OTHER_ONE, log1p)
OTHER(OTHER_ONE, log2)
OTHER(OTHER_ONE, sin)
OTHER(OTHER_ONE, sinh)
OTHER(OTHER_ONE, tan)
OTHER(OTHER_ONE, tanh)
OTHER(OTHER_ONE, tgamma)
OTHER(OTHER_TWO, atan2)
OTHER(OTHER_TWO, hypot)
OTHER(OTHER_TWO, pow)
OTHER(OTHER_SINCOS, sincos)

}  // extern "C"
