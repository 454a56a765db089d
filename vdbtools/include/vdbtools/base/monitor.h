// SPDX-License-Identifier: Apache-2.0
/// @file monitor.h
/// How long work reports its progress and learns that it is cancelled.
#pragma once

#include "vdbtools/base/errors.h"

#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>

namespace vdbtools {

// The phases that long work goes through. A Monitor shows them, and a command weighs them to know how much is done.

enum class PhaseKind {
  Reading,
  Thickening,
  ClosingGaps,
  Sides,
  DistanceField,
  LocalThickness,
  Grain,
  Motion,
  WideningTheBand,
  Exponent,
  Proofs,
  Field,
  Seeds,
  FollowingTheSurface,
  Islands,
  JoiningIslands,
  Surface,
  Adapting,
  LevelSet,
  Versor,
  Attributes,
  Writing,
  Checking,
  Points,
  Gaps,
  Elimination,
  Thickness,
  ThinParts,
  Sample,
  Merging,
  MergingGrids,
  Signs,
  Slice,
  Distances,
  FirstVersor,
  Versors,
  RayTree,
  Render,
  Electrostatics,
  Monopoles,
  Potential,
  Fit,
  Measure,
  Evaluating,
};

/// "closing gaps" for PhaseKind::ClosingGaps.
const char* nameOf(PhaseKind kind);

/// A phase, as a part of all work or of one of several pieces of it.
struct Phase {
  // NOLINTNEXTLINE(google-explicit-constructor): a phase is most often its kind alone.
  Phase(PhaseKind k, std::string d = {}) : kind(k), detail(std::move(d)) {}

  PhaseKind kind;
  std::string detail;                 ///< follows the name, such as "of 0.01"
  std::string piece{};                ///< what the pieces are called, such as "frame"
  std::size_t number = 0, count = 0;  ///< of the piece, from 1; 0 where there are no pieces

  /// "closing gaps of 0.01, frame 3 of 24"
  std::string text() const;
};

// The interface between long work and the code that watches it: work reports progress and asks whether it is
// cancelled.

/// Watches a piece of work. The default one shows nothing and never cancels.
/// advance() and cancelled() are called from many threads at once.
class Monitor {
 public:
  virtual ~Monitor() = default;

  /// A phase of @a total steps begins; 0 means that the number of steps is not known.
  virtual void begin(const Phase& phase, std::uint64_t total) {
    (void)phase;
    (void)total;
  }

  /// @a steps more of the current phase are done.
  virtual void advance(std::uint64_t steps) { (void)steps; }

  /// Whether the work is to stop.
  virtual bool cancelled() const { return false; }

  /// @throw Interrupted  the work is to stop
  void throwIfCancelled() const {
    if (cancelled()) throw Interrupted("interrupted; nothing was written");
  }
};

/// A Monitor with the interface that OpenVDB's tools expect (util::NullInterrupter).
class OpenVdbInterrupter {
 public:
  explicit OpenVdbInterrupter(const Monitor& monitor) : mMonitor(monitor) {}
  void start(const char* = nullptr) {}
  void end() {}
  bool wasInterrupted(int = -1) const { return mMonitor.cancelled(); }

 private:
  const Monitor& mMonitor;
};

// The phases of one of several pieces of work: "render, frame 3 of 24".

class NumberedMonitor final : public Monitor {
 public:
  /// @param monitor  must outlive this
  /// @param piece    what is counted, such as "frame"
  /// @param number   of this piece, from 1 to @a count
  NumberedMonitor(Monitor& monitor, std::string piece, std::size_t number, std::size_t count)
      : mMonitor(monitor), mPiece(std::move(piece)), mNumber(number), mCount(count) {}

  void begin(const Phase& phase, std::uint64_t total) override {
    Phase numbered = phase;
    numbered.piece = mPiece;
    numbered.number = mNumber;
    numbered.count = mCount;
    mMonitor.begin(numbered, total);
  }
  void advance(std::uint64_t steps) override { mMonitor.advance(steps); }
  bool cancelled() const override { return mMonitor.cancelled(); }

 private:
  Monitor& mMonitor;
  std::string mPiece;
  std::size_t mNumber, mCount;
};

}  // namespace vdbtools
