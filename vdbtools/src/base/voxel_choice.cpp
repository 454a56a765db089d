// SPDX-License-Identifier: Apache-2.0
#include "vdbtools/base/voxel_choice.h"

#include "vdbtools/base/errors.h"

#include <cmath>
#include <sstream>
#include <stdexcept>

namespace vdbtools {

double VoxelChoice::sizeFor(double longestSide) const {
  // Within this range, distances of any number of voxels, and of a fraction of one, are normal 32-bit floats.
  constexpr double kSmallest = 1e-12, kLargest = 1e30;
  // If none of these resolutions suits a shape, the shape is at fault.
  constexpr double kOrdinaryLow = 1, kOrdinaryHigh = 1000;
  const double size = voxelSize ? *voxelSize : longestSide / resolution.value();
  if (size >= kSmallest && size <= kLargest) return size;
  std::ostringstream text;
  text << "the voxel size would be " << size << "; it must be 1e-12 to 1e30: ";
  if (!voxelSize && *resolution >= kOrdinaryLow && *resolution <= kOrdinaryHigh) {
    text << "the longest side is " << longestSide << "; give the shape in other units";
    throw DataError(text.str());
  }
  text << "choose another resolution or voxel size, or give the shape in other units";
  throw std::invalid_argument(text.str());
}

double upToTens(double number) {
  constexpr double kTens = 10, kRounding = 1e-9;
  return kTens * std::ceil(number / kTens * (1 - kRounding));
}

}  // namespace vdbtools
