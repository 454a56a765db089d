// SPDX-License-Identifier: Apache-2.0
/// @file output.h
/// The files that a command writes: their paths are claimed before the work begins, and all files appear together at
/// its end.
#pragma once

#include "vdbtools/field/crumbs.h"
#include "vdbtools/files/file_format.h"
#include "vdbtools/files/output_files.h"
#include "vdbtools/mesh/mesh_sink.h"
#include "vdbtools/recipe/option_table.h"

#include <filesystem>
#include <functional>
#include <optional>
#include <ostream>
#include <set>
#include <span>
#include <string>
#include <string_view>

namespace cli {

class CommandLine;

class Outputs {
 public:
  /// @param inputs  what is read in addition to CommandLine::inputs(): files that a recipe or an option names.
  ///                Files named by the recipes in all these are added here
  /// @param frame   the frame number for names such as name.####.vdb, if there is one
  explicit Outputs(const CommandLine& line, vdbtools::InputFiles inputs, std::optional<int> frame = {});

  /// Claims a path, or the standard output (isStandardOutput()); the content is written to the file's stream.
  /// @throw std::invalid_argument  the name has none of the @a extensions (".vdb .ply"), or the file is an input or the
  ///                               same as another output
  /// @throw vdbtools::CreateError
  vdbtools::AtomicFile& add(const std::string& option, const std::string& name, std::string_view extensions);
  /// The same with the formats of grids and meshes of which @a fact is true.
  vdbtools::AtomicFile& add(const std::string& option, const std::string& name, bool vdbtools::FileFormat::*fact);

  /// Commits all files and records them in report().
  /// @param isAll  whether the command makes no further files; see workIsDone()
  /// @throw vdbtools::IoError
  void commit(bool isAll = true);

  /// The final names, separated by commas.
  std::string names() const;

 private:
  std::optional<int> mFrame;
  vdbtools::OutputFiles mFiles;
};

/// Checks the outputs of all frames before the first is made: none may be an input of any frame.
/// @param options  the options that name outputs; those that were not given are ignored
/// @throw std::invalid_argument
void requireFramePlaces(const CommandLine& line, vdbtools::InputFiles inputs, std::span<const char* const> options,
                        std::span<const int> frames);

/// The help on a mesh to write.
std::string meshHelp();

/// Whether an output's name is that of the standard output: "-", or "-" and the extension of a format for pipes.
bool isStandardOutput(const std::string& name);

/// The extension that determines the format of @a name: ".ply" for "-", and @a usual for a device, which has none.
std::string formatOf(const std::string& name, const char* usual);

/// Reports which attributes a mesh or a VDB cannot hold, if there are any.
void noteLeftOut(const std::filesystem::path& file, std::span<const vdbtools::VertexColumn> columns);

/// Reports how many crumbs were dropped, and counts them in the summary.
/// @param voxelSize  of the lattice, world units
/// @param left       the remaining volume, if it is known
/// @param counts     whether they are counted
void tellCrumbs(const vdbtools::CrumbReport& dropped, double voxelSize, std::optional<double> left, bool counts = true);

/// The value of an option --frame. @throw std::invalid_argument
std::optional<int> parseFrame(const std::string& text);

/// The products of -o and --mesh.
std::set<vdbtools::Product> productsOf(const CommandLine& line);
/// The products of --make, a list of formats.
std::set<vdbtools::Product> productsOf(const std::vector<std::string>& makes);

}  // namespace cli
