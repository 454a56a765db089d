// SPDX-License-Identifier: Apache-2.0
/// @file fractal_files.h
/// A fractal into files, as `juliavdb fractal` writes them.
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

/// The files outlive the call. At least one is wanted.
struct FractalFiles {
  std::vector<FractalFile> files{};
  NvdbValues nvdb = NvdbValues::Full;              ///< how a NanoVDB file stores numbers
  std::vector<NvdbWritten>* nvdbReport = nullptr;  ///< takes what became of the grids in such a file

  bool wantGrids() const;
  bool wantMesh() const;
};

/// How a scene's grids and its mesh go into files.
/// @param metadata  the scene's
VdbWriteOptions vdbWriteOptions(const OutputOptions& output, std::map<std::string, std::string> metadata);
MeshWriteOptions meshWriteOptions(const FileFormat& format, const OutputOptions& output,
                                  std::map<std::string, std::string> metadata);

/// Makes the grids and the mesh of a scene and writes them, with their metadata. The files are left to be committed.
/// @param recipe  what the metadata say of how the scene was made
/// @throw std::invalid_argument  no file, or an STL of more triangles than it can count
/// @throw DataError              there is no surface
/// @throw IoError, Interrupted
FractalResult writeFractal(const Scene& scene, const Recipe& recipe, const FractalFiles& files, Monitor& monitor);

/// Writes what runFractal() has made of a scene before, with the same bytes as if it were made now.
/// @param made  with grids, if a file takes them
/// @param mesh, values  what went to its sink
/// @throw as above
void writeMadeFractal(const Scene& scene, const Recipe& recipe, const FractalResult& made, const Mesh& mesh,
                      std::span<const float> values, const FractalFiles& files, Monitor& monitor);

}  // namespace vdbtools
