// SPDX-License-Identifier: Apache-2.0
/// @file map_description.h
/// A map as a plain value, from which another back end could compute it, e.g. a shader with the roots and powers as its
/// uniforms and the bricks of the exponent as a texture.
#pragma once

#include <any>

namespace julia {

/// Empty if a map cannot be described. Otherwise its type tells the kind of map:
///
/// | map                                   | type of its description |
/// |---------------------------------------|-------------------------|
/// | ShapeModulus (shape_modulus.h)        | ShapeModulusDescription |
/// | RationalMap (rational_map.h)          | Rational                |
/// | q^2 + c (quadratic_map.h)             | QuadraticDescription    |
/// | CrossMap (cross_map.h)                | CrossOptions            |
/// | Mandelbulb (mandelbulb.h)             | MandelbulbOptions       |
///
/// The set is open: other maps may describe themselves by types of their own. The numbers are those from which the map
/// was made; a map in floats rounds them first.
using MapDescription = std::any;

}  // namespace julia
