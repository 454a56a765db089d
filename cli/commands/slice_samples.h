// SPDX-License-Identifier: Apache-2.0
/// @file slice_samples.h
/// The fields of 'juliavdb slice' at the pixels of a plane, row by row, in threads.
#pragma once

#include "vdbtools/base/monitor.h"
#include "vdbtools/picture/slice_image.h"
#include "vdbtools/scene/scene.h"

#include <cstddef>
#include <memory>
#include <vector>

namespace cli {

enum class SliceField { Phi, Exponent, Field, Membership, Iterations, Versor, Grid };

/// Whether the numbers of a field have a sign, and therefore a range to show.
constexpr bool isSigned(SliceField field) {
  return field != SliceField::Membership && field != SliceField::Iterations && field != SliceField::Versor;
}

// All throw vdbtools::Interrupted.

std::vector<float> sampleGrid(const vdbtools::SlicePlane& plane, const openvdb::FloatGrid& grid,
                              vdbtools::Monitor& progress);

struct FieldSamples {
  std::vector<float> field;
  std::vector<int> iterations;
};
FieldSamples sampleField(const vdbtools::SlicePlane& plane, const vdbtools::Scene& scene, vdbtools::Monitor& progress);

/// The evaluator of the orbit's first step alone.
std::unique_ptr<julia::FieldEvaluator> firstStep(const vdbtools::Scene& scene);

/// ln |f| of the first step.
std::vector<float> sampleFirstStep(const vdbtools::SlicePlane& plane, const vdbtools::Scene& scene,
                                   vdbtools::Monitor& progress);

std::vector<openvdb::Vec3s> sampleVersor(const vdbtools::SlicePlane& plane, const vdbtools::Scene& scene,
                                         vdbtools::Monitor& progress);

}  // namespace cli
