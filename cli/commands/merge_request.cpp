// SPDX-License-Identifier: Apache-2.0
#include "merge_request.h"

#include "output.h"

#include "vdbtools/files/file_bytes.h"
#include "vdbtools/mesh_files/mesh_writer.h"

#include <stdexcept>
#include <string_view>
#include <utility>

namespace po = boost::program_options;

namespace cli {
namespace {

namespace fs = std::filesystem;

constexpr const char* kMostPoints = "most-points";

fs::path nameWith(const CommandLine& line, const char* option, std::string_view extensions) {
  const std::string extension = vdbtools::lowerExtension(line.text(option));
  if (extension.empty() || (' ' + std::string(extensions) + ' ').find(' ' + extension + ' ') == std::string::npos)
    line.refuse(option, "a name that ends in one of " + std::string(extensions));
  return line.text(option);
}

}  // namespace

void addMergeOptions(CommandLine& line) {
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("output,o", text("F.vdb"), "the VDB to merge the tiles into")(
      "mesh", text("F.ply"), "the mesh to write: .ply, .obj, .stl or .glb")(
      "index", text("F.json"), "writes each tile as files of its own, and this list of them")(
      "counts", text("F.json"), "of a plan with --make count: how many points and triangles there are")(
      kMostPoints, text("N")->default_value(std::to_string(vdbtools::farm::kMostMeshPoints)),
      "the most points that one mesh file is to have; a larger mesh is cut into F.1.ply, F.2.ply and so on");
}

MergeRequest parseMergeRequest(const CommandLine& line) {
  MergeRequest request{
      .files = {.mostPoints = line.integer<std::uint64_t>(kMostPoints, 3, vdbtools::farm::kMostMeshPoints)}};
  if (line.has("output")) request.files.vdb = nameWith(line, "output", ".vdb");
  if (line.has("mesh")) request.files.mesh = nameWith(line, "mesh", vdbtools::kMeshExtensions);
  if (line.has("index")) request.index = nameWith(line, "index", ".json");
  if (line.has("counts")) request.counts = nameWith(line, "counts", ".json");
  if (request.counts && (request.index || request.files.vdb || request.files.mesh))
    throw std::invalid_argument("--counts adds up the tiles of a plan that keeps nothing else; give it alone");
  if (request.index && (request.files.vdb || request.files.mesh))
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
