// SPDX-License-Identifier: Apache-2.0
// What a browser sends to 'juliavdb explore', and the files that are dropped on its page.
#include "explore/explore_session.h"
#include "explore/http_head.h"
#include "explore/made_recipe.h"
#include "harness.h"

#include "explore/shell_command.h"
#include "vdbtools/records/recorded_recipe.h"

#include <array>
#include <stdexcept>
#include <string>

namespace fuzz {
namespace {

using namespace vdbtools;
using namespace vdbtools::explore;

/// Nobody waits: what would take long ends at once.
class NoPatience final : public Monitor {
 public:
  bool cancelled() const override { return true; }
};

/// Of a recipe without a file, so that there is nothing that requests may read.
ExploreSession& session() {
  static Monitor patient;
  static ExploreSession session({.given = {{"map", "quadratic"}, {"resolution", "16"}}}, patient);
  static const bool stopped = [] {
    session.stop();  // jobs are taken, and wait for ever
    return true;
  }();
  (void)stopped;
  return session;
}

/// A line "METHOD PATH NAME", and behind it the body. Whatever it is, there is an answer, and none of a failure inside.
void readRequest(std::string_view bytes) {
  const std::string_view line = bytes.substr(0, bytes.find('\n'));
  const std::size_t first = std::min(line.find(' '), line.size());
  const std::size_t second = std::min(line.find(' ', first + 1), line.size());
  const auto part = [&](std::size_t from, std::size_t to) {
    return std::string(from < to ? line.substr(from, to - from) : std::string_view());
  };
  const ExploreRequest request{.method = part(0, first),
                               .path = part(first + 1, second),
                               .name = part(second + 1, line.size()),
                               .body = std::string(bytes.substr(std::min(line.size() + 1, bytes.size())))};
  if (request.body.size() > ExploreSession::mostBytes(request.path)) return;  // the server refuses it
  NoPatience monitor;
  const ExploreAnswer answer = session().answer(request, monitor);
  if (answer.status >= 500) throw std::logic_error("answered " + std::to_string(answer.status) + ": " + answer.body);
}

/// A file with a recipe: what the page reads of it, and what --config does.
void readMadeFile(std::string_view bytes) {
  constexpr const char* kNames[] = {"made.vdb", "made.ply", "made.obj", "made.glb", "made.txt"};
  const std::size_t choice = takeChoice(bytes, 9);
  if (choice > 4) {
    readRecordedRecipe(scratchFile(kNames[choice - 5], bytes));
    return;
  }
  const Recipe recipe = recipeOfMadeFile(kNames[choice], bytes);
  static const OptionTable table = fractalOptionTable();
  shortestRecipe(overTarget(recipe, {}), table);
}

/// A head that is accepted says the same when it is written again, so nothing of it can be taken for another line.
void readHead(std::string_view bytes) {
  const std::optional<HttpHead> head = parsedHead(bytes);
  if (!head) return;
  std::string again = head->method + ' ' + head->target + (head->old ? " HTTP/1.0\r\n" : " HTTP/1.1\r\n");
  for (const auto& [name, value] : head->fields) again += name + ':' + value + "\r\n";
  const std::optional<HttpHead> second = parsedHead(again + "\r\n");
  if (!second || second->method != head->method || second->target != head->target || second->fields != head->fields)
    throw std::logic_error("an accepted head is not the same when it is written again");
  if (!head->path().starts_with('/')) throw std::logic_error("a path without a slash: " + head->path());
  head->parameter("name");
  head->persists();
}

constexpr Harness kExploreHarnesses[] = {
    {"request", readRequest, Refusal::None},
    {"made_file", readMadeFile},
    {"http_head", readHead, Refusal::None},
};

}  // namespace

std::span<const Harness> exploreHarnesses() { return kExploreHarnesses; }

}  // namespace fuzz
