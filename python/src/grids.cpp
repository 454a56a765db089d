// SPDX-License-Identifier: Apache-2.0
// Grids of numbers: signed distances of meshes, and the content of VDBs and arrays.
#include "module_parts.h"

#include "arrays.h"
#include "watched_work.h"

#include "vdbtools/files/output_files.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/job/sdf_job.h"

#include <openvdb/tools/Dense.h>
#include <openvdb/tools/Interpolation.h>

#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <utility>

namespace py = pybind11;

namespace {

using openvdb::FloatGrid;
using openvdb::Vec3d;
using vdbtools::Monitor;

/// A grid, and the other data of its file.
struct MadeGrid {
  FloatGrid::Ptr grid;
  std::map<std::string, std::string> metadata{};
  vdbtools::InputFiles inputs{};
};

std::shared_ptr<MadeGrid> distancesOf(const vdbtools::Recipe& given, const py::object& vertices,
                                      const py::object& faces, const GivenResources& resources,
                                      const py::object& progress) {
  std::shared_ptr<const vdbtools::Mesh> mesh = targetOf(vertices, faces);
  vdbtools::Recipe recipe = given;
  if (mesh) recipe["input"] = kMemory;
  auto made = std::make_shared<MadeGrid>();
  doWatched(progress, resourcesOf(resources), [&](Monitor& monitor) {
    recipe = vdbtools::completeRecipe(std::move(recipe), vdbtools::sdfOptionTable());
    vdbtools::SdfOptions options = vdbtools::parseSdfOptions(recipe);
    if (!mesh) made->inputs.add(options.input);
    options.mesh = std::move(mesh);
    vdbtools::SdfResult result = vdbtools::runSdf(options, monitor);
    made->grid = result.grid;
    if (const auto name = options.gridNames.find(result.grid->getName()); name != options.gridNames.end())
      made->grid->setName(name->second);
    made->metadata = vdbtools::recipeToMetadata(recipe, "sdf");
    made->metadata.insert(result.metadata.begin(), result.metadata.end());
  });
  return made;
}

std::shared_ptr<MadeGrid> gridOfFile(const std::string& path, const std::string& name) {
  const py::gil_scoped_release free;
  auto made = std::make_shared<MadeGrid>();
  vdbtools::VdbFile file = vdbtools::readVdb(path);
  made->grid = vdbtools::chooseFloatGrid(file, name, path);
  made->metadata = std::move(file.metadata);
  made->inputs.add(path);
  return made;
}

/// Every node of the array is active.
std::shared_ptr<MadeGrid> gridOfArray(const py::object& values, double voxelSize, const std::array<double, 3>& origin,
                                      const std::string& name) {
  const py::array given = arrayOf(values, "array");
  if (given.ndim() != 3)
    throw std::invalid_argument("array must have three axes, x, y and z; its shape is " + shapeText(given));
  const py::array_t<double> numbers = doublesOf(given, "array");
  if (numbers.size() == 0) throw std::invalid_argument("array is empty; its shape is " + shapeText(given));
  if (!(voxelSize > 0 && std::isfinite(voxelSize)))
    throw std::invalid_argument("voxel_size is " + tupleText(&voxelSize, 1) + "; it must be above 0 and finite");
  for (const double x : origin)
    if (!std::isfinite(x))
      throw std::invalid_argument("origin is " + tupleText(origin.data(), 3) + "; it must be finite");
  openvdb::initialize();
  vdbtools::requireVdbVoxel(voxelSize, "give a larger voxel_size");
  auto made = std::make_shared<MadeGrid>();
  made->grid = FloatGrid::create(0);
  made->grid->setName(name);
  made->grid->setTransform(openvdb::math::Transform::createLinearTransform(voxelSize));
  made->grid->transform().postTranslate(Vec3d(origin[0], origin[1], origin[2]));
  FloatGrid::Accessor write = made->grid->getAccessor();
  const double* next = numbers.data();
  for (int x = 0; x < numbers.shape(0); ++x)
    for (int y = 0; y < numbers.shape(1); ++y)
      for (int z = 0; z < numbers.shape(2); ++z) write.setValue({x, y, z}, static_cast<float>(*next++));
  return made;
}

/// (array, index of its first node)
py::tuple arrayOfGrid(const MadeGrid& made) {
  const openvdb::CoordBBox box = made.grid->evalActiveVoxelBoundingBox();
  if (box.empty()) throw std::invalid_argument("the grid has no active voxel, and so no array");
  const openvdb::Coord size = box.dim();
  py::array_t<float> array({size[0], size[1], size[2]});
  float* const first = array.mutable_data();
  {
    const py::gil_scoped_release free;
    openvdb::tools::Dense<float, openvdb::tools::LayoutZYX> dense(box, first);
    openvdb::tools::copyToDense(*made.grid, dense);
  }
  return py::make_tuple(array, py::make_tuple(box.min()[0], box.min()[1], box.min()[2]));
}

py::array_t<double> sampleOf(const MadeGrid& made, const py::object& points) {
  const Places places = placesOf(points, "points");
  py::array_t<double> result(places.shape);
  const std::span<double> values = memoryOf(result);
  const std::span<const Vec3d> at = places.points();
  const py::gil_scoped_release free;
  const FloatGrid::ConstAccessor read = made.grid->getConstAccessor();
  for (std::size_t i = 0; i < at.size(); ++i)
    values[i] = openvdb::tools::BoxSampler::sample(read, made.grid->worldToIndex(at[i]));
  return result;
}

void writeGrid(const MadeGrid& made, const std::string& path) {
  const py::gil_scoped_release free;
  const vdbtools::FileFormat& format = vdbtools::gridFormat(path);
  vdbtools::requireBuilt(format);
  vdbtools::OutputFiles files(made.inputs);
  std::ostream& file = files.add(path).stream();
  vdbtools::writeGrids(file, format, {made.grid}, {.metadata = made.metadata});
  files.commit();
}

}  // namespace

void addGrids(py::module_& module) {
  module.def("sdf", distancesOf);
  module.def("read_grid", gridOfFile);
  module.def("grid_of_array", gridOfArray);
  py::class_<MadeGrid, std::shared_ptr<MadeGrid>>(module, "Grid")
      .def("array", arrayOfGrid)
      .def("sample", sampleOf)
      .def("write", writeGrid)
      .def_property_readonly("name", [](const MadeGrid& made) { return made.grid->getName(); })
      .def_property_readonly("voxel_size", [](const MadeGrid& made) { return made.grid->voxelSize()[0]; })
      .def_property_readonly("background", [](const MadeGrid& made) { return made.grid->background(); })
      .def_property_readonly("metadata", [](const MadeGrid& made) { return made.metadata; })
      .def("to_world", [](const MadeGrid& made, const std::array<double, 3>& index) {
        const Vec3d at = made.grid->indexToWorld(Vec3d(index[0], index[1], index[2]));
        return py::make_tuple(at[0], at[1], at[2]);
      });
}
