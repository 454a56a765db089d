// SPDX-License-Identifier: Apache-2.0
#include "device/program_text.h"

#include "device/program_data.h"
#include "kernels/elementary.h"
#include "kernels/kernels.h"

#include "julia/orbit.h"
#include "julia/wave_versor.h"

#include <cinttypes>
#include <cstdio>
#include <limits>
#include <span>
#include <string_view>
#include <type_traits>

namespace julia::device {
namespace {

#include <device_text_bytes.h>  // kEmbedded

std::string_view textNamed(std::string_view name) {
  for (const EmbeddedBytes& text : kEmbedded)
    if (name == text.name) return {reinterpret_cast<const char*>(text.bytes), text.size};
  return {};
}

/// The exact text of a number in OpenCL C.
template <class Real>
std::string literal(Real value) {
  char text[64];
  std::snprintf(text, sizeof(text), std::is_same_v<Real, float> ? "%af" : "%a", static_cast<double>(value));
  return text;
}

void define(std::string& text, const char* name, const std::string& value) {
  text += std::string("#define ") + name + " (" + value + ")\n";
}

/// A polynomial by Horner's rule, as kernels::polynomial() computes it.
template <class Real>
void definePolynomial(std::string& text, const char* name, std::span<const Real> coefficients) {
  std::string sum = literal(coefficients[0]);
  for (const Real c : coefficients.subspan(1)) sum = "(" + sum + " * x + " + literal(c) + ")";
  text += std::string("inline Real polynomial_") + name + "(Real x) { return " + sum + "; }\n";
}

/// The words of kernels/language.h and the constants of Ieee<Real>.
template <class Real>
std::string words() {
  using I = kernels::Ieee<Real>;
  constexpr bool kFloats = std::is_same_v<Real, float>;
  std::string text = "#pragma OPENCL FP_CONTRACT OFF\n";
  text += kFloats ? "typedef float Real;\ntypedef uint Bits;\n"
                    "#define JULIA_TO_BITS(x) as_uint((Real)(x))\n#define JULIA_FROM_BITS(x) as_float((Bits)(x))\n"
                  : "typedef double Real;\ntypedef ulong Bits;\n"
                    "#define JULIA_TO_BITS(x) as_ulong((Real)(x))\n#define JULIA_FROM_BITS(x) as_double((Bits)(x))\n";
  text +=
      "#define JULIA_SHARED inline\n"
      "#define JULIA_SHARED_IN_DOUBLES inline\n"
      "#define JULIA_IEEE(name) name\n"
      "#define JULIA_POLYNOMIAL(name, x) polynomial_##name(x)\n"
      "#define JULIA_REAL(x) ((Real)(x))\n"
      "#define JULIA_INFINITY ((Real)INFINITY)\n"
      "#define JULIA_BITS Bits\n"
      "#define squareRoot(x) sqrt(x)\n";
  const auto bits = [](auto value) { return "(Bits)" + std::to_string(value) + (kFloats ? "u" : "ul"); };
  define(text, "kMantissaBits", std::to_string(I::kMantissaBits));
  define(text, "kMagnitude", bits(I::kMagnitude));
  define(text, "kExponentBits", bits(I::kExponentBits));
  define(text, "kBiasTwice", bits(I::kBiasTwice));
  define(text, "kSqrtHalf", bits(I::kSqrtHalf));
  define(text, "kRootGuess", bits(I::kRootGuess));
  define(text, "kRounder", literal(I::kRounder));
  define(text, "kLog2E", literal(I::kLog2E));
  define(text, "kLn2High", literal(I::kLn2High));
  define(text, "kLn2Low", literal(I::kLn2Low));
  define(text, "kLeastExponent", literal(I::kLeastExponent));
  define(text, "kMostExponent", literal(I::kMostExponent));
  define(text, "kTiny", literal(I::kTiny));
  define(text, "kHuge", literal(I::kHuge));
  define(text, "FIELD_LIMIT", literal(kFieldLimit));
  define(text, "STORED_FIELD_LIMIT", literal(static_cast<float>(kFieldLimit)));
  define(text, "LEAST_STORED", literal(std::numeric_limits<float>::min()));
  // Above this share of NEAR_SQUARED, a point has escaped, in whichever order squares are added.
  define(text, "BEYOND_NEAR", literal(1 + 64 * std::numeric_limits<Real>::epsilon()));
  define(text, "MOST_OCTAVE", literal(static_cast<Real>(kMostOctave)));
  definePolynomial<Real>(text, "kAtan", I::kAtan);
  definePolynomial<Real>(text, "kSin", I::kSin);
  definePolynomial<Real>(text, "kCos", I::kCos);
  definePolynomial<Real>(text, "kLog", I::kLog);
  definePolynomial<Real>(text, "kExp", I::kExp);
  const auto number = [&](const char* name, int value) { define(text, name, std::to_string(value)); };
  number("METHOD_PRODUCTS", static_cast<int>(kernels::PowerMethod::Products));
  number("METHOD_ANGLE", static_cast<int>(kernels::PowerMethod::Angle));
  number("MAP_SHAPE_MODULUS", static_cast<int>(MapKind::ShapeModulus));
  number("MAP_RATIONAL", static_cast<int>(MapKind::Rational));
  number("MAP_QUADRATIC", static_cast<int>(MapKind::Quadratic));
  number("MAP_CROSS", static_cast<int>(MapKind::Cross));
  number("MAP_TRIPLEX", static_cast<int>(MapKind::Triplex));
  number("VERSOR_NONE", static_cast<int>(VersorKind::None));
  number("VERSOR_VALUE", static_cast<int>(VersorKind::Value));
  number("VERSOR_TEXTURE", static_cast<int>(VersorKind::Texture));
  number("SLICE", kSlice);
  number("NEAR_SQUARED", kNearSquared);
  number("LOG_ESCAPE", kLogEscape);
  number("LOG_TRAP", kLogTrap);
  number("LEVEL", kLevel);
  number("CONSTANT", kConstant);
  number("SCALE", kScale);
  number("MOST_STEPS", kMostSteps);
  number("POWER", kPower);
  number("FROM_POLE", kFromPole);
  number("PAIR", kPair);
  number("LATTICES_AT", kLatticesAt);
  number("LATTICE_NUMBERS", kLatticeNumbers);
  number("LATTICE_BRICKS", kLatticeBricks);
  number("LATTICE_QUADRATIC", kLatticeQuadratic);
  number("LATTICE_PLACES", kLatticePlaces);
  number("LATTICE_VALUES", kLatticeValues);
  number("LATTICE_SIZE", kLatticeSize);
  number("NODES_AT", kNodesAt);
  number("NODE_NUMBERS", kNodeNumbers);
  number("NODE_INTEGERS", kNodeIntegers);
  number("NODE_COUNT", kNodeCount);
  number("NODE_LATTICE", kNodeLattice);
  number("NODE_SIZE", kNodeSize);
  number("SYMMETRY_AXIS", kSymmetryAxis);
  number("SYMMETRY_MIRRORED", kSymmetryMirrored);
  number("SYMMETRY_KALEIDOSCOPE", kSymmetryKaleidoscope);
  return text;
}

/// The angle of radians. It uses doubles even if Real is float, so only the programs of maps that need it contain it.
std::string radians(bool floats) {
  const std::string type = floats ? "float" : "double";
  return "#if MAP == MAP_CROSS\ninline " + type + " quadrantsOfRadians(" + type + " x) {\n" +
         std::string(textNamed(floats ? "quadrants_of_floats.h" : "quadrants_of_doubles.h")) +
         "}\n#else\ninline Real quadrantsOfRadians(Real x) { return x; }\n#endif\n";
}

}  // namespace

std::string programText(bool floats, const std::string& texture) {
  std::string text = floats ? words<float>() : words<double>();
  text += radians(floats);
  for (const char* name : {"elementary.h", "rational.h", "lattice.h", "waves.h", "versors.h", "cartesian.h"})
    text += std::string(textNamed(name)) + "\n";
  // Edges are searched in doubles, which a device need not have.
  text += "#if SEARCHES\n" + std::string(textNamed("search.h")) + "#endif\n";
  text += textNamed("versors.cl");
  text += texture;
  text += textNamed("orbit.cl");
  text += textNamed("rays.cl");
  return text;
}

}  // namespace julia::device
