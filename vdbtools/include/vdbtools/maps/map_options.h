// SPDX-License-Identifier: Apache-2.0
/// @file map_options.h
/// The options that several maps share: the orbit, the slice through the quaternions, and roots. A map lists those that
/// it takes among its own.
#pragma once

#include "vdbtools/base/grids.h"
#include "vdbtools/maps/map_descriptor.h"
#include "vdbtools/maps/texture_shelf.h"

#include "julia/random_roots.h"

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace vdbtools {

/// --iterations. @param usual  its default
OptionSpec iterationsOption(const std::string& usual);

/// --escape, for maps of quaternions: the radius beyond which an orbit has escaped.
OptionSpec escapeOption();
/// --radius, for maps of R^3: the same, and that of the ball in which the set is looked for.
OptionSpec radiusOption();
/// @param escape  "escape" or "radius", whichever the map has
julia::OrbitOptions parseOrbit(const RecipeReader& reader, const std::string& escape);

/// --mandelbrot: whether the constant is the point itself. The alternative to --c. @param usual  whether it is so
/// without --c
OptionSpec mandelbrotOption(bool usual);
bool parseMandelbrot(const RecipeReader& reader);

/// --slice and --drop-axis.
std::vector<OptionSpec> embeddingOptions();
julia::Embedding parseEmbedding(const RecipeReader& reader);
/// That of a map of R^3, which takes no other: @throw std::invalid_argument
julia::Embedding parseSpatialEmbedding(const RecipeReader& reader);

/// --detail, --outward, --alpha, --beta, --mask and --sampling: the shell of a map over a target.
std::vector<OptionSpec> shellOptions();
/// --iterations of such a map: more for a shell of detail, whose default is what more steps hardly change.
OptionSpec shellIterationsOption();
/// --escape of such a map: smaller for a shell of detail, where it is the outer end of the shell.
OptionSpec shellEscapeOption();
/// The control that an option gives whose numbers are from 0 to 1. @throw std::invalid_argument
ControlSetting parseShare(const RecipeReader& reader, const std::string& option);
/// @throw std::invalid_argument  naming the option
ShellSettings parseShell(const RecipeReader& reader);

/// The values of --frequency and of the frequency of a second texture.
OptionType frequencyType();
/// --frequency: how fine a texture is that follows the target's local thickness.
OptionSpec frequencyOption();

/// The control that such an option gives. @throw std::invalid_argument
ControlSetting parseFrequency(const RecipeReader& reader, const std::string& option);

/// Roots as a recipe describes them: those of a file, of a texture of the shelf, or random ones; scaled and moved.
struct RootsSettings {
  std::optional<NamedFile> file;
  const Texture* texture = nullptr;  ///< of textureShelf()
  /// Where there is neither of the two; but for what the target says. The seed varies a texture too.
  julia::RandomRootsOptions random;
  /// Of a texture that follows the thickness; else not there.
  ControlSetting frequency{};
  double scale = 1;
  openvdb::Vec3d translate{0, 0, 0};  ///< units of fractal space
};

/// --texture, --texture-seed and so on.
std::vector<OptionSpec> rootsOptions();
/// Those of random roots alone: --texture-seed to --texture-radius.
std::vector<OptionSpec> randomRootsOptions();
julia::RandomRootsOptions parseRandomRoots(const RecipeReader& reader);
/// @param fileOption  the option that names the roots: "texture", which may also be "random" or a texture's name, or
///                    "rational", always a file
/// @throw std::invalid_argument  also for a name that no texture has
RootsSettings parseRoots(const RecipeReader& reader, const std::string& fileOption);

/// @throw std::invalid_argument  an option of random roots is given where --texture says something else
void refuseRandomOnly(const RecipeReader& reader);
/// The texture or the roots of a layer over these, for which --texture-over has a name or a file: with a seed and a
/// frequency of its own, and scaled and moved as they are. @throw std::invalid_argument
RootsSettings parseOverRoots(const RecipeReader& reader);
/// The names of all textures, and "random".
std::vector<std::string> textureNames();

/// Of a `.json`, `.p4d`, `.poly4d` or `.o3d`; or of a VDB that holds the versor that it was made with.
std::optional<RationalFile> readRoots(const RootsSettings& settings);

/// How deep distances must be known to strew them, as a share of the target's longest side.
double interiorReachOf(const RootsSettings& settings);

/// Roots in a scene.
struct PlacedRoots {
  julia::Rational drawn;           ///< as drawn or read: what is recorded
  std::optional<FittedTo> fitted;  ///< of a file's that a fit made
  julia::Rational placed;          ///< scaled and moved: what is evaluated

  std::map<std::string, std::string> metadata() const;
};

/// The seed of roots that have something random in them; none for others.
std::optional<std::uint64_t> seedOf(const RootsSettings& settings);

/// Waves, scaled and moved as the settings say. @param file  those of a file; nullopt: those of the settings' texture
julia::WaveTexture placeWaves(const RootsSettings& settings, const std::optional<WaveFile>& file,
                              const julia::Embedding& embedding);

/// Waves that follow a grain, whose numbers along it and across it are whole. @param octave  GrainScale::octave
julia::WaveTexture grainWaves(const RootsSettings& settings, const std::optional<WaveFile>& file, int octave);

/// @param file  what the settings' file holds, if they name one
/// @throw std::invalid_argument  as julia::randomPolynomial(), placeTexture(), julia::scaled()
PlacedRoots placeRoots(const RootsSettings& settings, const std::optional<RationalFile>& file,
                       const julia::Embedding& embedding, const MapContext& context);

/// Whether floats serve for a versor of waves, as docs/precision.md has measured it: few steps.
bool floatsServeWaves(const julia::OrbitOptions& orbit);
/// The same for a versor of roots: powers whose sum is not large. A root and a pole that lie near each other nearly
/// cancel, and count as much less.
bool floatsServeVersor(const julia::OrbitOptions& orbit, const julia::Rational& roots);

/// The same for a rational map: fewer steps, and powers whose sum is not large.
bool floatsServe(const julia::OrbitOptions& orbit, const julia::Rational& roots);

}  // namespace vdbtools
