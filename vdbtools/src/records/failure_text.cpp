// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/records/failure_text.h"

namespace vdbtools {
namespace {

std::string optionFor(Remedy remedy) {
  switch (remedy) {
    case Remedy::None: break;
    case Remedy::RepairMesh: return "; see --repair";
    case Remedy::SolidifySheet: return "; see --solidify for terrain, and --thicken for a sheet";
    case Remedy::GivePointsRadius: return "; see --points-radius";
    case Remedy::FinerDistances: return "; see --sdf-resolution";
    case Remedy::GiveIsovalue: return "; see --iso";
    case Remedy::TurnSign: return "; see --invert";
    case Remedy::SmallerIslands: return "; see --min-size";
    case Remedy::KeepCrumbs: return "; see --crumbs";
    case Remedy::LargerBeta: return "; see --detail, --outward and --beta";
    case Remedy::AnotherFieldBox: return "; see --box, and 'juliavdb info' for the target's";
  }
  return "";
}

std::string optionFor(MemoryUse use) {
  switch (use) {
    case MemoryUse::Distances: return "use a lower --resolution or --sdf-resolution, or a narrower band";
    case MemoryUse::Field:
      return "use a lower --resolution or a --box, or cut the work into tiles ('juliavdb plan tiles')";
    case MemoryUse::Picture: return "use a smaller --size";
    case MemoryUse::Texture: return "scale the picture down";
    case MemoryUse::File: return "give a smaller file";
    case MemoryUse::Libraries: return "raise that limit";
  }
  return "";
}

}  // namespace

std::string failureText(const DataError& error) { return error.what() + optionFor(error.remedy()); }

std::string failureText(const MemoryError& error) { return std::string(error.what()) + "; " + optionFor(error.use()); }

}  // namespace vdbtools
