// SPDX-License-Identifier: Apache-2.0
/// @file errors.h
/// The room `base` holds what every other room of vdbtools needs and includes none of them: the exceptions (here), the
/// interface for monitoring long work (monitor.h), fractal space (fractal_space.h), and a few private helpers.
///
/// The exceptions of vdbtools. Each message tells the user what was found and what to do about it, in terms of
/// quantities. The command line adds the names of its options, see Remedy. An option outside its domain is a
/// std::invalid_argument; a violated invariant of this library is a std::logic_error.
#pragma once

#include <stdexcept>
#include <string>

namespace vdbtools {

/// What would remedy an error. Each front end offers it under the names of its own options.
enum class Remedy {
  None,
  RepairMesh,        ///< RepairOptions
  SmallerIslands,    ///< IslandOptions::minSize
  KeepCrumbs,        ///< SurfaceOptions::crumbs
  LargerBeta,        ///< ExponentGridOptions::beta
  AnotherFieldBox,   ///< FractalFieldOptions::box
  SolidifySheet,     ///< MendOptions::solidify, MendOptions::thicken
  GivePointsRadius,  ///< MendOptions::pointsRadius
  FinerDistances,    ///< MeshToSdfOptions::voxelSize
  GiveIsovalue,      ///< VolumeOptions::isovalue
  TurnSign,          ///< VolumeOptions::invert
};

/// The input was read but cannot be used: it is truncated, leaky, empty, or not finite.
class DataError : public std::runtime_error {
 public:
  explicit DataError(const std::string& what, Remedy remedy = Remedy::None)
      : std::runtime_error(what), mRemedy(remedy) {}
  Remedy remedy() const { return mRemedy; }

 private:
  Remedy mRemedy;
};

/// The input does not exist, or it may not be opened.
class MissingInputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The output cannot be created at the requested place.
class CreateError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reading or writing failed midway, e.g. because of a full disk or a lost mount.
class IoError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The work was cancelled through its Monitor.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace vdbtools
