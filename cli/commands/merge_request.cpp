// SPDX-License-Identifier: Apache-2.0
#include "merge_request.h"

#include "grid_file.h"

#include "vdbtools/files/file_bytes.h"

#include <stdexcept>
#include <utility>

namespace po = boost::program_options;

namespace cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMostPoints = "most-points";

fs::path nameWith(const CommandLine& line, const char* option, bool vdbtools::FileFormat::*fact) {
  const vdbtools::FileFormat* const format = vdbtools::findFormat(line.text(option));
  if (!format || !(format->*fact)) line.refuse(option, "a name that ends in " + vdbtools::extensionsOf(fact));
  vdbtools::requireBuilt(*format);
  return line.text(option);
}

fs::path jsonName(const CommandLine& line, const char* option) {
  if (vdbtools::lowerExtension(line.text(option)) != ".json") line.refuse(option, "a name that ends in .json");
  return line.text(option);
}

}  // namespace

void addMergeOptions(CommandLine& line) {
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("F.vdb"), gridsHelp().c_str())(
      "mesh", text("F.ply"),
      ("the mesh to write: " + vdbtools::extensionsOf(&vdbtools::FileFormat::writesMesh)).c_str())(
      "index", text("F.json"), "writes each tile as files of its own, and this list of them")(
      "counts", text("F.json"), "of a plan with --make count: how many points and triangles there are")(
      kMostPoints, text("N")->default_value(std::to_string(vdbtools::farm::kMostMeshPoints)),
      "the most points that one mesh file is to have; a larger mesh is cut into F.1.ply, F.2.ply and so on");
}

MergeRequest parseMergeRequest(const CommandLine& line) {
  MergeRequest request{
      .files = {.mostPoints = line.integer<std::uint64_t>(kMostPoints, 3, vdbtools::farm::kMostMeshPoints)}};
  if (line.has("output")) request.files.grids = nameWith(line, "output", &vdbtools::FileFormat::writesGrids);
  if (line.has("mesh")) request.files.mesh = nameWith(line, "mesh", &vdbtools::FileFormat::writesMesh);
  if (line.has("index")) request.index = jsonName(line, "index");
  if (line.has("counts")) request.counts = jsonName(line, "counts");
  if (request.counts && (request.index || request.files.grids || request.files.mesh))
    throw std::invalid_argument("--counts adds up the tiles of a plan that keeps nothing else; give it alone");
  if (request.index && (request.files.grids || request.files.mesh))
    throw std::invalid_argument("--index writes the tiles as files of their own; give it without -o and --mesh");
  if (!request.files.mesh && !line.values()[kMostPoints].defaulted())
    throw std::invalid_argument("--most-points says where a mesh is cut into several files; give it with --mesh");
  return request;
}

void requireMergeable(const std::filesystem::path& folder, const vdbtools::farm::Manifest& manifest,
                      const MergeRequest& request) {
  if (request.counts)
    vdbtools::farm::requireCounts(folder, manifest, *request.counts);
  else if (request.index)
    vdbtools::farm::requireMergeable(folder, manifest, *request.index);
  else
    vdbtools::farm::requireMergeable(folder, manifest, request.files);
}

std::vector<std::string> mergeWords(const CommandLine& line) {
  std::vector<std::string> words;
  for (const auto& [option, word] : {std::pair("output", "-o"), std::pair("mesh", "--mesh"),
                                     std::pair("index", "--index"), std::pair("counts", "--counts")})
    if (line.has(option)) {
      words.emplace_back(word);
      words.push_back(fs::absolute(line.text(option)).lexically_normal().string());
    }
  if (!line.values()[kMostPoints].defaulted()) {
    words.push_back(std::string("--") + kMostPoints);
    words.push_back(line.text(kMostPoints));
  }
  return words;
}

}  // namespace cli
