// SPDX-License-Identifier: Apache-2.0
#include "explore/made_picture.h"

#include "job/mesh_picture.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/formats/vdb_file.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/render/preview.h"
#include "vdbtools/scene/fractal_options.h"

#include <algorithm>
#include <filesystem>
#include <stdexcept>
#include <system_error>

namespace vdbtools::explore {
namespace {

/// @param up  the picture's up axis, if it does not give one
PreviewOptions previewOf(const FieldPicture& picture, UpAxis up, const UpTurn& turn) {
  const FieldView& view = picture.view;
  PreviewOptions options{.width = picture.render.width,
                         .height = picture.render.height,
                         .samples = picture.render.samples,
                         .view = view.angles,
                         .up = up,
                         .look = picture.render.look};
  if (!view.eye) return options;
  if (!view.lookAt)
    throw std::invalid_argument("'view' has an eye and no 'lookAt'; give the point in the middle of the picture");
  options.camera = Camera{.eye = turn(*view.eye),
                          .lookAt = turn(*view.lookAt),
                          .up = turn(view.up.value_or(directionOf(up))),
                          .fieldOfView = view.angles.fieldOfView};
  return options;
}

std::string encoded(const ShadedImage& image, const FieldPicture& picture) {
  return encodeShadedImage(image, ".png", picture.render.look.backdrop == Backdrop::None, {Pass::Beauty});
}

/// The file that is shown: a mesh, or else grids that can be read.
const std::filesystem::path& shownFile(const std::vector<std::filesystem::path>& files) {
  for (bool FileFormat::*const fact : {&FileFormat::readsMesh, &FileFormat::readsGrids})
    for (const std::filesystem::path& file : files)
      if (findFormat(file.native())->*fact) return file;
  throw std::invalid_argument("'" + files.at(0).filename().string() +
                              "' is not read here; make a mesh or a VDB as well to see what was made");
}

}  // namespace

std::string pictureOfMesh(const Scene& scene, const FieldPicture& picture, Monitor& monitor) {
  return encoded(meshPicture(scene, previewOf(picture, scene.options.output.axes.target, {}), monitor), picture);
}

std::string pictureOfMade(const MadeFiles& made, const FieldPicture& picture, Monitor& monitor) {
  const std::filesystem::path& file = shownFile(made.files);
  const FileFormat& format = *findFormat(file.native());
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(std::filesystem::symlink_status(file, ignored)))
    throw MissingInputError("'" + file.filename().string() + "' is no longer there");
  const FractalOptions options = parseFractalOptions(made.recipe);
  const FileAxes& axes = options.output.axes;
  const UpAxis up = axes.of(format);
  const PreviewOptions preview = previewOf(picture, up, UpTurn(axes.target, up));
  monitor.begin(PhaseKind::Reading, 0);
  if (format.readsGrids)
    return encoded(renderPreview(*chooseFloatGrid(readVdb(file), "", file.string()), preview, monitor), picture);
  return encoded(
      renderMeshPreview(readMesh(file), {.picture = preview, .colours = showsOwnColours(options.output)}, monitor),
      picture);
}

}  // namespace vdbtools::explore
