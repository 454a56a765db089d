// SPDX-License-Identifier: Apache-2.0
#include "commands.h"

#include "exit_code.h"
#include "fractal_share.h"
#include "interruption.h"
#include "options.h"
#include "output.h"
#include "report.h"
#include "scene_recipe.h"

#include "vdbtools/base/errors.h"
#include "vdbtools/explore/explore_server.h"
#include "vdbtools/scene/scene.h"

#include <cerrno>
#include <csignal>
#include <iostream>
#include <ostream>

#include <fcntl.h>
#include <spawn.h>
#include <unistd.h>

namespace po = boost::program_options;

namespace cli {
namespace {

constexpr Usage kExploreUsage = {
    "explore", "MESH|SDF.vdb [--folder DIR] [--port N] [options of fractal]",
    "Serves a page on which you explore looks in the browser, live, with a slider for every option, and make the files "
    "of those that you like. The address is printed on stdout. It holds a random key, because everyone who has it can "
    "use the page. The server ends with Ctrl-C. Without a target it takes the maps that need none.",
    "  juliavdb explore bunny.obj\n"
    "  juliavdb explore bunny.obj --detail 0.6 --folder looks --port 8017\n"
    "  juliavdb explore --map mandelbulb\n"
    "  juliavdb explore bunny.obj --texture-seed 7 --export look.html\n",
    "fractal"};

/// Cancels the work when the program has to end.
class UntilInterrupted final : public vdbtools::Monitor {
 public:
  bool cancelled() const override { return interrupted(); }
};

/// Opens the page in the user's browser, if there is one.
void openBrowser(const std::string& url) {
  std::string program = "xdg-open", address = url;
  char* const arguments[] = {program.data(), address.data(), nullptr};
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    ::posix_spawn_file_actions_addopen(&actions, stream, "/dev/null", O_RDWR, 0);
  // Children would inherit the blocking of the signals that end this program. Ctrl-C must not reach the browser.
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t none;
  sigemptyset(&none);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setpgroup(&attributes, 0);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETPGROUP);
#ifdef __EMSCRIPTEN__
  constexpr int error = ENOSYS;
#else
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, program.c_str(), &actions, &attributes, arguments, environ);
#endif
  if (error != 0) report().text() << "the browser could not be started; open the address yourself\n";
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
}

int exportLook(const CommandLine& line, const vdbtools::Recipe& given, Progress& progress) {
  Outputs outputs(line, vdbtools::inputsOf(vdbtools::parseFractalOptions(given)));
  std::ostream& file = outputs.add("export", line.text("export"), ".html").stream();
  const std::string page = vdbtools::explore::exportedPage(given, progress);
  progress.begin(vdbtools::PhaseKind::Writing, 0);
  file << page;
  outputs.commit();
  report().count("bytes", page.size());
  report().text() << "wrote " << outputs.names() << ": " << page.size() << " bytes\n";
  return kDone;
}

}  // namespace

int runExplore(const Arguments& arguments) {
  CommandLine line(kExploreUsage, vdbtools::fractalOptionTable());
  const auto text = [](const char* name) { return po::value<std::string>()->value_name(name); };
  line.addOptions()("folder", text("DIR"),
                    "where the page makes files; the folder is made if need be (default: the working directory)")(
      "port", text("N"), "the port to listen at (default 0: any that is free)")(
      "bind", text("ADDRESS"),
      "the IP address to listen at (default 127.0.0.1: only programs of this machine reach it). With any other, what "
      "the "
      "page and the server say can be read on the network, the key among it")(
      "open", text("yes|no"),
      "show the page in the browser (default no: the address would stand in the list of processes, where other users "
      "of "
      "this machine see it)")(  //
      "export", text("F.html"), "write the first look as one HTML file that needs no server, and end");
  addSearchOption(line);
  if (!line.parse(arguments)) return kDone;
  const vdbtools::Recipe given = givenSceneRecipe(line, line.text("input"));
  const bool open = line.has("open") && line.choice<bool>("open", {{"yes", true}, {"no", false}});
  if (line.has("export")) {
    for (const char* option : {"folder", "port", "bind", "open"})
      if (line.has(option))
        throw std::invalid_argument(std::string("--") + option + " is for the server, and --export needs none");
    return exportLook(line, given, line.progress());
  }
  vdbtools::explore::ExploreOptions options{
      .given = given, .inputs = line.inputs(), .folder = line.text("folder"), .makeShare = [] {
        return std::make_unique<FractalShare>();
      }};
  if (line.has("port")) options.port = line.integer("port", 0, 65535);
  if (line.has("bind")) options.address = line.text("bind");
  if (!vdbtools::explore::isLoopback(options.address))
    report().text()
        << "warning: the page is served to the network, without encryption; whoever reads along has its key\n";
  auto server = std::make_unique<vdbtools::explore::ExploreServer>(options, line.progress());
  line.endProgress();
  std::cout << server->url() << std::endl;
  if (!std::cout) throw vdbtools::IoError("writing to the standard output failed");
  expectInterruption();
  if (open) openBrowser(server->url());
  server->serve(UntilInterrupted());
  server.reset();
  return kDone;
}

}  // namespace cli
