// SPDX-License-Identifier: Apache-2.0
/// @file map_registry.h
/// The maps that a program knows, as a value: the command line, recipes and jobs are given one.
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

  /// nullptr if there is none of that name.
  const MapDescriptor* find(const std::string& name) const;
  const std::vector<Descriptor>& maps() const { return mMaps; }  ///< in the order in which they were added

  /// --map itself, whose default is the first map.
  OptionSpec option() const;
  /// The maps as variants of a table whose selector is that option.
  std::vector<OptionVariant> variants() const;

 private:
  std::vector<Descriptor> mMaps;
};

/// Directions at points, world units: three numbers a point, a vector in space, or four, a quaternion. Called in many
/// threads at once; the same point must always have the same direction.
using VersorFunction = std::function<std::vector<double>(std::span<const openvdb::Vec3d> points)>;

/// shape-modulus, rational, quadratic, cross and mandelbulb.
/// @param function  the program's own versor, which --texture function names; none: that is refused
MapRegistry builtInMaps(const VersorFunction& function = {});

/// docs/maps.md: the maps, what they need and their options, as Markdown.
std::string mapsPage(const MapRegistry& maps);

}  // namespace vdbtools
