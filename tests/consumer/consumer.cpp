// SPDX-License-Identifier: Apache-2.0
#include <julia/random_roots.h>
#include <vdbtools/mesh_files/mesh_writer.h>

#include <sstream>

int main() {
  const vdbtools::Mesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}}, {}};
  std::ostringstream stream;
  vdbtools::writeMesh(stream, mesh, {});
  return stream.str().empty() || julia::randomPolynomial({.count = 3}).roots.size() != 3;
}
