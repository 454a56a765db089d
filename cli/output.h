// SPDX-License-Identifier: Apache-2.0
/// @file output.h
/// The files that a command writes: their places are claimed before the work begins, and all appear together at its
/// end.
#pragma once

#include "vdbtools/field/crumbs.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/mesh/vertex_column.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

namespace cli {

class CommandLine;

class Outputs {
 public:
  /// @param inputs  what is read besides CommandLine::inputs(): the files that a recipe names, and those of options.
  ///                What the recipes in all these name is added here
  /// @param frame   the frame number for names such as name.####.vdb, if there is one
  explicit Outputs(const CommandLine& line, vdbtools::InputFiles inputs, std::optional<int> frame = {});

  /// Claims a place; the file's stream is for its content.
  /// @throw std::invalid_argument  the name has no extension of @a extensions (".vdb .ply"), the file is an input or
  ///                               the same as another output
  /// @throw vdbtools::CreateError
  vdbtools::AtomicFile& add(const std::string& option, const std::string& name, std::string_view extensions);

  /// Brings all to their places, and tells report().
  /// @param isAll  whether the command makes no further files; see workIsDone()
  /// @throw vdbtools::IoError
  void commit(bool isAll = true);

  /// The names as they came to be, separated by commas.
  std::string names() const;

 private:
  std::optional<int> mFrame;
  vdbtools::OutputFiles mFiles;
};

/// Checks the outputs of all frames before the first is made: none may be an input of any frame.
/// @param options  those that name outputs; of these, the ones that are given
/// @throw std::invalid_argument
void requireFramePlaces(const CommandLine& line, vdbtools::InputFiles inputs, std::span<const char* const> options,
                        std::span<const int> frames);

/// What the help says of a mesh to write.
inline constexpr const char* kMeshHelp = "the mesh to write: .ply, .obj, .stl or .glb";

/// The extension that says what is written to @a name; @a usual for a device, which has none.
std::string formatOf(const std::string& name, const char* usual);

/// Says which attributes a mesh or a VDB has no room for, if there are any.
void noteLeftOut(const std::filesystem::path& file, std::span<const vdbtools::VertexColumn> columns);

/// Says how many crumbs were dropped, and counts them in the summary.
/// @param voxelSize  of the lattice, world units
/// @param left       the volume of what is left, if it is known
/// @param counts     whether they are counted
void tellCrumbs(const vdbtools::CrumbReport& dropped, double voxelSize, std::optional<double> left, bool counts = true);

/// The value of an option --frame. @throw std::invalid_argument
std::optional<int> parseFrame(const std::string& text);

}  // namespace cli
