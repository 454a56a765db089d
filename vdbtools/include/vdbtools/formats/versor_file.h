// SPDX-License-Identifier: Apache-2.0
/// @file versor_file.h
/// Quaternion rationals, and textures of waves, in files: the versors of the shape modulus. The project's own format is
/// JSON, with one root on each line:
///
///   {
///     "juliavdb": "rational",
///     "version": 1,
///     "note": "how it was made",
///     "logScale": 0,
///     "top": {
///       "powerScale": 1,
///       "roots": [
///         {"position": [0.5, 0, -1, 0], "power": 2}
///       ]
///     },
///     "bottom": {"powerScale": 1, "roots": []},
///     "target": {"centre": [0, 0, 0], "scale": 1, "box": [-0.5, -0.5, -0.5, 0.5, 0.5, 0.5]}
///   }
///
/// All keys except "note" and "target" are required, and no others are allowed. "target" belongs to a map that was
/// fitted to a shape: the space of its roots, and the shape's box, both in world units. "position" is [A, B, C, D] in
/// units of the map's space, and "logScale" is the C of e^C. Numbers are read back as exactly the doubles that were
/// written.
///
/// A texture of waves (julia/wave_versor.h) has one factor after the other:
///
///   {
///     "juliavdb": "waves",
///     "version": 1,
///     "note": "how it was made",
///     "factors": [
///       {"power": 1, "waves": [
///         {"frequency": [0.5, 0, 0, 0], "cosine": [1, 0, 0, 0], "sine": [0, 1, 0, 0]}
///       ]}
///     ]
///   }
///
/// "frequency" is [X, Y, Z, W]: cycles per unit along the axes of the target and along the fourth component, where the
/// octave is 0. "cosine" and "sine" are the amplitudes, [A, B, C, D].
///
/// All functions that read may throw:
/// @throw DataError              the content is not such a file; the message says where
/// @throw MissingInputError      the file does not exist, is a directory, or may not be opened
/// @throw IoError                reading failed midway
#pragma once

#include "vdbtools/base/fractal_space.h"

#include "julia/rational.h"
#include "julia/wave_versor.h"

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>

namespace vdbtools {

/// The shape that a rational map was fitted to.
struct FittedTo {
  FractalSpace space;
  openvdb::BBoxd box;  ///< bounds of the shape, world units
};

struct RationalFile {
  julia::Rational rational;
  std::string note;  ///< free text, such as the recipe; empty if the file has none
  std::optional<FittedTo> target;
};

/// Reads a rational according to the extension, ignoring case: `.json` as above; `.p4d` or `.poly4d`, whose polynomial
/// becomes the top; or `.o3d`.
/// @throw std::invalid_argument  any other extension
julia::Rational readRational(const std::filesystem::path& path);
RationalFile readRationalFile(const std::filesystem::path& path);

/// @param nameForErrors  the file's name
RationalFile rationalFileFromJson(std::string_view text, const std::string& nameForErrors);

/// @param note  left out if empty; bytes that are not UTF-8 become U+FFFD
/// @throw std::invalid_argument  a number is not finite, a number of the rational is beyond 1e9, or the target has no
///                               extent
std::string rationalToJson(const julia::Rational& rational, std::string_view note = {},
                           const std::optional<FittedTo>& target = {});

/// A texture of waves that is not placed yet: its frequencies are along the axes of the target.
struct WaveFile {
  julia::WaveTexture waves;
  std::string note;
};

/// @throw DataError  also for waves that julia::requireValid() refuses
WaveFile readWaveFile(const std::filesystem::path& path);
WaveFile waveFileFromJson(std::string_view text, const std::string& nameForErrors);
/// @param note  as for rationalToJson(). @throw std::invalid_argument  as julia::requireValid()
std::string wavesToJson(const julia::WaveTexture& waves, std::string_view note = {});

/// Reads either, whichever the file holds. @throw as readRationalFile() and readWaveFile()
std::variant<RationalFile, WaveFile> readVersorFile(const std::filesystem::path& path);

}  // namespace vdbtools
