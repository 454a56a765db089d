// SPDX-License-Identifier: Apache-2.0
// The program of the page for browsers (docs/browser.md). It runs in a worker of the page, and answers the requests
// that the page otherwise sends to the server of 'juliavdb explore' (vdbtools/explore/explore_server.h). wasm/worker.js
// calls the three functions at the end. The files that the visitor has dropped are in the working directory.
#include "explore/explore_session.h"
#include "explore/failure_answer.h"
#include "fractal_share.h"

#include <nlohmann/json.hpp>

#include <emscripten.h>

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <utility>

namespace {

using namespace vdbtools;
using explore::ExploreAnswer;
using explore::ExploreRequest;
using explore::ExploreSession;

/// Cancels the work for a request that the page has dropped.
class Dropped final : public Monitor {
 public:
  bool cancelled() const override { return mDropped.load(std::memory_order_relaxed); }
  void drop() { mDropped = true; }

 private:
  std::atomic<bool> mDropped{false};
};

struct Program {
  std::mutex mutex;  // guards everything below
  std::shared_ptr<ExploreSession> session;
  std::map<int, std::shared_ptr<Dropped>> asked;
};

Program& program() {
  static Program& theProgram = *new Program;  // never destroyed: threads may use it until the page is closed
  return theProgram;
}

/// Sends an answer to the page. The text of the script runs in the worker's own thread.
void send(int number, const ExploreAnswer& answer) {
  MAIN_THREAD_EM_ASM(
      {
        const body = HEAPU8.slice($3, $3 + $4).buffer;
        postMessage({number : $0, status : $1, type : UTF8ToString($2), body}, [body]);
      },
      number, answer.status, answer.type.c_str(), answer.body.data(), answer.body.size());
}

ExploreAnswer failureNow() {
  const explore::FailureAnswer failure = explore::currentFailureAnswer();
  return {failure.status, "application/json", nlohmann::json{{"error", failure.text}}.dump()};
}

/// Answers by @a work on a thread of its own, so that the worker goes on to hear the page.
template <class Work>
void answer(int number, const Work& work) {
  const auto monitor = std::make_shared<Dropped>();
  {
    const std::lock_guard lock(program().mutex);
    program().asked[number] = monitor;
  }
  std::thread([=] {
    ExploreAnswer made;
    try {
      made = work(*monitor);
    } catch (...) {
      made = failureNow();
    }
    {
      const std::lock_guard lock(program().mutex);
      program().asked.erase(number);
    }
    send(number, made);
  }).detach();
}

std::shared_ptr<ExploreSession> session() {
  const std::lock_guard lock(program().mutex);
  if (!program().session) throw std::logic_error("no target was opened");
  return program().session;
}

}  // namespace

extern "C" {

/// Makes the first scene of a recipe, an object of options in JSON; later requests are about it.
EMSCRIPTEN_KEEPALIVE void juliavdb_open(int number, const char* recipe) {
  answer(number, [given = std::string(recipe)](Monitor& monitor) -> ExploreAnswer {
    explore::ExploreOptions options{.given = nlohmann::json::parse(given).get<Recipe>(),
                                    .makeShare = [] { return std::make_unique<cli::FractalShare>(); }};
    auto opened = std::make_shared<ExploreSession>(options, monitor);
    const std::lock_guard lock(program().mutex);
    program().session = std::move(opened);
    return {.body = "{}"};
  });
}

/// Answers a request of the page.
EMSCRIPTEN_KEEPALIVE void juliavdb_ask(int number, const char* method, const char* path, const char* name,
                                       const char* body, int length) {
  ExploreRequest request{method, path, name, std::string(body, static_cast<std::size_t>(length))};
  answer(number, [request = std::move(request)](Monitor& monitor) { return session()->answer(request, monitor); });
}

/// Ends the work for a request that nobody waits for any more.
EMSCRIPTEN_KEEPALIVE void juliavdb_drop(int number) {
  const std::lock_guard lock(program().mutex);
  if (const auto found = program().asked.find(number); found != program().asked.end()) found->second->drop();
}

}  // extern "C"
