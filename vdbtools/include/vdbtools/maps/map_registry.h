// SPDX-License-Identifier: Apache-2.0
/// @file map_registry.h
/// The maps that a program knows. The command line, recipes and jobs receive a registry as an argument.
#pragma once

#include "vdbtools/maps/map_descriptor.h"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

class MapRegistry {
 public:
  using Descriptor = std::shared_ptr<const MapDescriptor>;

  /// @throw std::invalid_argument  there is a map of that name already
  void add(Descriptor map);

  /// Returns nullptr if there is no map of that name.
  const MapDescriptor* find(const std::string& name) const;
  const std::vector<Descriptor>& maps() const { return mMaps; }  ///< in the order in which they were added

  /// The option --map. Its default is the first map.
  OptionSpec option() const;
  /// The maps as variants of a table whose selector is that option.
  std::vector<OptionVariant> variants() const;

 private:
  std::vector<Descriptor> mMaps;
};

/// Returns the directions at points, world units: three numbers per point for a vector in space, or four for a
/// quaternion. Many threads may call it at once; the same point must always get the same direction.
using VersorFunction = std::function<std::vector<double>(std::span<const openvdb::Vec3d> points)>;

/// The maps shape-modulus, rational, quadratic, cross and mandelbulb.
/// @param function  the calling program's own versor, which --texture function selects; if empty, that texture is
///                  refused
MapRegistry builtInMaps(const VersorFunction& function = {});

/// The page docs/maps.md: the maps, what they need and their options, as Markdown.
std::string mapsPage(const MapRegistry& maps);

}  // namespace vdbtools
