// SPDX-License-Identifier: Apache-2.0
/// @file plans.h
/// Plans of a job for a farm: tiles of one fractal, cells of a contact sheet, and frames.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/farm/estimate.h"
#include "vdbtools/farm/manifest.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/recipe/option_table.h"
#include "vdbtools/scene/fractal_options.h"

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace vdbtools::farm {

// Cuts a fractal into tiles, i.e. boxes of lattice nodes, that can be computed independently.

inline constexpr int kMostTiles = 1'000'000;

struct TilePlanOptions {
  /// The number of tiles, of about equal work: the lattice is bisected recursively, between blocks of 8^3 nodes.
  std::optional<int> tiles;
  /// Alternatively, the number of nodes along the side of a cube: tiles begin at its multiples. Tiles without an
  /// undecided cell in them or within a few nodes of them are left out, unless islands are to be dropped and the tile
  /// lies inside the set.
  std::optional<int> tileNodes;
  std::vector<std::string> makes;  ///< as Manifest::makes
  bool survey = false;             ///< whether to locate the surface, for an estimate
};

struct TileBox {
  openvdb::CoordBBox nodes;  ///< the nodes that the tile owns
  double work = 0;  ///< the number of nodes of undecided boxes in it; where boxes overlap, nodes count several times
};

/// Cuts a box into at most @a count boxes, each with about the same share of the boxes in @a work. There are fewer if
/// fewer blocks contain work.
std::vector<TileBox> cutEvenly(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int count);

/// Returns those cubes of @a side nodes, clipped by the domain, that are less than @a margin nodes away from a box of
/// @a work; ordered by x, then y, then z.
std::vector<TileBox> cutIntoCubes(const openvdb::CoordBBox& domain, std::span<const openvdb::CoordBBox> work, int side,
                                  int margin);

struct TilePlan {
  Manifest manifest;
  std::vector<TaskWork> work;  ///< of each tile; its surface is set only with TilePlanOptions::survey
  /// Sentences about its voxels, as in scene/voxel_advice.h; empty if there is nothing to report.
  std::string chosenResolution{}, finerThanVoxels{};
};

/// Makes the target and its exponent, cuts the lattice, and writes the prepared scene into @a folder.
/// @param recipe  the recipe of @a options, complete
/// @return the manifest, not written yet
/// @throw std::invalid_argument  neither or both of tiles and tileNodes, or out of range; options that tiles do not
///                               support
/// @throw what making the scene throws
TilePlan planTiles(const FractalOptions& options, const Recipe& recipe, const TilePlanOptions& tiles,
                   const std::filesystem::path& folder, Monitor& monitor);

// Plans the fractals of cells of a contact sheet (vdbtools/job/sheet_job.h).

struct SheetPlanOptions {
  std::string cells;                      ///< "sheet.json#3,7-9", or "sheet.json" for every cell without an error
  Recipe given;                           ///< options that override the cells' options, such as a higher resolution
  std::string name;                       ///< base name of the files; empty: named after the sheet
  std::vector<std::string> makes{"vdb"};  ///< any of writtenFormats()
};

/// Plans a task for each cell, in the order of the cells. The files are out/NAME.0007.vdb and the like, with the cell's
/// number.
/// @throw std::invalid_argument  there is no such cell, or an option is refused (the message names the cell)
/// @throw DataError              the file is not a contact sheet, all its cells have errors, or a file that a cell
///                               names has changed
/// @throw MissingInputError, IoError
/// @throw as makeScene(), if a cell has `--resolution auto`, which is replaced by its number
Manifest planSheetCells(const SheetPlanOptions& options, Monitor& monitor);
Manifest planSheetCells(const SheetPlanOptions& options);

// Plans of frames: a fractal for each frame, with options that change from frame to frame by keys, inputs with a file
// for each frame, and targets that are animated.
//
// Between two keys, at the fraction t of the way from one frame to the other, a number is
//
//     a + (b - a) t                    linear
//     a + (b - a) (3 t^2 - 2 t^3)      smooth: its slope is 0 at every key, and it stays between a and b
//     a                                step
//
// Before the first key and after the last it is constant. At a key the value is the key's text itself. Several numbers
// with separators between them, as in "0,1,-2" or "x:0.05:0.6:smooth", are blended one by one; the text around them
// must be the same in both keys.

enum class Ease { Linear, Smooth, Step };

/// The values of an option at some frames.
struct KeyedOption {
  std::string name;
  std::map<int, std::string> keys;  ///< by frame, at least one
  Ease ease = Ease::Linear;
};

inline constexpr int kMostFrames = 100'000;

/// Parses a list of frames and ranges such as "7", "1-48", "1-48x2" or "1-48:2" (every second one, from 1 on) or
/// "1-48x8,1-48" (every eighth first, and then the others). Numbers may be negative, as in "-5-5" or "-8--4". The
/// result is in the order of the list, each frame once.
/// @throw std::invalid_argument  not such a list, a reversed range, or more than kMostFrames
std::vector<int> parseFrames(const std::string& text);

/// @param keys   such as "alpha@48=120"
/// @param eases  "linear", "smooth" or "step" for all options, or for one as in "alpha=smooth", which takes precedence
/// @return the options in the order of their names
/// @throw std::invalid_argument  an unknown option, two values at one frame, or two keys that cannot be blended
std::vector<KeyedOption> parseKeys(const std::vector<std::string>& keys, const std::vector<std::string>& eases,
                                   const OptionTable& table);

/// The option's value at a frame. @throw std::invalid_argument  the keys around the frame cannot be blended
std::string valueAt(const KeyedOption& option, int frame);

struct FramePlanOptions {
  Recipe base;   ///< of `juliavdb fractal`. File names may have a frame pattern (vdbtools/files/frames.h)
  Recipe given;  ///< options of the base that were requested as explicitly as the keys and are not replaced by them
  std::vector<KeyedOption> keys;
  std::vector<int> frames{1};             ///< in the order of execution
  std::string name;                       ///< base name of the files; empty: named after the target, or else the map
  std::vector<std::string> makes{"vdb"};  ///< any of writtenFormats()
  std::optional<double> resolution{};     ///< the value of `--resolution auto` at every frame that has it
  std::optional<double> sdfResolution{};  ///< that of `--sdf-resolution auto`, likewise
  std::optional<double> voxelSize{};      ///< of all frames, world units; nullopt: as their recipes say
  bool missingFails = true;               ///< whether a missing file fails all frames, and not only its own
};

/// If the target is one glTF with animations, and its frame is neither given nor keyed, gives each frame its own number
/// as `--target-frame`, by a key. @throw DataError, IoError  the target cannot be read
void playTarget(FramePlanOptions& options);

/// Sets options.resolution if a frame has `auto`: to the largest number that the first of these frames, the middle one
/// and the last would choose by themselves, so that the frames of a sequence have matching voxels. Sets
/// options.sdfResolution likewise, if the target changes from frame to frame.
/// @throw as makeScene()
void chooseResolution(FramePlanOptions& options, Monitor& monitor);

/// The given options and their values at a frame.
/// @throw std::invalid_argument  keys cannot be blended, or a name has more than one place for the frame
Recipe recipeAt(const FramePlanOptions& options, int frame);

/// @throw std::invalid_argument  a key is a file name with a frame pattern
void requireKeysWithoutPatterns(const FramePlanOptions& options);

/// Plans a task for each frame, whose files are out/NAME.0007.vdb and the like. Every frame's recipe is checked, and
/// all files that it names are read and hashed. If nothing changes from frame to frame, all are the same.
/// @throw std::invalid_argument  an option is refused (the message names the frame)
/// @throw MissingInputError      a frame's file is missing
/// @throw DataError, IoError
Manifest planFrames(const FramePlanOptions& options);

// The recipes of a sequence whose frames one process makes one after the other.

/// A voxel size for all frames of a sequence whose target changes its size.
struct SharedVoxel {
  double size = 0;  ///< world units
  int frame = 0;    ///< whose target is the largest
};

class FrameRecipes {
 public:
  /// Checks the options of every frame, and that the files they name exist (FramePlanOptions::missingFails). Nothing is
  /// opened.
  /// @param options  without names and makes, which belong to plans
  /// @throw std::invalid_argument  an option is refused (the message names the frame)
  /// @throw MissingInputError      names the first few missing files
  explicit FrameRecipes(FramePlanOptions options);
  ~FrameRecipes();

  const std::vector<int>& frames() const { return mOptions.frames; }
  /// The files that any of the frames names.
  const InputFiles& inputs() const { return mInputs; }

  /// Opens the target of a frame, its mesh at rest and its neighbours, and compares their faces, so that a broken file
  /// is found before the work begins. Files that earlier frames have named are not opened again.
  /// @throw MissingInputError, DataError, IoError  as when reading the files
  void look(int frame, Monitor& monitor);

  /// The voxels that the largest target needs, if the frames have one resolution, no rest, and targets of several
  /// sizes.
  /// @param options  with the resolution that was chosen
  /// @pre look() for each frame that counts
  std::optional<SharedVoxel> sharedVoxel(const FramePlanOptions& options) const;

  /// The complete recipe of a frame, with the hashes of its files. A file that several frames name is read once, and
  /// later recipes use its hash to refuse a changed file.
  /// @throw MissingInputError, DataError, IoError  as when reading the files
  Recipe at(int frame) const;

 private:
  struct Known;
  FramePlanOptions mOptions;
  InputFiles mInputs;
  std::unique_ptr<Known> mKnown;
};

}  // namespace vdbtools::farm
