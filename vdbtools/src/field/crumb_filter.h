// SPDX-License-Identifier: Apache-2.0
/// @file crumb_filter.h
/// Drops the crumbs of a field (vdbtools/field/crumbs.h) while its blocks arrive in the order of x, or from the whole
/// field.
#pragma once

#include "field/leaf_signs.h"

#include "vdbtools/base/monitor.h"
#include "vdbtools/field/fractal_field.h"

#include <atomic>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <vector>

namespace vdbtools {

/// The nodes of a crumb get -F: they are outside. Active states stay unchanged.
class CrumbFilter {
 public:
  using Leaf = LeafSigns::Leaf;

  /// Leaves of one x, ordered by y, then z.
  struct Layer {
    std::vector<Leaf*> leaves;
    std::shared_ptr<void> owner;  ///< keeps the leaves alive until the layer is returned
  };

  /// @param plan  has a rule for crumbs; it and the source must outlive the filter
  CrumbFilter(const FieldPlan& plan, const FieldSource& source, const Monitor& monitor);
  ~CrumbFilter();

  /// Adds the next layer; layers come in the order of x, and those without leaves are left out.
  /// @return the previous layer, without its crumbs
  std::optional<Layer> add(Layer layer);
  /// @return the last layer; no other layer may be added afterwards
  std::optional<Layer> finish();

  CrumbReport report() const { return {mCrumbs, mNodes}; }

 private:
  struct Signs;
  class Neighbourhood;
  class Flood;

  std::optional<Layer> clean(std::size_t which);
  void clean(const Neighbourhood& around, Leaf& leaf);
  bool holdsDecided(const std::vector<openvdb::Coord>& nodes) const;

  const FieldPlan& mPlan;
  FieldSource mSource;
  const Monitor& mMonitor;
  openvdb::CoordBBox mCounted;
  std::deque<std::unique_ptr<Signs>> mLayers;  ///< at most three; their signs are those before anything was dropped
  std::atomic<std::uint64_t> mCrumbs{0}, mNodes{0};
};

/// Drops the crumbs of a whole field, if the plan has a rule for them.
void dropCrumbs(FractalField& field, const FieldPlan& plan, const FieldSource& source, const Monitor& monitor);

}  // namespace vdbtools
