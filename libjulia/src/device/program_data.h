// SPDX-License-Identifier: Apache-2.0
/// @file program_data.h
/// What a device is given of a field: the program's switches, and the numbers from which it computes. They are those of
/// the processor's evaluators, rounded to the same type by the same code.
#pragma once

#include "julia/bricks.h"
#include "julia/evaluator.h"

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace julia::device {

/// Values of the program's word MAP. From Quadratic on, the steps are Cartesian.
enum class MapKind { ShapeModulus, Rational, Quadratic, Cross, Triplex };
/// Values of the program's word VERSOR: how the iterate that follows is formed.
enum class VersorKind {
  None,   ///< it is the map's value
  Value,  ///< of the map's value, by its length
  Roots,
  Waves,
};

/// Places in ProgramData::numbers.
enum Number {
  kSlice,
  kNearSquared,
  kLogEscape,
  kLogTrap,
  kLevel,                    ///< F = l - level
  kExponent,                 ///< the lattice of E: matrix, offset, low, high
  kOctave = kExponent + 18,  ///< the lattice of the octave
  kConstant = kOctave + 18,  ///< the map's constant, or the origin of waves
  kScale = kConstant + 4,    ///< ln of a rational's scale, or the power of a triplex number
  kList = 48,                ///< roots, each with its power, or waves: frequency, cosine, sine
};
/// Places in ProgramData::integers.
enum Integer {
  kMostSteps,
  kCount,           ///< of roots, or of factors of waves; of a triplex number the power by products, or 0
  kExponentBricks,  ///< along y and z
  kExponentQuadratic = kExponentBricks + 2,
  kOctaveBricks,
  kOctaveQuadratic = kOctaveBricks + 2,
  kFromPole,
  kPair,
  kIntegerList = 16,  ///< roots: method, power, whether to renormalise; factors: first, end, power, sign
};

/// A field for a device.
struct ProgramData {
  MapKind map = MapKind::ShapeModulus;
  VersorKind versor = VersorKind::Roots;
  bool floats = false;
  int dropped = 2;           ///< 0, 1, 2: the components i, j, k
  bool traps = false;        ///< whether orbits end in the trap
  bool ownConstant = false;  ///< the constant of each orbit is its first point
  bool fixedFactor = false;  ///< scheme (3) of [ZB25]
  bool needsDoubles = false;
  double level = 0;
  std::variant<std::vector<float>, std::vector<double>> numbers;
  std::vector<std::int32_t> integers;
  std::shared_ptr<const Bricks> exponent, octave;  ///< nullptr if the map reads none

  /// The values of the program's words, for the compiler of the device.
  /// @param searches  whether the program searches edges, which takes doubles
  std::string switches(bool searches) const;
};

/// The data of a field, or in @a reason why it has none: its map, its texture or its options are for the processor
/// alone.
std::unique_ptr<const ProgramData> programDataOf(const FieldDescription& field, std::string& reason);

}  // namespace julia::device
