// SPDX-License-Identifier: Apache-2.0
// Writes the exported page of a fractal: write_look OUT.html [LOOK.json] NAME=VALUE ... with the options of `juliavdb
// fractal`. For the tests of the page, which need no server.
#include "explore/export_page.h"
#include "vdbtools/job/fractal_options.h"

#include <fstream>
#include <iostream>

int main(int count, char** arguments) {
  try {
    vdbtools::Recipe recipe;
    nlohmann::json look;
    for (int i = 2; i < count; ++i) {
      const std::string text = arguments[i];
      const std::size_t at = text.find('=');
      if (at == std::string::npos)
        look = nlohmann::json::parse(std::ifstream(text));
      else
        recipe[text.substr(0, at)] = text.substr(at + 1);
    }
    vdbtools::Monitor monitor;
    const vdbtools::Scene scene = vdbtools::makeScene(vdbtools::parseFractalOptions(recipe), monitor);
    std::ofstream(arguments[1]) << vdbtools::exportPage(scene, recipe, look, monitor);
  } catch (const std::exception& error) {
    std::cerr << error.what() << '\n';
    return 1;
  }
}
