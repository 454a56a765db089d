// SPDX-License-Identifier: Apache-2.0
/// @file errors.h
/// The room `base` holds what every other room of vdbtools needs and includes none of them: the exceptions (here), the
/// seam to whoever watches long work (monitor.h), fractal space (fractal_space.h), and a few private helpers.
///
/// The exceptions of vdbtools. Each says, in words for the user, what was found and what to do about it, in terms of
/// quantities: the names of command-line options are the command line's to add, see Remedy. An option outside its
/// domain is a std::invalid_argument; a broken promise of our own is a std::logic_error.
#pragma once

#include <stdexcept>
#include <string>

namespace vdbtools {

/// What would help against an error, for whoever offers it under a name of their own.
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
};

/// The input was read, but cannot be used: truncated, leaky, empty, not finite.
class DataError : public std::runtime_error {
 public:
  explicit DataError(const std::string& what, Remedy remedy = Remedy::None)
      : std::runtime_error(what), mRemedy(remedy) {}
  Remedy remedy() const { return mRemedy; }

 private:
  Remedy mRemedy;
};

/// There is no such input, or it may not be opened.
class MissingInputError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The output cannot be created where it was asked for.
class CreateError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Reading or writing broke off: a full disk, a lost mount.
class IoError : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The work was cancelled through its Monitor.
class Interrupted : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace vdbtools
