// SPDX-License-Identifier: Apache-2.0
// From the C library this file uses only what IEEE 754 fixes: square roots, fused multiply-add, integers, and powers of
// two.
#include "julia/elementary.h"

#include "kernels/elementary.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>

namespace julia::elementary {
namespace {

using Double = kernels::Ieee<double>;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kPi = std::numbers::pi, kQuarter = std::numbers::pi / 2;

/// An unevaluated sum with about 106 bits. Function names follow [T. J. Dekker, A floating-point technique for
/// extending the available precision, 1971].
struct Pair {
  double high = 0, low = 0;
};

/// @pre |a| >= |b|, or a = 0
Pair fastSum(double a, double b) {
  const double high = a + b;
  return {high, b - (high - a)};
}

Pair sum(double a, double b) {
  const double high = a + b, part = high - a;
  return {high, (a - (high - part)) + (b - part)};
}

Pair product(double a, double b) {
  const double high = a * b;
  return {high, std::fma(a, b, -high)};
}

Pair product(const Pair& a, const Pair& b) {
  const Pair both = product(a.high, b.high);
  return fastSum(both.high, both.low + (a.high * b.low + a.low * b.high));
}

/// x = 2^exponent mantissa.
struct Split {
  double mantissa;  ///< sqrt(1/2) to sqrt(2)
  int exponent;
};

/// @pre x is finite and above 0
Split splitExponent(double x) {
  int exponent = 0;
  const double half = std::frexp(x, &exponent);  // 1/2 to 1
  return half < std::numbers::sqrt2 / 2 ? Split{2 * half, exponent - 1} : Split{half, exponent};
}

/// ln m for m from sqrt(1/2) to sqrt(2), with a relative error of about 2^-64.
Pair logOfMantissa(double m) {
  // ln m = 2 artanh s = 2 s (1 + z/3 + z^2/5 + ...), z = s^2 <= 0.0295.
  const double f = m - 1;
  const Pair d = sum(m, 1);
  const double quotient = f / d.high;
  const Pair s{quotient, (std::fma(-quotient, d.high, f) - quotient * d.low) / d.high};
  const Pair z = product(s, s);
  constexpr Pair kThird{0x1.5555555555555p-2, 0x1.5555555555555p-56};
  constexpr double kSeries[] = {1. / 27, 1. / 25, 1. / 23, 1. / 21, 1. / 19, 1. / 17,
                                1. / 15, 1. / 13, 1. / 11, 1. / 9,  1. / 7,  1. / 5};
  const double rest = kernels::polynomial(kSeries, z.high);
  const Pair tail = fastSum(kThird.high, rest * z.high + kThird.low);
  const Pair more = product(s, product(z, tail));
  const Pair half = fastSum(s.high, more.high);
  return {2 * half.high, 2 * (half.low + (s.low + more.low))};
}

/// ln x, with a relative error of about 2^-64. @pre x is finite and above 0
Pair logOf(double x) {
  const Split parts = splitExponent(x);
  const Pair mantissa = logOfMantissa(parts.mantissa);
  // The first product is exact, and larger than the other summand unless it is 0.
  const Pair whole = fastSum(parts.exponent * Double::kLn2High, mantissa.high);
  return fastSum(whole.high, whole.low + (mantissa.low + parts.exponent * Double::kLn2Low));
}

/// The logarithm of an x that is not both finite and above 0.
double specialLog(double x) { return x == 0 ? -kInfinite : x < 0 ? kNaN : x; }
bool isRegular(double x) { return x > 0 && x < kInfinite; }

/// 2^exponent times a pair close to 1.
struct Scaled {
  Pair value{1, 0};
  int exponent = 0;

  double rounded() const { return std::ldexp(value.high + value.low, exponent); }
};

/// e^r for |r| <= ln(2)/2 or slightly more, with an error of about 2^-60.
Pair expOfRest(const Pair& r) {
  constexpr double kSeries[] = {2. / 1307674368000, 2. / 87178291200, 2. / 6227020800, 2. / 479001600, 2. / 39916800,
                                2. / 3628800,       2. / 362880,      2. / 40320,      2. / 5040,      2. / 720,
                                2. / 120,           2. / 24,          2. / 6};
  const double rest = r.high * kernels::polynomial(kSeries, r.high);  // the factor of r^2 / 2
  const Pair square = product(r.high, r.high);
  const Pair first = fastSum(1, r.high), second = fastSum(first.high, square.high / 2);
  const double small = square.low / 2 + square.high / 2 * rest + r.low * (1 + r.high);
  return fastSum(second.high, second.low + (first.low + small));
}

/// e^x; 0 on underflow, or more than the largest number on overflow. @pre not NaN
Scaled expOf(const Pair& x) {
  constexpr double kBeyond = 800;
  if (!(std::abs(x.high) < kBeyond)) return {{1, 0}, x.high < 0 ? -5000 : 5000};
  const double n = std::floor(x.high * std::numbers::log2e + 0.5);
  const double leading = x.high - n * Double::kLn2High;  // exact
  return {expOfRest(sum(leading, x.low - n * Double::kLn2Low)), static_cast<int>(n)};
}

/// m^n by repeated squaring. @pre m is from sqrt(1/2) to sqrt(2), and n at most 1024
Pair wholePower(double m, int n) {
  Pair result{1, 0}, square{m, 0};
  for (int rest = std::abs(n); rest != 0; rest >>= 1) {
    if (rest & 1) result = product(result, square);
    if (rest > 1) square = product(square, square);
  }
  if (n >= 0) return result;
  const double inverse = 1 / result.high;
  return fastSum(inverse, (std::fma(-inverse, result.high, 1) - inverse * result.low) / result.high);
}

/// The bits of 2/pi after the binary point.
constexpr std::uint32_t kTwoOverPi[] = {
    0xa2f9836e, 0x4e441529, 0xfc2757d1, 0xf534ddc0, 0xdb629599, 0x3c439041, 0xfe5163ab, 0xdebbc561,
    0xb7246e3a, 0x424dd2e0, 0x06492eea, 0x09d1921c, 0xfe1deb1c, 0xb129a73e, 0xe88235f5, 0x2ebb4484,
    0xe99c7026, 0xb45f7e41, 0x3991d639, 0x835339f4, 0x9c845f8b, 0xbdf9283b, 0x1ff897ff, 0xde05980f,
    0xef2f118b, 0x5a0a6d1f, 0x6d367ecf, 0x27cb09b7, 0x4f463f66, 0x9e5fea2d, 0x7527bac7, 0xebe5f17b,
    0x3d0739f7, 0x8a5292ea, 0x6bfb5fb1, 0x1f8d5d08, 0x56033046, 0xfc7b6bab, 0xf0cfbc20, 0x9af4361d};

/// The 32 bits of 2/pi that begin at bit @a first; the bits before the point are 0.
std::uint64_t bitsOfTwoOverPi(int first) {
  const int word = first >> 5, shift = first & 31;
  const auto at = [](int i) { return i < 0 ? 0 : std::uint64_t{kTwoOverPi[i]}; };
  return (at(word) << 32 | at(word + 1)) >> (32 - shift) & 0xffffffff;
}

/// An angle: a quarter turn times (number + rest), with |rest| <= 1/2 or slightly more.
struct Quarters {
  unsigned number;  ///< modulo 4
  double rest;
};

/// @pre 1/2 <= x < infinity; for small x the bits of 2/pi begin before the point
Quarters quartersBeyondHalf(double x) {
  // x is an integer below 2^53 times 2^k. Bits of 2/pi that are worth 4 or more after multiplication by 2^k make whole
  // turns; 192 of the other bits suffice.
  constexpr std::size_t kWords = 6;
  int exponent = 0;
  const auto whole = static_cast<std::uint64_t>(std::ldexp(std::frexp(x, &exponent), 53));
  const std::array<std::uint64_t, 2> factor{whole & 0xffffffff, whole >> 32};
  std::array<std::uint64_t, kWords> turns{};  // from the last word to the first
  for (std::size_t i = 0; i < kWords; ++i) {
    const std::uint64_t bits = bitsOfTwoOverPi(exponent - 53 - 2 + 32 * static_cast<int>(kWords - 1 - i));
    std::uint64_t carry = 0;
    for (std::size_t j = 0; i + j < kWords; ++j) {
      carry += turns[i + j] + (j < factor.size() ? bits * factor[j] : 0);
      turns[i + j] = carry & 0xffffffff;
      carry >>= 32;
    }
  }
  // Round to the nearest quarter; its number is in the first word's upper two bits.
  constexpr std::uint64_t kHalf = 0x20000000;
  turns.back() += kHalf;
  const auto number = static_cast<unsigned>(turns.back() >> 30 & 3);
  std::uint64_t first = turns.back() & 0x3fffffff;
  const bool isNegative = first < kHalf;
  std::uint64_t carry = 1;
  for (std::size_t i = 0; isNegative && i + 1 < kWords; ++i) {
    carry += ~turns[i] & 0xffffffff;
    turns[i] = carry & 0xffffffff;
    carry >>= 32;
  }
  first = isNegative ? kHalf - first - 1 + carry : first - kHalf;
  double rest = 0;
  for (std::size_t i = 0; i + 1 < kWords; ++i) rest = (rest + static_cast<double>(turns[i])) * 0x1p-32;
  rest = (static_cast<double>(first) + rest) * 0x1p-30;
  return {number, isNegative ? -rest : rest};
}

/// @pre x is finite
Quarters quartersOf(double x) {
  if (std::abs(x) <= kQuarter / 2) return {0, x / kQuarter};
  const Quarters positive = quartersBeyondHalf(std::abs(x));
  return x > 0 ? positive : Quarters{0 - positive.number, -positive.rest};
}

struct SineCosine {
  double sine, cosine;
};

SineCosine sineCosine(double x) {
  if (!std::isfinite(x)) return {kNaN, kNaN};
  const Quarters angle = quartersOf(x);
  double sine = 0, cosine = 0;
  kernels::sineCosine(angle.rest, &sine, &cosine);
  switch (angle.number & 3) {
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    case 3: return {-cosine, sine};
    default: return {sine, cosine};
  }
}

/// From here on e^-x is negligible compared with e^x.
constexpr double kOneSided = 22;

/// e^x / 2, which may be finite when e^x is not.
double halfExp(double x) {
  Scaled result = expOf({x, 0});
  --result.exponent;
  return result.rounded();
}

}  // namespace

double log(double x) {
  if (!isRegular(x)) return specialLog(x);
  const Pair result = logOf(x);
  return result.high + result.low;
}

double log2(double x) {
  if (!isRegular(x)) return specialLog(x);
  constexpr Pair kLog2E{0x1.71547652b82fep+0, 0x1.777d0ffda0d24p-56};
  const Split parts = splitExponent(x);
  const Pair mantissa = product(logOfMantissa(parts.mantissa), kLog2E);
  const Pair result = fastSum(parts.exponent, mantissa.high);
  return result.high + (result.low + mantissa.low);
}

double log10(double x) {
  if (!isRegular(x)) return specialLog(x);
  constexpr Pair kLog10E{0x1.bcb7b1526e50ep-2, 0x1.95355baaafad3p-57};
  const Pair result = product(logOf(x), kLog10E);
  return result.high + result.low;
}

double log1p(double x) {
  if (x == 0) return x;
  if (!(x > -1 && x < kInfinite)) return specialLog(1 + x);
  const Pair whole = sum(1, x);
  const Pair result = logOf(whole.high);
  return result.high + (result.low + whole.low / whole.high);
}

double exp(double x) { return std::isnan(x) ? x : expOf({x, 0}).rounded(); }

double exp2(double x) {
  constexpr double kBeyond = 2000;
  if (std::isnan(x)) return x;
  const double limited = std::clamp(x, -kBeyond, kBeyond), n = std::floor(limited + 0.5);
  constexpr Pair kLn2{0x1.62e42fefa39efp-1, 0x1.abc9e3b39803fp-56};
  return Scaled{expOfRest(product({limited - n, 0}, kLn2)), static_cast<int>(n)}.rounded();
}

double expm1(double x) {
  constexpr double kSmall = 0.34, kFar = 60;
  if (std::isnan(x) || x == 0) return x;
  if (std::abs(x) < kSmall) return x + x * x * kernels::polynomial(Double::kExp, x);
  if (x > kFar) return exp(x);
  if (x < -kFar) return -1;
  const Scaled e = expOf({x, 0});
  return (std::ldexp(e.value.high, e.exponent) - 1) + std::ldexp(e.value.low, e.exponent);
}

double pow(double x, double y) {
  if (y == 0 || x == 1) return 1;
  if (y == 2) return x * x;  // the most frequent case, with the same result
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  const bool isWhole = y == std::floor(y);  // an infinite one too
  const bool isOdd = isWhole && std::fmod(y, 2) != 0 && std::isfinite(y);
  if (std::isinf(y)) return std::abs(x) == 1 ? 1 : (std::abs(x) > 1) == (y > 0) ? kInfinite : 0;
  if (x == 0 || std::isinf(x)) {
    const double size = (x == 0) == (y > 0) ? 0 : kInfinite;
    return isOdd ? std::copysign(size, x) : size;
  }
  if (x < 0 && !isWhole) return kNaN;
  const double sign = x < 0 && isOdd ? -1 : 1;
  constexpr double kMostByProducts = 1024, kBeyond = 800;
  if (isWhole && std::abs(y) <= kMostByProducts) {
    const Split parts = splitExponent(std::abs(x));
    const auto n = static_cast<int>(y);
    return sign * Scaled{wholePower(parts.mantissa, n), parts.exponent * n}.rounded();
  }
  const Pair logarithm = logOf(std::abs(x));
  if (!(std::abs(y * logarithm.high) < kBeyond)) return sign * exp(y * logarithm.high);
  const Pair exponent = product(y, logarithm.high);
  return sign * expOf({exponent.high, exponent.low + y * logarithm.low}).rounded();
}

double cbrt(double x) {
  if (x == 0 || !std::isfinite(x)) return x;
  const Split parts = splitExponent(std::abs(x));
  const int thirds = static_cast<int>(std::floor(parts.exponent / 3.));
  const double size = std::ldexp(parts.mantissa, parts.exponent - 3 * thirds);
  const double root = kernels::exponential(kernels::logarithm(size) / 3);
  // A Newton step, with the cube in 106 bits.
  const Pair cube = product(product(root, root), {root, 0});
  const double better = root - ((cube.high - size) + cube.low) / (3 * root * root);
  return std::copysign(std::ldexp(better, thirds), x);
}

double hypot(double x, double y) { return hypot(x, y, 0); }

double hypot(double x, double y, double z) {
  const double most = std::max({std::abs(x), std::abs(y), std::abs(z)});
  if (std::isinf(x) || std::isinf(y) || std::isinf(z)) return kInfinite;
  if (std::isnan(x) || std::isnan(y) || std::isnan(z)) return kNaN;
  if (most == 0) return 0;
  const int exponent = std::ilogb(most);
  const auto square = [&](double value) {
    const double near = std::scalbn(value, -exponent);
    return near * near;
  };
  return std::scalbn(std::sqrt(square(x) + square(y) + square(z)), exponent);
}

double sin(double x) { return x == 0 ? x : sineCosine(x).sine; }
double cos(double x) { return sineCosine(x).cosine; }
double tan(double x) {
  if (x == 0) return x;
  const SineCosine parts = sineCosine(x);
  return parts.sine / parts.cosine;
}

double atan2(double y, double x) {
  if (std::isnan(x) || std::isnan(y)) return kNaN;
  const double across = std::abs(x), up = std::abs(y);
  constexpr double kSteep = 0x1p60;  // the smaller of the two is negligible
  double angle = 0;
  if (std::isinf(x) && std::isinf(y)) {
    angle = x > 0 ? kQuarter / 2 : 3 * (kQuarter / 2);
  } else if (up == 0 || across / kSteep > up || std::isinf(x)) {
    angle = std::signbit(x) ? kPi : across == 0 ? 0 : up / across;
  } else if (up / kSteep > across || std::isinf(y)) {
    angle = kQuarter;
  } else {
    const int exponent = std::ilogb(std::max(across, up));
    double inverse = 0;
    angle = kernels::angleInQuadrants(std::scalbn(x, -exponent), std::scalbn(up, -exponent), &inverse) * kQuarter;
  }
  return std::copysign(angle, y);
}

double atan(double x) { return atan2(x, 1); }
double asin(double x) { return std::abs(x) <= 1 ? atan2(x, std::sqrt((1 - x) * (1 + x))) : kNaN; }
double acos(double x) { return std::abs(x) <= 1 ? atan2(std::sqrt((1 - x) * (1 + x)), x) : kNaN; }

double sinh(double x) {
  const double size = std::abs(x);
  if (size > kOneSided) return std::copysign(halfExp(size), x);
  const double e = expm1(size);
  return std::copysign(0.5 * (e + e / (e + 1)), x);
}

double cosh(double x) {
  const double size = std::abs(x);
  if (size > kOneSided) return halfExp(size);
  const double e = exp(size);
  return 0.5 * e + 0.5 / e;
}

double tanh(double x) {
  const double size = std::abs(x);
  if (size > kOneSided) return std::copysign(1, x);
  const double e = expm1(2 * size);
  return std::copysign(e / (e + 2), x);
}

}  // namespace julia::elementary
