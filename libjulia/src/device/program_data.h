// SPDX-License-Identifier: Apache-2.0
/// @file program_data.h
/// The data of a field that a device receives: the switches of its program, and the numbers from which it computes.
/// The processor's evaluators use the same numbers, rounded to the same type by the same code.
#pragma once

#include "julia/bricks.h"
#include "julia/evaluator.h"

#include <cstdint>
#include <memory>
#include <string>
#include <variant>
#include <vector>

namespace julia::device {

/// Values of the program's macro MAP. From Quadratic on, the steps are Cartesian.
enum class MapKind { ShapeModulus, Rational, Quadratic, Cross, Triplex };
/// Values of the program's macro VERSOR: how the next iterate is formed.
enum class VersorKind {
  None,     ///< it is the map's value
  Value,    ///< its versor is the map's value divided by its length
  Texture,  ///< its versor is the field's texture, whose functions are in ProgramData::texture
};

/// Places in ProgramData::numbers. The lists of lattices and nodes follow.
enum Number {
  kSlice,
  kNearSquared,
  kLogEscape,
  kLogTrap,
  kLevel,                  ///< F = l - level
  kConstant,               ///< the map's constant
  kScale = kConstant + 4,  ///< ln of a rational's scale, or the power of a triplex number
  kNumbersList,
};
/// Places in ProgramData::integers. The lists of nodes follow, and then the records of lattices and nodes.
enum Integer {
  kMostSteps,
  kPower,  ///< of a triplex number by products, or 0
  kFromPole,
  kPair,
  kLatticesAt,  ///< where the records of the lattices begin
  kNodesAt,     ///< where the records of the nodes begin
  kIntegersList,
};
/// The record of a lattice of bricks. Number 0 is the exponent's.
enum LatticeRecord {
  kLatticeNumbers,  ///< the place of its numbers: matrix, offset, low, high, and at and more of its knee
  kLatticeBricks,   ///< how many there are along y and z
  kLatticeQuadratic = kLatticeBricks + 2,
  kLatticePlaces,  ///< where its bricks' places begin
  kLatticeValues,  ///< where its values begin: the lower 31 bits, and the others
  kLatticeSize = kLatticeValues + 2,
};
/// The record of a node of a texture, which is a tree of versors. Children come before their parents, and the last node
/// is the texture.
///
/// | node      | numbers                             | integers                                | count      |
/// |-----------|-------------------------------------|-----------------------------------------|------------|
/// | roots     | each root with its power            | method, power, whether to renormalise   | roots      |
/// | waves     | origin; frequency, cosine, sine     | of each factor first, end, power, sign  | factors    |
/// | grain     | frequency, cosine, sine             | as waves                                | factors    |
/// | fields    |                                     |                                         | components |
/// | moved     | by what, scale                      |                                         |            |
/// | symmetric | centre; cosine and sine of each turn| axis, mirrored axes, kaleidoscope       | turns      |
/// | mixed     |                                     |                                         |            |
enum NodeRecord {
  kNodeNumbers,
  kNodeIntegers,
  kNodeCount,
  kNodeLattice,  ///< the first lattice that it reads
  kNodeSize,
};
/// Integers of a symmetric node.
enum SymmetryInteger { kSymmetryAxis, kSymmetryMirrored, kSymmetryKaleidoscope };

/// A field for a device.
struct ProgramData {
  MapKind map = MapKind::ShapeModulus;
  VersorKind versor = VersorKind::None;
  bool floats = false;
  int dropped = 2;           ///< 0, 1, 2: the components i, j, k
  bool traps = false;        ///< whether orbits end in the trap
  bool ownConstant = false;  ///< the constant of each orbit is its first point
  bool fixedFactor = false;  ///< scheme (3) of [ZB25]
  bool needsDoubles = false;
  double level = 0;
  std::variant<std::vector<float>, std::vector<double>> numbers;
  std::vector<std::int32_t> integers;
  std::vector<std::shared_ptr<const Bricks>> bricks;  ///< of the lattices, each of them once
  std::string texture;                                ///< the functions of the texture's nodes, in OpenCL C

  /// The values of the program's words, for the compiler of the device.
  /// @param searches  whether the program searches edges, which takes doubles
  std::string switches(bool searches) const;
};

/// Returns the data of a field. If only the processor can evaluate its map, its texture or its options, returns nullptr
/// and sets @a reason.
std::unique_ptr<const ProgramData> programDataOf(const FieldDescription& field, std::string& reason);

}  // namespace julia::device
