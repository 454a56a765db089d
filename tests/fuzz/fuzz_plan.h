// SPDX-License-Identifier: Apache-2.0
/// @file fuzz_plan.h
/// The plan whose side-cars are fuzzed.
#pragma once

#include "vdbtools/farm/manifest.h"
#include "vdbtools/files/named_file.h"

namespace fuzz {

/// Its first task writes one file, of the bytes "abc".
inline vdbtools::farm::Manifest plan() {
  vdbtools::farm::Manifest manifest;
  manifest.kind = vdbtools::farm::PlanKind::Frames;
  manifest.recipe = {{"map", "quadratic"}, {"resolution", "16"}};
  manifest.makes = {"vdb"};
  manifest.metadata = {{"folder", "/"}};
  manifest.inputs = {{"shape.obj", vdbtools::sha256Hex("shape")}};
  manifest.tasks = {{.recipe = {{"c", "0,1,0,0"}}, .box = {}, .writes = {"out.0001.vdb"}},
                    {.recipe = {{"c", "0,0,1,0"}}, .box = {}, .writes = {"out.0002.vdb"}}};
  manifest.version = JULIAVDB_VERSION;
  return manifest;
}

}  // namespace fuzz
