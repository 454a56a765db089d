// SPDX-License-Identifier: Apache-2.0
#include "commands/commands.h"
#include "commands/plan.h"
#include "exit_code.h"
#include "failure.h"
#include "help_output.h"
#include "interruption.h"
#include "report.h"

#include "vdbtools/base/text.h"

#include "julia/device/device.h"

#include <algorithm>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include <unistd.h>

namespace cli {
namespace {

const Command kCommands[] = {
    {"sdf", runSdf, "make a signed distance field (VDB) from a mesh"},
    {"fractal", runFractalCommand, "make a fractal (VDB, mesh) from a mesh or a signed distance field"},
    {"fit", runFit, "find a rational map whose Julia set has the shape of a mesh"},
    {"mesh", runMesh, "make a mesh from a VDB"},
    {"convert", runConvert, "write the grids of a VDB as NanoVDB"},
    {"points", runPoints, "spread oriented points over a surface"},
    {"print", runPrint, "make a part for 3D printing: one closed piece, in millimetres, with a minimum wall thickness"},
    {"versor", runVersor, "make, inspect and change versors, the texture of a fractal"},
    {"sheet", runSheet, "make a contact sheet: a picture for each value of one or two options"},
    {"slice", runSlice, "make a picture of a field on a plane"},
    {"study", runStudy, "show what holds for every texture: average membership, distance over circles"},
    {"render", runRender, "make a shaded picture of a level set, or of a map's set"},
    {"explore", runExplore, "explore looks in the browser"},
    {"plan", runPlan, "plan the tasks of a farm: tiles of a fractal, frames, or cells of a contact sheet", planKinds},
    {"task", runTask, "make one of the tasks that a large job was cut into"},
    {"status", runStatus, "show which tasks of a plan are done, and which are missing"},
    {"submit", runSubmit, "give the missing tasks of a plan to Slurm or GNU parallel"},
    {"merge", runMerge, "put the tiles of a plan together into one VDB and one mesh"},
    {"usd", runUsd, "write a scene of USD beside VDBs and a mesh"},
    {"info", runInfo, "show what is in a mesh, a VDB or a versor file"},
    {"recipe", runRecipe, "write the recipe that a file holds as a file of its own"},
    {"maps", runMaps, "list the maps and their options"},
    {"devices", runDevices, "list the devices of OpenCL on which maps can be evaluated"},
    {"man", runMan, "write the manual pages"},
    {"completion", runCompletion, "write the completion of command lines for a shell"},
};

std::string helpText() {
  std::ostringstream stream;
  stream << "Usage: juliavdb COMMAND [options]\n\n"
            "Turns a mesh into a fractal of the same shape.\n\nCommands:\n";
  for (const Command& command : commands())
    stream << "  " << command.name << std::string(12 - std::string_view(command.name).size(), ' ') << command.summary
           << '\n';
  stream << "\n"
            "'juliavdb COMMAND --help' describes a command. 'juliavdb --version' prints the version.\n";
  return stream.str();
}

const Command* findCommand(const std::string& name) {
  for (const Command& command : commands())
    if (name == command.name) return &command;
  return nullptr;
}

[[noreturn]] void refuseCommand(const std::string& name) {
  std::vector<std::string> names;
  for (const Command& command : commands()) names.emplace_back(command.name);
  throw std::invalid_argument("'" + name + "' is not a command; 'juliavdb --help' lists them" +
                              vdbtools::didYouMean(name, names));
}

/// 'juliavdb help fractal detail' is 'juliavdb fractal --help detail'.
int runHelp(const Arguments& topics) {
  if (topics.empty()) {
    writeHelp(helpText());
    return kDone;
  }
  const Command* const command = findCommand(topics.front());
  if (!command) refuseCommand(topics.front());
  Arguments words{"--help"};
  std::size_t next = 1;
  for (const Command& part : command->parts())
    if (topics.size() > 1 && topics[1] == part.name) {
      words.insert(words.begin(), topics[1]);
      next = 2;
    }
  words.insert(words.end(), topics.begin() + static_cast<std::ptrdiff_t>(next), topics.end());
  return command->run(words);
}

int run(const Arguments& arguments) {
  if (arguments.empty()) {
    std::cerr << helpText();
    return kUsage;
  }
  const std::string& name = arguments.front();
  if (name == "--help" || name == "-h" || name == "help") {
    return runHelp(Arguments(arguments.begin() + 1, arguments.end()));
  }
  if (name == "--version") {
    std::cout << "juliavdb " << JULIAVDB_VERSION << '\n';
    return kDone;
  }
  if (const Command* const command = findCommand(name))
    return command->run(Arguments(arguments.begin() + 1, arguments.end()));
  refuseCommand(name);
}

/// Reports a failure in one line, even if the text has several.
int fail(int code, std::string text) {
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  takeLastWord(code);
  report().end(code, text);
  return code;
}

/// Reports the exception that is being handled. Memory may be too short even for that.
int failNow() noexcept {
  try {
    const Failure failure = currentFailure();
    return fail(failure.code, failure.text);
  } catch (...) {
    constexpr std::string_view kText = "juliavdb: out of memory\n";
    [[maybe_unused]] const auto written = write(STDERR_FILENO, kText.data(), kText.size());
    return kInternal;
  }
}

/// Whether the words ask for JSON. It is found out before the command parses them, which may fail.
bool wantsJson(const Arguments& arguments) {
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i] == "--progress=json") return true;
    if (arguments[i] == "--progress" && i + 1 < arguments.size() && arguments[i + 1] == "json") return true;
  }
  return false;
}

/// Adds to the summary what the device did.
void countDeviceUse() {
  const auto device = julia::currentDevice();
  if (!device) return;
  const julia::DeviceUse use = device->use();
  report().count("deviceCalls", use.calls);
  report().count("deviceKernels", use.kernels);
  report().count("devicePoints", use.points);
  report().count("deviceEdges", use.edges);
  report().count("deviceRays", use.rays);
  report().count("deviceMostPoints", use.mostPoints);
  report().count("deviceMostEdges", use.mostEdges);
  report().count("deviceMostRays", use.mostRays);
  report().count("deviceBytesOfFields", use.bytesOfFields);
  report().count("deviceBytesTo", use.bytesTo);
  report().count("deviceBytesFrom", use.bytesFrom);
  report().count("deviceWaited", use.waited);
}

/// Data on the standard output is an output like any other, so it must have been written.
int finish(int code) {
  std::cout.flush();
  if (code == kDone && !std::cout) return fail(kInputOutput, "writing to the standard output failed");
  takeLastWord(code);
  countDeviceUse();
  report().end(code, "");
  return code;
}

}  // namespace

std::span<const Command> commands() { return kCommands; }

}  // namespace cli

int main(int argc, char** argv) {
  using namespace cli;
  try {
    watchForInterruption();
    const Arguments arguments(argv + 1, argv + argc);
    report().start(arguments.empty() ? "" : arguments.front(), wantsJson(arguments));
    return finish(run(arguments));
  } catch (...) {
    return failNow();
  }
}
