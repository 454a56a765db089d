// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/render/shaded_image.h"

#include "vdbtools/base/text.h"
#include "vdbtools/files/file_bytes.h"
#include "vdbtools/recipe/option_value.h"

#include <array>
#include <cstddef>
#include <span>
#include <utility>

namespace vdbtools {
namespace {

constexpr std::array<std::pair<const char*, Pass>, 7> kPasses = {{{"beauty", Pass::Beauty},
                                                                  {"normal", Pass::Normal},
                                                                  {"depth", Pass::Depth},
                                                                  {"albedo", Pass::Albedo},
                                                                  {"ao", Pass::Ao},
                                                                  {"id", Pass::Id},
                                                                  {"trap", Pass::Trap}}};

void addColour(std::vector<Channel>& channels, const std::array<const char*, 3>& names, const Image& image) {
  const std::size_t first = channels.size();
  for (const char* name : names) channels.push_back({name, {}});
  for (std::size_t i = 0; i < names.size(); ++i) channels[first + i].values.reserve(image.pixels.size());
  for (const Colour& pixel : image.pixels)
    for (std::size_t i = 0; i < names.size(); ++i) channels[first + i].values.push_back(pixel[i]);
}

}  // namespace

OptionSpec passesOptionSpec() {
  return {.name = "passes",
          .argument = "NAME,NAME",
          .help =
              "the layers of an EXR: beauty (R, G, B, A), normal (N.x, N.y, N.z, world space), depth (Z, along the "
              "view axis, 1e10 where there is nothing), albedo (albedo.R, .G, .B), ao (AO, the part of the sky that "
              "is not hidden), id (1 where the surface is seen) and, with --field, trap (how near the orbit comes to "
              "the origin)",
          .defaultNote = "beauty,normal,depth,id"};
}

std::set<Pass> parsePasses(const RecipeReader& reader, const std::set<Pass>& possible, const std::set<Pass>& usual) {
  if (!reader.has("passes")) return usual;
  std::set<Pass> passes{Pass::Beauty};
  std::vector<std::string> names;
  for (const auto& [name, pass] : kPasses)
    if (possible.contains(pass)) names.emplace_back(name);
  for (const std::string& word : split(reader.text("passes"), ',')) {
    bool found = false;
    for (const auto& [name, pass] : kPasses) {
      if (word != name || !possible.contains(pass)) continue;
      found = true;
      passes.insert(pass);
    }
    if (!found)
      reader.refuse("passes", "some of " + joined(names) + " here, with commas between them" + didYouMean(word, names));
  }
  return passes;
}

std::string encodeShadedImage(const ShadedImage& image, const std::string& extension, bool alpha,
                              const std::set<Pass>& passes) {
  if (!lowerCase(extension).ends_with("exr"))
    return alpha ? encodePngWithAlpha(image.beauty, image.coverage) : encodeImage(image.beauty, extension);
  std::vector<Channel> channels;
  channels.push_back({"A", image.coverage});
  if (passes.contains(Pass::Normal)) addColour(channels, {"N.x", "N.y", "N.z"}, image.normal);
  if (passes.contains(Pass::Depth)) channels.push_back({"Z", image.depth});
  if (passes.contains(Pass::Albedo)) addColour(channels, {"albedo.R", "albedo.G", "albedo.B"}, image.albedo);
  if (passes.contains(Pass::Ao)) channels.push_back({"AO", image.ao});
  if (passes.contains(Pass::Id)) channels.push_back({"id", image.id});
  if (passes.contains(Pass::Trap)) channels.push_back({"trap", image.trap});
  return encodeExr(image.beauty, channels);
}

}  // namespace vdbtools
