// SPDX-License-Identifier: Apache-2.0
/// @file fractal_share.h
/// How much of a job of the page is done, for the server of 'juliavdb explore' and for the page without one (wasm/).
#pragma once

#include "overall_share.h"

#include "vdbtools/explore/explore_server.h"

namespace cli {

/// Estimates the progress of a job by the weights of 'juliavdb fractal'.
class FractalShare final : public vdbtools::explore::WorkShare {
 public:
  FractalShare() { mShare.begin(vdbtools::PhaseKind::Reading); }
  void begin(const vdbtools::Phase& phase) override { mShare.begin(phase); }
  double at(double fraction) override { return mShare.at(fraction); }

 private:
  OverallShare mShare{phasesOf("fractal")};
};

}  // namespace cli
