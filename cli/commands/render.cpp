// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "options.h"
#include "output.h"

#include "vdbtools/preview.h"
#include "vdbtools/vdb_file.h"
#include "vdbtools/versor_file.h"

#include <charconv>
#include <iostream>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kUsageText = {"render", "F.vdb -o F.png [--size WxH] [--azimuth DEG] [--elevation DEG] [options]",
                              "Makes a shaded picture of a level set, framed by itself.",
                              "  juliavdb render bunny.vdb -o bunny.png\n"
                              "  juliavdb render bunny.vdb -o back.exr --size 1280x720 --azimuth 200 --zoom 1.5\n"};

void parseSize(const std::string& text, vdbtools::PreviewOptions& options) {
  const char* end = text.data() + text.size();
  const auto [x, error] = std::from_chars(text.data(), end, options.width);
  const bool good = error == std::errc{} && x != end && *x == 'x';
  const auto [rest, second] = good ? std::from_chars(x + 1, end, options.height) : std::from_chars_result{x, error};
  if (!good || second != std::errc{} || rest != end || options.width < 1 || options.height < 1 ||
      options.width > 32768 || options.height > 32768)
    throw std::invalid_argument("--size is '" + text + "'; it must be WIDTHxHEIGHT, each 1 to 32768");
}

std::vector<vdbtools::PreviewBall> ballsOf(const std::string& name) {
  constexpr double kRadius = 0.008;  // of the target's longest side
  const vdbtools::RationalFile file = vdbtools::readRationalFile(name);
  if (!file.target)
    throw std::invalid_argument("'" + name + "' does not say where its roots are in the world; 'juliavdb fit' does");
  const vdbtools::FractalSpace& space = file.target->space;
  std::vector<vdbtools::PreviewBall> balls;
  const auto add = [&](const julia::Polynomial& polynomial, const std::array<float, 3>& colour) {
    for (const julia::Root& root : polynomial.roots) {
      const julia::Quaternion<double>& t = root.position;
      balls.push_back({space.toWorld({t.a, t.b, t.c}), kRadius * space.scale, colour});
    }
  };
  add(file.rational.top, {0.02f, 0.12f, 0.75f});
  add(file.rational.bottom, {0.75f, 0.03f, 0.02f});
  return balls;
}

}  // namespace

int runRender(const Arguments& arguments) {
  CommandLine line(kUsageText, {});
  line.addPositional("input", 1, "the VDB");
  line.addOptions()("output,o", po::value<std::string>()->value_name("F.png"), "the picture to write: .png or .exr")(
      "grid", po::value<std::string>()->value_name("NAME"), "which grid (default: surface)")(
      "size", po::value<std::string>()->default_value("800x800")->value_name("WxH"), "pixels")(
      "azimuth", po::value<std::string>()->value_name("DEG"), "angle about the vertical, from the front")(
      "elevation", po::value<std::string>()->value_name("DEG"), "angle above the horizon")(
      "fov", po::value<std::string>()->value_name("DEG"), "vertical field of view")(
      "samples", po::value<std::string>()->value_name("N"), "rays a pixel: 1, 4, 9 or 16")(
      "zoom", po::value<std::string>()->value_name("F"), "above 1 comes closer")(
      "roots", po::value<std::string>()->value_name("F.json"),
      "show the roots of a map that 'juliavdb fit' made: the top's blue, the bottom's red");
  if (!line.parse(arguments)) return kDone;
  const std::string input = line.text("input");
  if (input.empty()) throw std::invalid_argument("no VDB was given");
  vdbtools::PreviewOptions options;
  parseSize(line.text("size"), options);
  const auto number = [&](const char* name, double& value) {
    if (line.has(name)) value = vdbtools::parseNumber(name, line.text(name));
  };
  number("azimuth", options.azimuth);
  number("elevation", options.elevation);
  number("fov", options.fieldOfView);
  number("zoom", options.zoom);
  if (line.has("samples")) {
    const double samples = vdbtools::parseNumber("samples", line.text("samples"));
    if (samples != 1 && samples != 4 && samples != 9 && samples != 16)
      throw std::invalid_argument("--samples is '" + line.text("samples") + "'; it must be 1, 4, 9 or 16");
    options.samples = static_cast<int>(samples);
  }
  if (line.has("roots")) options.balls = ballsOf(line.text("roots"));
  if (!line.has("output")) throw std::invalid_argument("no output was given; use -o F.png");
  Outputs outputs;
  std::ostream& file = outputs.add("output", line.text("output"), ".png .exr").stream();
  const auto grid = vdbtools::chooseFloatGrid(vdbtools::readVdb(input), line.text("grid"), input);
  const vdbtools::Image image = vdbtools::renderPreview(*grid, options, line.progress());
  file << vdbtools::encodeImage(image, formatOf(line.text("output"), ".png"));
  outputs.commit();
  std::cerr << "wrote " << outputs.names() << ": " << image.width << " x " << image.height << '\n';
  return kDone;
}

}  // namespace cli
