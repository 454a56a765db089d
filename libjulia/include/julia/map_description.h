// SPDX-License-Identifier: Apache-2.0
/// @file map_description.h
/// A map as a plain value, from which another back end could compute it: a shader, say, with the roots and powers as
/// its uniforms and the bricks of the exponent as a texture.
#pragma once

#include <any>

namespace julia {

/// Empty where a map cannot be described. Otherwise its type tells the kind of map:
///
/// | map                                   | type of its description |
/// |---------------------------------------|-------------------------|
/// | ShapeModulus (shape_modulus.h)        | ShapeModulusDescription |
/// | RationalMap (rational_map.h)          | Rational                |
/// | q^2 + c (quadratic_map.h)             | QuadraticDescription    |
/// | CrossMap (cross_map.h)                | CrossOptions            |
/// | Mandelbulb (mandelbulb.h)             | MandelbulbOptions       |
///
/// The set is open: a map from elsewhere describes itself by a type of its own. Numbers are those that the map was made
/// from; a map in floats rounds them first.
using MapDescription = std::any;

}  // namespace julia
