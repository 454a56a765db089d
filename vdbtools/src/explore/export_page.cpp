// SPDX-License-Identifier: Apache-2.0
#include "explore/export_page.h"

#include "base/base64.h"
#include "explore/look_data.h"
#include "explore/scene_data.h"
#include "vdbtools/base/errors.h"
#include "vdbtools/explore/embedded_page.h"

#include <zlib.h>

#include <optional>
#include <set>
#include <stdexcept>
#include <string_view>
#include <utility>

namespace vdbtools::explore {
namespace {

using nlohmann::json;

std::string_view pageFile(std::string_view name) {
  const PageFile* file = findPageFile(name);
  if (!file) throw std::logic_error("the page has no file '" + std::string(name) + "'");
  return file->bytes;
}

/// The text with its only occurrence of @a what replaced. @a what must occur.
std::string replaced(const std::string& text, std::string_view what, const std::string& by) {
  const std::size_t at = text.find(what);
  if (at == std::string::npos) throw std::logic_error("index.html has no '" + std::string(what) + "'");
  return text.substr(0, at) + by + text.substr(at + what.size());
}

/// JSON for a script element, in which no text can end the element.
std::string inScript(const json& value) {
  std::string text;
  for (const char c : value.dump()) {
    if (c == '<')
      text += "\\u003c";
    else
      text.push_back(c);
  }
  return text;
}

/// Compresses to zlib's format, which DecompressionStream("deflate") reads.
std::string deflated(const std::string& bytes) {
  std::string result(compressBound(static_cast<uLong>(bytes.size())), '\0');
  uLongf size = static_cast<uLongf>(result.size());
  if (compress2(reinterpret_cast<Bytef*>(result.data()), &size, reinterpret_cast<const Bytef*>(bytes.data()),
                static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION) != Z_OK)
    throw std::runtime_error("the volume could not be compressed");
  result.resize(size);
  return result;
}

void appendModule(std::string_view name, std::set<std::string_view>& done, std::string& script) {
  if (!done.insert(name).second) return;
  const std::string_view text = pageFile(name);
  std::string own;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = std::min(text.find('\n', at), text.size() - 1) + 1;
    std::string_view line = text.substr(at, end - at);
    at = end;
    if (line.starts_with("import ")) {
      const std::size_t from = line.find("\"./"), to = line.rfind('"');
      if (from == std::string_view::npos || to < from + 3)
        throw std::logic_error("an import of '" + std::string(name) + "' is not in one line");
      appendModule(line.substr(from + 3, to - from - 3), done, script);
      continue;
    }
    constexpr std::string_view kExport = "export ";
    if (line.starts_with(kExport)) line.remove_prefix(kExport.size());
    own += line;
  }
  script += own;
}

/// The options of the light and the material that the page sent as {look: {options}}; null if it sent none.
json optionsOf(const json& page) {
  if (!page.is_object()) return {};
  const json look = page.value("look", json());
  return look.is_object() ? look.value("options", json()) : json();
}

/// The scene's own colouring, and all others, by the texts of --colour.
json colourings(const Scene& scene, Monitor& monitor) {
  json all = json::object();
  if (const std::optional<ColourChoice>& own = scene.options.output.attributes.colour)
    all["own"] = colouringData(scene, *own, monitor);
  for (const auto& [name, by] : {std::pair("trap", FieldColour::Trap), std::pair("iterations", FieldColour::Iterations),
                                 std::pair("depth", FieldColour::Depth)})
    if (by != FieldColour::Depth || scene.target) all[name] = colouringData(scene, {.by = by}, monitor);
  return all;
}

}  // namespace

std::string bundledScript() {
  std::set<std::string_view> done;
  std::string script;
  appendModule("main.js", done, script);
  return script;
}

std::string exportPage(const Scene& scene, const Recipe& recipe, const json& look, Monitor& monitor) {
  constexpr int kSide = 160;
  const SceneData data = sceneData(scene, {.side = kSide}, monitor);
  const json start = {{"exported", true},
                      {"version", JULIAVDB_VERSION},
                      {"recipe", recipe},
                      {"look", look},
                      {"lookData", lookData(lookTexts({{"look", optionsOf(look)}}))},
                      {"materials", materialData()},
                      {"looks", lookOptionData()},
                      {"colourings", colourings(scene, monitor)},
                      {"scene", data.description}};
  monitor.throwIfCancelled();
  std::string page(pageFile("index.html"));
  page = replaced(page, "<link rel=\"stylesheet\" href=\"page/style.css\">",
                  "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; script-src "
                  "'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:; connect-src 'self'\">\n<style>\n" +
                      std::string(pageFile("style.css")) + "</style>");
  return replaced(page, "<script type=\"module\" src=\"page/main.js\"></script>",
                  "<script type=\"application/json\" id=\"exported\">" + inScript(start) +
                      "</script>\n<script type=\"text/plain\" id=\"exported-volume\">" +
                      base64(deflated(data.volume + data.grain)) + "</script>\n<script type=\"module\">\n" +
                      bundledScript() + "</script>");
}

}  // namespace vdbtools::explore
