// SPDX-License-Identifier: Apache-2.0
/// @file peer_formats.h
/// The binary files of the programs released with [Kim15] and [SK23]: polynomials (`.p4d`, `.poly4d`) and optimised
/// shapes (`.o3d`). They are little endian, without a magic number or a version; so every count is checked against the
/// file's length before anything is allocated, and a file must end exactly where its content does.
///
/// Quaternions are stored as w, x, y, z = A, B, C, D. The programs put world x into w, world y into x and world z into
/// y. Coefficients and derivatives, which the factored form does not need, are skipped whatever they hold.
///
/// Functions that take bytes also take @a name, the file's, for their messages.
/// @throw DataError          the content is not such a file: it is truncated or too long, or has an impossible count,
/// or
///                           a number that is not finite or beyond 1e9
/// @throw MissingInputError  there is no such file, it is a directory, or it may not be opened
/// @throw IoError            reading broke off
#pragma once

#include "julia/rational.h"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// What an `.o3d` holds, without its three sampled fields.
struct OptimisedShape {
  std::array<int, 3> resolutions{};  ///< cells along x, y, z; at least 1
  std::array<double, 3> centre{};    ///< of the box, world units of that program
  std::array<double, 3> lengths{};   ///< full edges of the box, positive
  julia::Rational rational;          ///< its logScale is the natural logarithm of the stored e^C
};

/// A `.p4d` or `.poly4d`: exactly one polynomial.
julia::Polynomial readPolynomial(const std::filesystem::path& path);
julia::Polynomial polynomialFromP4d(std::string_view bytes, const std::string& name);

/// Of the three fields only the lengths are checked. The whole file is held in memory meanwhile.
OptimisedShape readOptimisedShape(const std::filesystem::path& path);
OptimisedShape optimisedShapeFromO3d(std::string_view bytes, const std::string& name);

/// The bytes of a `.p4d`, with empty coefficient arrays: the released programs evaluate it in its factored form only.
/// @throw std::invalid_argument  more than 2^31 - 1 roots, or a number that is not finite or beyond 1e9
std::string rationalToP4d(const julia::Polynomial& polynomial);

/// The bytes of an `.o3d`, with empty coefficient arrays and history. Its three fields are sampled at the centres of
/// the box's cells, x fastest, and written as they are: the field of the rational's orbit, the target's signed
/// distance, and the target's electrostatic potential ([Kim15] 4.4).
/// @throw std::invalid_argument  resolutions, a box or a rational that could not be read back; a field of another size
///                               than one value for each cell; or an e^C that a double does not hold in full precision,
///                               which is so for C beyond about 708
std::string optimisedShapeToO3d(const OptimisedShape& shape, std::span<const double> fractal,
                                std::span<const double> distance, std::span<const double> potential);

}  // namespace vdbtools
