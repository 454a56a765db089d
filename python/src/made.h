// SPDX-License-Identifier: Apache-2.0
/// @file made.h
/// The objects behind the Python module: scenes, fractals and fits. Nothing here depends on Python.
#pragma once

#include "function_map.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/control/control.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/fit/fit_job.h"
#include "vdbtools/job/fractal_job.h"
#include "vdbtools/maps/map_registry.h"
#include "vdbtools/mesh/mesh.h"
#include "vdbtools/picture/image.h"
#include "vdbtools/recipe/recipe.h"

#include "julia/evaluator.h"
#include "julia/scalar_field.h"

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <vector>

/// The name of a mesh in memory in recipes.
inline constexpr const char* kMemory = "memory";

/// The parts of a scene that only queries of a field need (queries.h), each made when it is first needed.
struct FieldParts {
  std::timed_mutex mutex;
  std::optional<vdbtools::Control> distance, thickness, fullThickness, octave;
  std::shared_ptr<const julia::ScalarField<double>> exponent;
  std::unique_ptr<julia::FieldEvaluator> inDoubles;
  std::map<std::string, std::unique_ptr<julia::FieldEvaluator>> evaluators;  ///< by the choice of a device
};

/// A recipe and its scene.
struct MadeScene {
  vdbtools::Recipe recipe;  ///< completed
  vdbtools::Scene scene;
  vdbtools::InputFiles inputs;   ///< the files that were read; outputs must not replace any of them
  std::optional<double> memory;  ///< bytes that the process may use for it
  std::string device;            ///< where maps are evaluated when something is made of it, as in Resources

  /// For the first picture: the scene with FractalOptions::picture, made by whichever thread needs it first.
  vdbtools::FractalOptions options;
  mutable std::timed_mutex pictureMutex;
  mutable vdbtools::SceneMaker scenes;
  mutable std::optional<vdbtools::Scene> pictureScene;

  mutable FieldParts parts{};
};

/// Options as they were given, and their values.
struct NamedOptions {
  vdbtools::Recipe recipe;  ///< completed
  vdbtools::FractalOptions options;
};

/// The functions that a recipe refers to as "function".
struct OwnFunctions {
  vdbtools::VersorFunction versor{};
  MapFunction map{};
};

/// A target in memory.
struct MemoryTarget {
  std::shared_ptr<const vdbtools::Mesh> mesh{};
  std::shared_ptr<const vdbtools::Mesh>
      rest{};  ///< the same triangles at rest; nullptr: the recipe says what is at rest
};

/// @throw as makeNamedScene() for wrong options
NamedOptions namedOptions(const vdbtools::Recipe& given, MemoryTarget target, const OwnFunctions& functions = {});

/// @param target  if it is in memory; the recipe must then have no input
/// @throw std::invalid_argument  the options do not fit
/// @throw as vdbtools::makeScene()
std::shared_ptr<MadeScene> makeNamedScene(const vdbtools::Recipe& given, MemoryTarget target,
                                          const OwnFunctions& functions, vdbtools::Monitor& monitor);

/// @throw std::invalid_argument  an option of the view is wrong
void checkView(const vdbtools::Recipe& view);
/// The options of pictures and their defaults.
vdbtools::OptionTable viewTable();
/// A picture of the set itself, on the neutral background. Several threads may call it at once.
/// @throw as vdbtools::makeScene(), for the first picture
vdbtools::Image pictureOf(const MadeScene& made, const vdbtools::Recipe& view, vdbtools::Monitor& monitor);

/// A recipe of `juliavdb fit` and its result.
struct MadeFit {
  vdbtools::Recipe recipe;  ///< completed
  vdbtools::fit::FitResult result;
  vdbtools::InputFiles inputs;  ///< as in MadeScene
};

/// @param mesh  as for makeNamedScene()
/// @throw as vdbtools::fit::parseFitOptions() and vdbtools::fit::runFit()
std::shared_ptr<MadeFit> makeFit(const vdbtools::Recipe& given, std::shared_ptr<const vdbtools::Mesh> mesh,
                                 vdbtools::Monitor& monitor);

/// Writes the map. @throw std::invalid_argument  the extension is neither .json nor .o3d, or the file is an input
/// @throw vdbtools::CreateError, vdbtools::IoError, vdbtools::Interrupted
void writeFit(const MadeFit& fit, const std::string& path, vdbtools::Monitor& monitor);

/// A fractal in memory. Only its grids change after it was made.
struct MadeFractal {
  std::shared_ptr<const MadeScene> made;
  vdbtools::Mesh mesh;
  std::vector<float> values;       ///< of the mesh's columns, row by row
  vdbtools::FractalResult result;  ///< without the grids

  /// The grids are made by whichever thread needs them first.
  std::timed_mutex gridsMutex;
  std::shared_ptr<const vdbtools::FractalResult> grids;
};

std::shared_ptr<MadeFractal> makeFractal(std::shared_ptr<const MadeScene> made, bool wantGrids,
                                         vdbtools::Monitor& monitor);

/// Writes the fractal to files that all appear together. Grids that do not exist yet are made first, and kept. Several
/// threads may call it at once.
/// @return what the user should know of the files, one line each
/// @throw std::invalid_argument  an extension is none of .vdb, .ply, .obj, .stl and .glb; a file is an input, or given
///                               twice
/// @throw vdbtools::CreateError, vdbtools::IoError, vdbtools::Interrupted
std::vector<std::string> writeFiles(MadeFractal& fractal, const std::vector<std::string>& paths,
                                    vdbtools::Monitor& monitor);
