// SPDX-License-Identifier: Apache-2.0
#include "output.h"

#include "interruption.h"
#include "options.h"
#include "report.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/files/frames.h"
#include "vdbtools/files/standard_streams.h"
#include "vdbtools/formats/file_formats.h"
#include "vdbtools/mesh_files/mesh_writer.h"
#include "vdbtools/records/recorded_recipe.h"

#include <algorithm>
#include <stdexcept>
#include <utility>
#include <vector>

namespace cli {
namespace {

vdbtools::InputFiles allInputs(const CommandLine& line, vdbtools::InputFiles inputs) {
  inputs.add(line.inputs());
  return vdbtools::withRecordedFiles(std::move(inputs));
}

/// Whether @a list, as in ".vdb .ply", has an extension.
bool hasExtension(std::string_view list, std::string_view extension) {
  for (std::size_t at = 0; at < list.size();) {
    const std::size_t end = std::min(list.find(' ', at), list.size());
    if (list.substr(at, end - at) == extension) return true;
    at = end + 1;
  }
  return false;
}

/// "- is PLY and -.obj is OBJ".
std::string pipeNames() {
  std::string names;
  for (const vdbtools::FileFormat* format : vdbtools::fileFormats())
    if (format->piped)
      names += names.empty() ? "- is " + std::string(format->name)
                             : " and -" + std::string(format->extension) + " is " + std::string(format->name);
  return names;
}

}  // namespace

std::string meshHelp() {
  return "the mesh to write: " + vdbtools::extensionsOf(&vdbtools::FileFormat::writesMesh) +
         "; on the standard output, " + pipeNames();
}

bool isStandardOutput(const std::string& name) {
  if (!name.starts_with('-')) return false;
  const vdbtools::FileFormat* const format = vdbtools::findFormat(name);
  return name == vdbtools::kStandardStream || (format && format->piped && name.substr(1) == format->extension);
}

Outputs::Outputs(const CommandLine& line, vdbtools::InputFiles inputs, std::optional<int> frame)
    : mFrame(frame), mFiles(allInputs(line, std::move(inputs))) {}

vdbtools::AtomicFile& Outputs::add(const std::string& option, const std::string& name, std::string_view extensions) {
  if (isStandardOutput(name)) {
    // The formats of the pipes between programs; the others are for files.
    if (!hasExtension(extensions, formatOf(name, "")))
      throw std::invalid_argument("--" + option + " is '" + name + "'; on the standard output " + pipeNames() +
                                  ", and this is a file of " + std::string(extensions));
    vdbtools::AtomicFile& file = mFiles.addStandardOutput();
    report().making(file.target(), mFiles.files().size() == 1);
    return file;
  }
  const std::filesystem::path path = vdbtools::expandFrame(name, mFrame);
  const bool known = hasExtension(extensions, vdbtools::lowerExtension(path));
  // Devices such as /dev/null have no extension and accept any content.
  if (!known && !(std::filesystem::exists(path) && !std::filesystem::is_regular_file(path)))
    throw std::invalid_argument("--" + option + " is '" + name + "'; its extension must be one of " +
                                std::string(extensions));
  vdbtools::AtomicFile& file = mFiles.add(path);
  report().making(file.target(), mFiles.files().size() == 1);
  return file;
}

vdbtools::AtomicFile& Outputs::add(const std::string& option, const std::string& name,
                                   bool vdbtools::FileFormat::*fact) {
  return add(option, name,
             vdbtools::formatTexts(vdbtools::fileFormats(), fact, &vdbtools::FileFormat::extension, " ", " "));
}

void Outputs::commit(bool isAll) {
  // This may take as long as the disk does, and can be interrupted.
  mFiles.finish();
  const Placing placing;
  mFiles.commit();
  for (const vdbtools::AtomicFile& file : mFiles.files()) report().wrote(file.target());
  if (isAll) workIsDone();
}

std::string Outputs::names() const {
  return vdbtools::joined(mFiles.files(), ", ",
                          [](const vdbtools::AtomicFile& file) { return file.target().string(); });
}

void requireFramePlaces(const CommandLine& line, vdbtools::InputFiles inputs, std::span<const char* const> options,
                        std::span<const int> frames) {
  vdbtools::OutputPlaces places(allInputs(line, std::move(inputs)));
  for (const int frame : frames)
    for (const char* option : options)
      if (line.has(option) && isStandardOutput(line.text(option)))
        throw std::invalid_argument(std::string("--") + option + " is '" + line.text(option) +
                                    "', and a sequence has a file for each frame; give it a name such as out.####.ply");
      else if (line.has(option))
        places.claim(vdbtools::expandFrame(line.text(option), frame));
}

std::string formatOf(const std::string& name, const char* usual) {
  if (name == vdbtools::kStandardStream)
    for (const vdbtools::FileFormat* format : vdbtools::fileFormats())
      if (format->piped) return std::string(format->extension);
  const std::string extension = vdbtools::lowerExtension(name);
  return extension.empty() ? usual : extension;
}

void noteLeftOut(const std::filesystem::path& file, std::span<const vdbtools::VertexColumn> columns) {
  const vdbtools::FileFormat* const format = vdbtools::findFormat(file.native());
  if (!format) return;
  const std::vector<std::string> names = vdbtools::columnsLeftOut(*format, columns);
  if (names.empty()) return;
  const bool grids = format->writesGrids;
  report().text() << "note: " << file.string() << " holds no "
                  << (names.size() == columns.size() && !grids ? "attributes" : vdbtools::joined(names))
                  << (grids ? "" : "; a PLY holds all") << '\n';
}

void tellCrumbs(const vdbtools::CrumbReport& dropped, double voxelSize, std::optional<double> left, bool counts) {
  const double volume = static_cast<double>(dropped.nodes) * voxelSize * voxelSize * voxelSize;
  if (counts) {
    report().count("crumbs", dropped.crumbs);
    report().count("crumbVolume", volume);
  }
  if (dropped.crumbs == 0) return;
  report().text() << ", " << dropped.crumbs << (dropped.crumbs == 1 ? " crumb" : " crumbs") << " of " << dropped.nodes
                  << (dropped.nodes == 1 ? " voxel" : " voxels");
  if (left) report().text() << ", " << vdbtools::shortText(100 * volume / (*left + volume)) << " % of the volume,";
  report().text() << " dropped";
}

std::optional<int> parseFrame(const std::string& text) {
  if (text.empty()) return std::nullopt;
  const std::optional<int> frame = vdbtools::wholeFromText<int>(text);
  if (!frame) throw std::invalid_argument("--frame is '" + text + "'; it must be a whole number");
  return frame;
}

std::set<vdbtools::Product> productsOf(const CommandLine& line) {
  std::vector<std::string> extensions;
  if (line.has("output")) extensions.push_back(formatOf(line.text("output"), ".vdb"));
  if (line.has("mesh")) extensions.push_back(formatOf(line.text("mesh"), ".ply"));
  return vdbtools::productsOf(extensions);
}

std::set<vdbtools::Product> productsOf(const std::vector<std::string>& makes) {
  std::vector<std::string> extensions;
  for (const std::string& format : makes) extensions.push_back('.' + format);
  return vdbtools::productsOf(extensions);
}

}  // namespace cli
