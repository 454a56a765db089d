// SPDX-License-Identifier: Apache-2.0
/// @file fractal_files.h
/// Writes a fractal to files, as `juliavdb fractal` does.
#pragma once

#include "vdbtools/files/atomic_file.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <map>
#include <span>
#include <string>
#include <vector>

namespace vdbtools {

/// A file that takes the grids or the mesh, whichever its format holds.
struct FractalFile {
  AtomicFile* file = nullptr;
  const FileFormat* format = nullptr;  ///< one that is written
};

/// The files of a fractal, at least one of which is given. They must outlive the call.
struct FractalFiles {
  std::vector<FractalFile> files{};
  NvdbValues nvdb = NvdbValues::Full;              ///< how a NanoVDB file stores numbers
  std::vector<NvdbWritten>* nvdbReport = nullptr;  ///< takes what became of the grids in such a file

  bool wantGrids() const;
  bool wantMesh() const;
};

/// The options with which the grids and the mesh of a scene are written.
/// @param metadata  the metadata of the scene
VdbWriteOptions vdbWriteOptions(const OutputOptions& output, std::map<std::string, std::string> metadata);
MeshWriteOptions meshWriteOptions(const FileFormat& format, const OutputOptions& output,
                                  std::map<std::string, std::string> metadata);

/// Makes the grids and the mesh of a scene and writes them, with their metadata. The caller commits the files.
/// @param recipe  the recipe of the scene, which the metadata record
/// @throw std::invalid_argument  no file was given, or an STL would have more triangles than it can count
/// @throw DataError              there is no surface
/// @throw IoError, Interrupted
FractalResult writeFractal(const Scene& scene, const Recipe& recipe, const FractalFiles& files, Monitor& monitor);

/// Writes what runFractal() made of a scene earlier, with the same bytes as writeFractal().
/// @param made          must have grids if a file of grids is written
/// @param mesh, values  the mesh and the values of its columns that runFractal() passed to its sink
/// @throw as writeFractal()
void writeMadeFractal(const Scene& scene, const Recipe& recipe, const FractalResult& made, const Mesh& mesh,
                      std::span<const float> values, const FractalFiles& files, Monitor& monitor);

}  // namespace vdbtools
