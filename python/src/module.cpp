// SPDX-License-Identifier: Apache-2.0
// The Python module juliavdb._juliavdb. The interface for users is in juliavdb/__init__.py, which turns arguments into
// the text of a recipe; this file has the arrays, the errors and the work.
#include "arrays.h"
#include "device_use.h"
#include "made.h"
#include "module_parts.h"
#include "python_functions.h"
#include "python_words.h"
#include "watched_work.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/base/memory.h"
#include "vdbtools/job/sdf_job.h"
#include "vdbtools/maps/device_choice.h"
#include "vdbtools/mesh_files/mesh_reader.h"
#include "vdbtools/picture/gradient.h"
#include "vdbtools/recipe/recipe.h"
#include "vdbtools/records/failure_text.h"
#include "vdbtools/scene/fractal_options.h"
#include "vdbtools/scene/scene.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <new>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace py = pybind11;

namespace {

using openvdb::Vec3d;
using vdbtools::Monitor;
using vdbtools::Recipe;

/// For work on a scene.
Resources resourcesFor(const MadeScene& made, const std::optional<int>& threads) {
  return {made.memory, threadsOf(threads), made.device};
}

std::shared_ptr<const vdbtools::Mesh> meshOf(const py::array& vertices, const py::array& faces) {
  const py::array_t<double> points = triplesOf(vertices, "vertices");
  requireTriples(faces, "faces");
  if (const char kind = faces.dtype().kind(); kind != 'i' && kind != 'u')
    throw std::invalid_argument("faces must hold whole numbers, the indices of vertices");
  const py::array_t<std::int64_t, py::array::c_style | py::array::forcecast> indices(faces);
  auto mesh = std::make_shared<vdbtools::Mesh>();
  const std::span<const Vec3d> all = spanOf(points);
  mesh->points.assign(all.begin(), all.end());
  const std::int64_t* index = indices.data();
  const auto count =
      static_cast<std::int64_t>(std::min<std::size_t>(mesh->points.size(), std::numeric_limits<std::uint32_t>::max()));
  for (py::ssize_t face = 0; face < indices.shape(0); ++face, index += 3) {
    openvdb::Vec3I triangle;
    for (int corner = 0; corner < 3; ++corner) {
      if (index[corner] < 0 || index[corner] >= count)
        throw std::invalid_argument("face " + std::to_string(face) + " uses vertex " + std::to_string(index[corner]) +
                                    ", and there are " + std::to_string(count) + " vertices, the first of which is 0");
      triangle[corner] = static_cast<std::uint32_t>(index[corner]);
    }
    mesh->triangles.push_back(triangle);
  }
  return mesh;
}

std::shared_ptr<MadeScene> openScene(const Recipe& recipe, const py::object& vertices, const py::object& faces,
                                     const GivenResources& given, const py::object& progress, const py::object& versor,
                                     const py::object& map, const py::object& rest) {
  const Resources resources = resourcesOf(given);
  const OwnFunctions functions{versorOf(versor), mapOf(map)};
  MemoryTarget target{.mesh = targetOf(vertices, faces)};
  if (!rest.is_none()) {
    if (!target.mesh)
      throw std::invalid_argument("rest is an array, and the target is a file; give both as arrays, or both as files");
    target.rest = targetOf(rest, faces);
  }
  std::shared_ptr<MadeScene> made;
  doWatched(progress, resources,
            [&](Monitor& monitor) { made = makeNamedScene(recipe, std::exchange(target, {}), functions, monitor); });
  made->memory = resources.memory;
  made->device = resources.device;
  return made;
}

std::shared_ptr<MadeFit> openFit(const Recipe& recipe, const py::object& vertices, const py::object& faces,
                                 const GivenResources& resources, const py::object& progress) {
  std::shared_ptr<const vdbtools::Mesh> mesh = targetOf(vertices, faces);
  std::shared_ptr<MadeFit> fit;
  doWatched(progress, resourcesOf(resources),
            [&](Monitor& monitor) { fit = makeFit(recipe, std::exchange(mesh, {}), monitor); });
  return fit;
}

py::dict infoOfFit(const MadeFit& fit) {
  const vdbtools::fit::FitMeasure& measure = fit.result.measure;
  py::dict info;
  info["recipe"] = fit.recipe;
  info["top_roots"] = fit.result.rational.top.roots.size();
  info["bottom_roots"] = fit.result.rational.bottom.roots.size();
  info["iou"] = measure.iou;
  info["iterated_iou"] = fit.result.iteratedIou;
  info["psi"] = measure.psi;
  info["mean_distance"] = measure.meanDistance;
  info["hausdorff"] = measure.hausdorff;
  info["steps"] = fit.result.rows.size();
  return info;
}

/// An array over memory that @a owner keeps alive. It is read-only, because write() writes the same memory to files.
template <class Number, class Triple>
py::array viewOf(const std::vector<Triple>& triples, const py::object& owner) {
  static_assert(sizeof(Triple) == 3 * sizeof(Number));
  py::array_t<Number> array({static_cast<py::ssize_t>(triples.size()), py::ssize_t{3}},
                            reinterpret_cast<const Number*>(triples.data()), owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

template <class Number, class Triple>
py::cpp_function viewGetter(std::vector<Triple> vdbtools::Mesh::*member) {
  return py::cpp_function(
      [member](const py::object& self) { return viewOf<Number>(self.cast<const MadeFractal&>().mesh.*member, self); });
}

/// The attributes of vertices by their names, over memory that @a self keeps alive.
py::dict attributesOf(const py::object& self) {
  const auto& fractal = self.cast<const MadeFractal&>();
  const std::vector<vdbtools::VertexColumn> columns =
      vdbtools::meshColumns(fractal.made->scene.options.output.attributes);
  const auto points = static_cast<py::ssize_t>(fractal.mesh.points.size());
  const auto row = static_cast<py::ssize_t>(vdbtools::rowLength(columns) * sizeof(float));
  py::dict attributes;
  const float* first = fractal.values.data();
  for (const vdbtools::VertexColumn& column : columns) {
    const auto components = static_cast<py::ssize_t>(vdbtools::componentsOf(column.kind));
    std::vector<py::ssize_t> shape = {points}, strides = {row};
    if (components > 1) {
      shape.push_back(components);
      strides.push_back(sizeof(float));
    }
    py::array_t<float> array(shape, strides, first, self);
    array.attr("setflags")(py::arg("write") = false);
    attributes[py::str(column.name)] = array;
    first += components;
  }
  return attributes;
}

py::array render(const MadeScene& made, const Recipe& view, const py::object& progress,
                 const std::optional<int>& threads) {
  vdbtools::Image image;
  doWatched(progress, resourcesFor(made, threads), [&](Monitor& monitor) { image = pictureOf(made, view, monitor); });
  const std::vector<std::uint8_t> codes = vdbtools::screenCodes(image);
  return py::array_t<std::uint8_t>({image.height, image.width, 3}, codes.data());
}

py::dict infoOf(const MadeFractal& fractal) {
  const vdbtools::Scene& scene = fractal.made->scene;
  py::dict info;
  info["recipe"] = fractal.made->recipe;
  info["facts"] = scene.metadata;
  info["metadata"] = vdbtools::sceneMetadata(scene, fractal.made->recipe);
  info["voxel_size"] = scene.voxelSize;
  info["vertices"] = fractal.mesh.points.size();
  info["triangles"] = fractal.mesh.triangles.size();
  info["evaluated_nodes"] = fractal.result.evaluatedNodes;
  if (fractal.result.solid) {
    info["islands"] = fractal.result.solid->islands.size();
    info["volume"] = fractal.result.solid->volume;
  }
  if (const std::optional<vdbtools::CrumbReport>& crumbs = fractal.result.crumbs) {
    info["crumbs"] = crumbs->crumbs;
    info["crumb_volume"] = static_cast<double>(crumbs->nodes) * scene.voxelSize * scene.voxelSize * scene.voxelSize;
  }
  if (scene.target) info["target_volume"] = scene.target->volume;
  return info;
}

py::tuple boundsOf(const MadeScene& made) {
  openvdb::BBoxd box;
  {
    const py::gil_scoped_release release;  // a versor may be a function of Python
    box = vdbtools::pictureRegion(made.scene);
  }
  const auto corner = [](const Vec3d& at) { return py::make_tuple(at[0], at[1], at[2]); };
  return py::make_tuple(corner(box.min()), corner(box.max()));
}

py::list listingOf(const vdbtools::OptionTable& table) {
  py::list list;
  for (const vdbtools::OptionListing& option : table.listing())
    list.append(py::make_tuple(option.name, option.argument, option.help));
  return list;
}

py::list listedDevices() {
  std::string refusal;
  std::vector<std::shared_ptr<const julia::Device>> devices;
  {
    const py::gil_scoped_release free;
    devices = julia::openDevices({}, refusal);
  }
  py::list list;
  for (const auto& device : devices) {
    const julia::DeviceInfo& info = device->info();
    py::dict entry;
    entry["name"] = info.name;
    entry["gpu"] = info.isGpu;
    entry["doubles"] = info.doubles;
    entry["refusal"] = info.refusal;
    list.append(entry);
  }
  return list;
}

PyObject* theDataError = nullptr;  ///< juliavdb.DataError, which the module holds

void translate(std::exception_ptr failure) {
  const auto raise = [](PyObject* type, const std::string& text) {
    PyErr_SetString(type, inPythonsWords(text).c_str());
  };
  try {
    if (failure) std::rethrow_exception(failure);
  } catch (const vdbtools::DataError& error) {
    raise(theDataError, vdbtools::failureText(error));
  } catch (const vdbtools::MissingInputError& error) {
    raise(PyExc_FileNotFoundError, error.what());
  } catch (const vdbtools::CreateError& error) {
    raise(PyExc_OSError, error.what());
  } catch (const vdbtools::IoError& error) {
    raise(PyExc_OSError, error.what());
  } catch (const vdbtools::DeviceError& error) {
    raise(PyExc_RuntimeError, error.what());
  } catch (const vdbtools::Interrupted& error) {
    raise(PyExc_KeyboardInterrupt, error.what());
  } catch (const vdbtools::MemoryError& error) {
    const bool isOurs = error.use() != vdbtools::MemoryUse::Libraries;
    raise(PyExc_MemoryError, vdbtools::failureText(error) + (isOurs ? "; --memory sets another limit" : ""));
  } catch (const std::bad_alloc&) {
    raise(PyExc_MemoryError, vdbtools::kOutOfMemory);
  } catch (const std::invalid_argument& error) {
    raise(PyExc_ValueError, error.what());
  }
}

}  // namespace

std::shared_ptr<const vdbtools::Mesh> targetOf(const py::object& vertices, const py::object& faces) {
  if (vertices.is_none()) return nullptr;
  // Points alone; the Python code has checked that they have a radius.
  const py::array all =
      faces.is_none() ? py::array(py::array_t<std::int64_t>(std::vector<py::ssize_t>{0, 3})) : arrayOf(faces, "faces");
  return meshOf(arrayOf(vertices, "vertices"), all);
}

int threadsOf(const std::optional<int>& threads) {
  if (threads && *threads < 1)
    throw std::invalid_argument("threads is " + std::to_string(*threads) + "; it must be 1 or more, or None");
  return threads.value_or(0);
}

Resources resourcesOf(const GivenResources& given) {
  const auto& [text, threads, device] = given;
  Resources resources{.threads = threadsOf(threads), .device = device.value_or("")};
  const char* const usual = std::getenv("JULIAVDB_MEMORY");
  if (!text && !usual) return resources;
  const std::string value = text.value_or(usual ? usual : "");
  resources.memory = vdbtools::memoryFromText(value);
  if (!resources.memory)
    throw std::invalid_argument((text ? "--memory is '" : "JULIAVDB_MEMORY is '") + value + "'; it must be " +
                                vdbtools::kMemoryTexts);
  return resources;
}

PYBIND11_MODULE(_juliavdb, m) {
  theDataError = PyErr_NewExceptionWithDoc(
      "juliavdb.DataError", "The input was read, but cannot be used: truncated, leaky, empty, not finite.",
      PyExc_ValueError, nullptr);
  if (!theDataError) throw py::error_already_set();
  m.attr("DataError") = py::reinterpret_borrow<py::object>(theDataError);
  py::register_exception_translator(translate);

  m.def("current_name", &vdbtools::currentName);
  m.def("options", [] { return listingOf(vdbtools::fractalOptionTable()); });
  m.def("fit_options", [] { return listingOf(vdbtools::fit::fitOptionTable()); });
  m.def("view_options", [] { return listingOf(viewTable()); });
  m.def("check_view", checkView);
  m.def("devices", listedDevices);
  m.def("trust_importer", vdbtools::trustImporter);
  m.def("use_device", useDevice);
  m.def("sdf_options", [] { return listingOf(vdbtools::sdfOptionTable()); });
  m.attr("version") = JULIAVDB_VERSION;
  addFitParts(m);
  addGrids(m);

  py::class_<MadeScene, std::shared_ptr<MadeScene>> scene(m, "Scene");
  addFieldMethods(scene);
  addStudies(m, scene);
  scene.def(py::init(&openScene))
      .def("render", render)
      .def("fractal",
           [](const std::shared_ptr<MadeScene>& made, bool wantGrids, const py::object& progress,
              const std::optional<int>& threads) {
             std::shared_ptr<MadeFractal> fractal;
             doWatched(progress, resourcesFor(*made, threads),
                       [&](Monitor& monitor) { fractal = makeFractal(made, wantGrids, monitor); });
             return fractal;
           })
      .def_property_readonly("bounds", boundsOf)
      .def_property_readonly("metadata",
                             [](const MadeScene& made) { return vdbtools::sceneMetadata(made.scene, made.recipe); })
      .def_property_readonly("recipe", [](const MadeScene& made) { return made.recipe; });

  py::class_<MadeFractal, std::shared_ptr<MadeFractal>>(m, "Fractal", py::dynamic_attr(),
                                                        "A fractal in memory, as fractal() makes it.")
      .def_property_readonly("vertices", viewGetter<double>(&vdbtools::Mesh::points),
                             "The vertices, (n, 3) float64, in the target's units. It cannot be written to; copy it to "
                             "change it.")
      .def_property_readonly("faces", viewGetter<std::uint32_t>(&vdbtools::Mesh::triangles),
                             "The triangles, (m, 3) uint32, as indices of vertices; counter-clockwise from outside.")
      .def_property_readonly("normals", viewGetter<float>(&vdbtools::Mesh::normals),
                             "The outward normals at the vertices, (n, 3) float32, of unit length.")
      .def_property_readonly("attributes", py::cpp_function(attributesOf),
                             "A dict of what attributes=, colour= and transfer= asked for: float32 arrays (n,), (n, 2) "
                             "or (n, 3), one row a vertex. Colours (Cd) are linear RGB.")
      .def_property_readonly("info", infoOf,
                             "A dict: recipe (the options), facts (what was found on the way), metadata (what files "
                             "hold of both), voxel_size, vertices, triangles, evaluated_nodes, and, where they are "
                             "known, islands, volume, target_volume, and of the crumbs that were dropped crumbs and "
                             "crumb_volume.")
      .def("_write", [](MadeFractal& fractal, const std::vector<std::string>& paths, const py::object& progress,
                        const std::optional<int>& threads) {
        std::vector<std::string> warnings;
        doWatched(progress, resourcesFor(*fractal.made, threads),
                  [&](Monitor& monitor) { warnings = writeFiles(fractal, paths, monitor); });
        for (const std::string& warning : warnings)
          if (PyErr_WarnEx(PyExc_RuntimeWarning, warning.c_str(), 1) != 0) throw py::error_already_set();
      });

  py::class_<MadeFit, std::shared_ptr<MadeFit>>(m, "Fit", "A rational map in the shape of a target, as fit() makes it.")
      .def(py::init(&openFit))
      .def_property_readonly("info", infoOfFit,
                             "A dict: recipe, top_roots, bottom_roots, steps, and how well the map fits: iou after one "
                             "iteration and iterated_iou after iterations=, or after four where that is one, psi, "
                             "mean_distance and hausdorff, the distances in shares of the longest side.")
      .def("_write", [](const MadeFit& fit, const std::string& path, const py::object& progress) {
        doWatched(progress, {}, [&](Monitor& monitor) { writeFit(fit, path, monitor); });
      });
}
