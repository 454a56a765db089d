// SPDX-License-Identifier: Apache-2.0
/// @file peer_formats.h
/// The binary files of the programs released with [Kim15] and [SK23]: polynomials (`.p4d`, `.poly4d`) and optimised
/// shapes (`.o3d`). They are little-endian, without a magic number or a version. Therefore every count is checked
/// against the file's length before anything is allocated, and a file must end exactly where its content does.
///
/// Quaternions are stored as w, x, y, z = A, B, C, D. The programs put world x into w, world y into x and world z into
/// y. Coefficients and derivatives, which the factored form does not need, are skipped whatever their values.
///
/// Functions that take bytes also take the file's @a name for their messages.
/// @throw DataError          the content is not such a file: it is truncated or too long, or has an impossible count,
///                           or a number that is not finite or beyond 1e9
/// @throw MissingInputError  the file does not exist, is a directory, or may not be opened
/// @throw IoError            reading failed midway
#pragma once

#include "julia/rational.h"

#include <array>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

namespace vdbtools {

/// The contents of an `.o3d`, without its three sampled fields.
struct OptimisedShape {
  std::array<int, 3> resolutions{};  ///< cells along x, y, z; at least 1
  std::array<double, 3> centre{};    ///< of the box, world units of that program
  std::array<double, 3> lengths{};   ///< full edges of the box, positive
  julia::Rational rational;          ///< its logScale is the natural logarithm of the stored e^C
};

/// Reads a `.p4d` or `.poly4d`, which holds exactly one polynomial.
julia::Polynomial readPolynomial(const std::filesystem::path& path);
julia::Polynomial polynomialFromP4d(std::string_view bytes, const std::string& name);

/// Checks only the lengths of the three fields. The whole file is held in memory meanwhile.
OptimisedShape readOptimisedShape(const std::filesystem::path& path);
OptimisedShape optimisedShapeFromO3d(std::string_view bytes, const std::string& name);

/// Returns the bytes of a `.p4d`, with empty coefficient arrays: the released programs evaluate only its factored form.
/// @throw std::invalid_argument  more than 2^31 - 1 roots, or a number that is not finite or beyond 1e9
std::string rationalToP4d(const julia::Polynomial& polynomial);

/// Returns the bytes of an `.o3d`, with empty coefficient arrays and history. Its three fields are sampled at the
/// centres of the box's cells, x fastest, and written unchanged: the field of the rational's orbit, the target's signed
/// distance, and the target's electrostatic potential ([Kim15] 4.4).
/// @throw std::invalid_argument  resolutions, a box or a rational that could not be read back; a field without exactly
///                               one value per cell; or an e^C that a double cannot hold in full precision, i.e. C
///                               beyond about 708
std::string optimisedShapeToO3d(const OptimisedShape& shape, std::span<const double> fractal,
                                std::span<const double> distance, std::span<const double> potential);

}  // namespace vdbtools
