// SPDX-License-Identifier: Apache-2.0
#include "slice_stack.h"

#include "output.h"
#include "report.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/recipe/option_value.h"

#include <filesystem>
#include <numeric>
#include <ostream>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <utility>
#include <vector>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr const char* kStackOutput[] = {"output"};

/// The name "s.txt" for "s.####.png".
std::string textBeside(const std::string& name) {
  const std::string stem = vdbtools::stemWithoutFrame(name);
  return (std::filesystem::path(name).parent_path() / ((stem.empty() ? "stack" : stem) + ".txt")).string();
}

std::string directionText(const openvdb::Vec3d& step) {
  for (int k = 0; k < 3; ++k)
    if (step[k] != 0) return (step[k] > 0 ? "+" : "-") + std::string(1, "xyz"[k]);
  return "";
}

/// The text that describes a stack to other programs, one fact per line.
std::string stackText(const vdbtools::SliceStack& stack, const StackOptions& options,
                      std::optional<vdbtools::LengthUnit> unit, vdbtools::Axis axis, const std::string& field,
                      const std::string& values) {
  const vdbtools::SlicePlane first = stack.plane(0);
  const openvdb::Vec3d corner = first.position(0, 0);
  std::ostringstream text;
  text << "layers: " << stack.count() << "\npixels: " << first.width() << " x " << first.height()
       << "\nbits: " << options.bits << "\nfield: " << field << "\nvalues: " << values
       << "\nvoxel size: " << vdbtools::numbersText({stack.voxelSize()})
       << "\nunit: " << (unit ? nameOf(*unit) : "not known")
       << "\ncentre of the first voxel: " << vdbtools::numbersText({corner[0], corner[1], corner[2]})
       << "\nto the right: " << directionText(first.position(1, 0) - corner)
       << "\ndown: " << directionText(first.position(0, 1) - corner) << "\nto the next layer: +"
       << "xyz"[static_cast<int>(axis)] << '\n';
  return std::move(text).str();
}

/// Readers of stacks take all files with numbers, so a layer of an earlier and higher stack would be one of this stack.
/// @param next  the name of a layer after the last
/// @throw std::invalid_argument  there is such a file
void requireEnd(const std::string& next, int layers) {
  std::error_code error;
  if (!std::filesystem::exists(next, error)) return;
  throw std::invalid_argument(
      "'" + vdbtools::inOneLine(next) + "' exists, and this stack has " + std::to_string(layers) +
      " layers, so it would be taken for another one; remove the layers of the earlier stack, or "
      "choose another name");
}

}  // namespace

void addStackOptions(CommandLine& line) {
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()(
      "stack",
      "write a layer of cubic voxels as a picture each, s.0001.png and so on for -o s.####.png (or .tif), "
      "along the axis from its lowest end, and s.txt, which says the size of the voxels. --size is the "
      "number of voxels along the longer side of a layer. The numbers are data, not colours: membership "
      "is white inside; phi, e, f and grid go from 0 at -R to the largest number at R of --range; "
      "iterations are the counts")("bits", text("8|16"), "with --stack: the bits of a number (default: 8)");
}

StackOptions parseStack(const CommandLine& line, SliceField field) {
  line.requireUse(line.has("stack"), {"bits", "units"}, "it goes with --stack; give that too, or leave it out");
  StackOptions options;
  if (!line.has("stack")) return options;
  line.requireUse(false, {"position", "arrow"}, "a --stack has all positions, and no arrows; leave it out");
  if (line.has("bits")) options.bits = line.choice<int>("bits", {{"8", 8}, {"16", 16}});
  if (isSigned(field) && !line.has("range"))
    throw std::invalid_argument(
        "a --stack of this field needs --range R: all its layers go from 0 at -R to the largest number at R");
  if (isSigned(field)) options.range = line.number("range");
  return options;
}

StackWriter::StackWriter(const CommandLine& line, vdbtools::InputFiles inputs, StackOptions options)
    : mLine(line), mInputs(std::move(inputs)), mOptions(options), mText(textBeside(line.text("output"))) {
  const std::string extension = vdbtools::lowerExtension(line.text("output"));
  if (extension != ".png" && extension != ".tif" && extension != ".tiff")
    line.refuse("output", "a name that ends with .png or .tif, with --stack");
  requireFramePlaces(line, mInputs, kStackOutput, std::vector<int>{1});
  // Claims the first layer and the text for a moment.
  Outputs(line, mInputs, 1).add("output", line.text("output"), ".png .tif .tiff");
  Outputs(line, mInputs).add("output", mText, ".txt");
}

void StackWriter::write(const PlanePlacement& placement, const openvdb::BBoxd& box, const std::string& values,
                        std::optional<vdbtools::LengthUnit> unit, const LayerMaker& make) {
  const vdbtools::SliceStack stack(placement.axis, box, placement.size);
  std::vector<int> layers(static_cast<std::size_t>(stack.count()));
  std::iota(layers.begin(), layers.end(), 1);
  requireFramePlaces(mLine, mInputs, kStackOutput, layers);
  requireEnd(vdbtools::expandFrame(mLine.text("output"), stack.count() + 1), stack.count());
  // The text is written last, so an interrupted stack has none.
  Outputs text(mLine, mInputs);
  std::ostream& lines = text.add("output", mText, ".txt").stream();
  for (const int layer : layers) {
    vdbtools::NumberedMonitor monitor(mLine.progress(), "layer", static_cast<std::size_t>(layer), layers.size());
    const vdbtools::SlicePlane plane = stack.plane(layer - 1);
    const vdbtools::SliceCodes codes = make(plane, monitor);
    Outputs outputs(mLine, mInputs, layer);
    outputs.add("output", mLine.text("output"), ".png .tif .tiff").stream() << vdbtools::encodeSlice(
        codes, {.size = stack.voxelSize(), .unit = unit}, vdbtools::lowerExtension(mLine.text("output")));
    outputs.commit(/*isAll=*/false);
    report().noteKept("the finished layers are kept");
  }
  lines << stackText(stack, mOptions, unit, placement.axis, mLine.text("field"), values);
  text.commit();
  const vdbtools::SlicePlane first = stack.plane(0);
  report().count("layers", stack.count());
  report().count("width", first.width());
  report().count("height", first.height());
  report().count("voxelSize", stack.voxelSize());
  report().text() << "wrote " << stack.count() << " layers of " << first.width() << " x " << first.height()
                  << " pixels, voxels of " << vdbtools::shortText(stack.voxelSize())
                  << (unit ? std::string(" ") + nameOf(*unit) : "") << ", and " << text.names() << '\n';
}

}  // namespace cli
