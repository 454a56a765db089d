// SPDX-License-Identifier: Apache-2.0
#include "render_mesh.h"

#include "options.h"

#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/render/preview.h"

namespace cli {

bool isMesh(const std::string& input) { return !input.empty() && !vdbtools::isVdbPath(input); }

vdbtools::ShadedImage imageOfMesh(const CommandLine& line, const std::string& input,
                                  const vdbtools::PreviewOptions& picture, vdbtools::Monitor& monitor) {
  if (line.has("colour") && line.text("colour") != "clay")
    line.refuse("colour", "clay for a mesh, or left out for the colours that the mesh itself has");
  monitor.begin(vdbtools::PhaseKind::Reading, 0);
  vdbtools::Mesh mesh = vdbtools::readMesh(input);
  return vdbtools::renderMeshPreview(std::move(mesh), {.picture = picture, .colours = !line.has("colour")}, monitor);
}

}  // namespace cli
