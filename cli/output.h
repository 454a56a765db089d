// SPDX-License-Identifier: Apache-2.0
/// @file output.h
/// The files that a command writes: their places are claimed before the work begins, and all appear together at its
/// end.
#pragma once

#include "vdbtools/files/atomic_file.h"
#include "vdbtools/mesh/vertex_column.h"

#include <filesystem>
#include <functional>
#include <list>
#include <optional>
#include <ostream>
#include <span>
#include <string>
#include <string_view>

namespace cli {

class Outputs {
 public:
  /// @param frame  the frame number for names such as name.####.vdb, if there is one
  /// @throw std::invalid_argument, std::invalid_argument if the name has no extension of @a extensions (".vdb .ply")
  ///        vdbtools::CreateError
  explicit Outputs(std::optional<int> frame = {}) : mFrame(frame) {}

  /// Claims a place; the file's stream is for its content.
  vdbtools::AtomicFile& add(const std::string& option, const std::string& name, std::string_view extensions);

  /// Brings all to their places. @throw vdbtools::IoError
  void commit();

  /// The names as they came to be, separated by commas.
  std::string names() const;

 private:
  std::optional<int> mFrame;
  std::list<vdbtools::AtomicFile> mFiles;
};

/// What the help says of a mesh to write.
inline constexpr const char* kMeshHelp = "the mesh to write: .ply, .obj, .stl or .glb";

/// The extension that says what is written to @a name; @a usual for a device, which has none.
std::string formatOf(const std::string& name, const char* usual);

/// Says which attributes a mesh or a VDB has no room for, if there are any.
void noteLeftOut(const std::filesystem::path& file, std::span<const vdbtools::VertexColumn> columns);

/// The value of an option --frame. @throw std::invalid_argument
std::optional<int> parseFrame(const std::string& text);

}  // namespace cli
