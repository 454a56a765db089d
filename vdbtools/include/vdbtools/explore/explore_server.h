// SPDX-License-Identifier: Apache-2.0
/// @file explore_server.h
/// The server of `juliavdb explore`: one page for one target, on this machine.
///
/// The address contains a random key of 128 bits; requests without it are answered 404. The paths below are relative to
/// this address. Bodies and answers are JSON unless stated otherwise, and an error is {"error": one line}. A *recipe*
/// is an object of names and values of options of `juliavdb fractal`, all as text, not completed.
///
///     GET    page/NAME   a file of the page; the address itself is page/index.html
///     GET    start       what the page needs to know at first: options, maps, textures, the target, the first recipe
///     POST   scene       {recipe, wait, side}: the scene's data (explore/scene_data.h), its volume with at most
///                        `side` nodes along an axis. One scene is made at a time; a request that still waits when a
///                        later one comes is answered 409, unless it has "wait": true
///     GET    volume/ID   the exponent of one of the latest scenes, by the ID in its data
///     GET    target      the target's surface: the numbers of points and triangles (32 bits each), three floats
///                        for each point, in shares of the longest side of the target's box, about its middle, and
///                        three 32-bit indices for each triangle; all little-endian
///     POST   picture     {recipe, view: {eye, lookAt, up, fov}, width, height, samples, colour, look}: a PNG by the
///                        renderer of `juliavdb render --field`; a look is an object of the options of the material
///                        and the light, all text. With {mesh: true, resolution} of the mesh that `fractal` makes. A
///                        connection that is dropped cancels it
///     POST   look        {look}: the numbers behind its texts (explore/look_data.h)
///     POST   colouring   {recipe}: its colours on its scene, with the range of the gradient
///     POST   advice      {recipe, resolution}: {finer}, a sentence about what is finer than the voxels, or ""
///     POST   made        {job, view, width, height, samples, look}: a PNG of the mesh, or else the level set, that a
///                        job has made
///     POST   make        {recipe, name, formats, resolution, overwrite}: {job}
///     GET    jobs        [{job, name, state, phase, share, left, files, error, recipe}]
///     DELETE jobs/N      cancels a job
///     POST   recipe      the first bytes of a file that this program made, its name in the query "name": {recipe,
///                        note}
///     POST   command     {recipe, name, formats, resolution}: {command}, for a POSIX shell: a line, and another one
///                        for each mesh beyond the first. With a view, and the other entries of a picture, also
///                        {picture}: the command of that picture
///     POST   sequence    {keys: [{frame, recipe}], ease, name, resolution, frame}: {frames, command}, the command of
///                        `juliavdb plan frames`; with a frame also its recipe. What is no number changes in steps
///     POST   export      {recipe, look}: the page of --export
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/files/input_files.h"
#include "vdbtools/recipe/option_table.h"

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace vdbtools::explore {

/// Estimates how much of a job is done from the phases that it goes through.
class WorkShare {
 public:
  virtual ~WorkShare() = default;
  virtual void begin(const Phase& phase) = 0;
  /// The share that is done, from 0 to 1. @param fraction  the done part of the current phase
  virtual double at(double fraction) = 0;
};
using MakeShare = std::function<std::unique_ptr<WorkShare>()>;

struct ExploreOptions {
  Recipe given;         ///< the recipe of the command line: the page starts with it, and may use only its files
  InputFiles inputs{};  ///< other files that were read; the page replaces neither these nor the files of the recipe
  std::filesystem::path folder{};     ///< where files are written; created if necessary. Empty: the working directory
  std::string address = "127.0.0.1";  ///< where to listen: an IP address of this machine
  int port = 0;                       ///< 0: any free port
  MakeShare makeShare{};              ///< estimates the progress of jobs; empty: it is not reported
};

/// Whether only programs on this machine can reach the address. @throw std::invalid_argument  not an IP address
bool isLoopback(const std::string& address);

class ExploreServer {
 public:
  /// Makes the first scene, so that errors in the target are reported at once, and opens the port.
  /// @throw std::invalid_argument  options
  /// @throw CreateError            the folder does not exist and cannot be created, or the port cannot be opened
  /// @throw                        as makeScene()
  ExploreServer(const ExploreOptions& options, Monitor& monitor);
  ~ExploreServer();

  /// The address with its key. Whoever has it can use the page.
  std::string url() const;

  /// Serves until @a monitor is cancelled, which it checks at least twenty times a second. Then it cancels the work in
  /// progress and returns.
  void serve(const Monitor& monitor);

 private:
  class State;
  std::unique_ptr<State> mState;
};

/// The look of a recipe as one HTML file that needs no server.
/// @throw as makeScene()
std::string exportedPage(const Recipe& given, Monitor& monitor);

}  // namespace vdbtools::explore
