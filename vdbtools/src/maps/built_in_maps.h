// SPDX-License-Identifier: Apache-2.0
/// @file built_in_maps.h
/// The library's own maps, each from the file of its name.
#pragma once

#include "vdbtools/maps/map_registry.h"

namespace vdbtools {

MapRegistry::Descriptor shapeModulusMap(const VersorFunction& function);
MapRegistry::Descriptor rationalMap();
MapRegistry::Descriptor quadraticMap();
MapRegistry::Descriptor crossMap();
MapRegistry::Descriptor mandelbulbMap();

}  // namespace vdbtools
