// SPDX-License-Identifier: Apache-2.0
#include "exponent/exponent_law.h"
#include "vdbtools/base/text.h"

#include "base/elementary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

namespace vdbtools {
namespace {

// The minimum width of the shell of detail, in voxels of the target's distances: a thinner shell would fall between
// their nodes.
constexpr double kLeastShell = 0.25;
// This fraction of the shell is left free at both ends, so that what is guaranteed for phi also holds between the nodes
// of E.
constexpr double kEndOfShell = 0.02;

// Interpolation may take a control out of its range by a rounding error.
constexpr double kRounding = 1e-5;

double clamped(double share) { return std::clamp(share, 0.0, 1.0); }

/// The range of a control that must be within 0 to 1. @throw std::invalid_argument  it is not
std::pair<double, double> shareRange(const Control& control, const std::string& name) {
  const auto [least, most] = control.range();
  if (least < -kRounding || most > 1 + kRounding)
    throw std::invalid_argument(name + " is " + shortText(least < 0 ? least : most) +
                                " somewhere; it must be from 0 to 1 everywhere");
  return {clamped(least), clamped(most)};
}

/// w where phi is 0, with the opposite sign.
double outsideShare(double inward, double outward) {
  const double sum = inward + outward;
  // If both reaches are 0, the remaining shell lies on both sides.
  return sum > 0 ? (outward / sum - kEndOfShell) / (1 - 2 * kEndOfShell) : 0.5;
}

}  // namespace

double ExponentLaw::shellHeight(double mask, double sum, double tau) const {
  return std::max(mask * sum * (1 - 2 * kEndOfShell) * tau, mLeastShell);
}

ExponentLaw::ExponentLaw(const ExponentGridOptions& options, double scale, double voxel)
    : mOptions(options), mScale(scale), mLeastShell(kLeastShell * voxel) {
  const double mask = shareRange(options.mask, "the mask").second;
  if (const std::optional<DetailOptions>& detail = options.detail) {
    const double tau = detail->greatestThickness * mask;
    mMostInward = std::max(tau * shareRange(detail->detail, "the detail").second, mLeastShell);
    mMostShell = mMostInward + std::max(tau * shareRange(detail->outward, "the outward reach").second, mLeastShell);
    return;
  }
  exteriorReach(options);  // for its checks
  if (options.mask.constant() != 1.0) return;
  mAlpha = options.alpha.constant();
  mBeta = options.beta.constant();
}

void ExponentLaw::apply(std::span<const openvdb::Vec3d> points, std::span<float> values) const {
  const std::size_t n = points.size();
  const std::optional<DetailOptions>& detail = mOptions.detail;
  std::vector<double> mask(n), first(n), second(n);
  mOptions.mask.sample(points, mask);
  (detail ? detail->detail : mOptions.alpha).sample(points, first);
  (detail ? detail->outward : mOptions.beta).sample(points, second);
  for (double& m : mask) m = clamped(m);
  if (!detail) {
    for (std::size_t i = 0; i < n; ++i) {
      // With a mask of 0 the shell is as thin as its distances can resolve.
      const double m = std::max(mask[i], std::min(1.0, mLeastShell / mScale * first[i]));
      values[i] = static_cast<float>(first[i] / m * (values[i] / mScale - second[i] * mask[i]));
    }
    return;
  }
  std::vector<double> tau(n);
  detail->thickness.sample(points, tau);
  for (std::size_t i = 0; i < n; ++i) {
    const double inward = clamped(first[i]), outward = clamped(second[i]);
    values[i] =
        static_cast<float>(values[i] / shellHeight(mask[i], inward + outward, tau[i]) - outsideShare(inward, outward));
  }
}

double ExponentLaw::greatestInside(double phi) const {
  if (mOptions.detail) {
    // w = -1 - (|phi| - m D tau) / h
    const double beyond = -phi - mMostInward;
    return beyond >= 0 ? -1 - beyond / mMostShell : -1 - beyond / mLeastShell;
  }
  const auto [leastMask, mostMask] = shareRange(mOptions.mask, "the mask");
  const double beta = mOptions.beta.range().first, moved = phi / mScale - std::min(beta * leastMask, beta * mostMask);
  const auto [least, most] = mOptions.alpha.range();
  // The mask increases alpha, up to its value where the shell is thinnest.
  const double steepest = leastMask == 1 ? most : std::max(most, mScale / mLeastShell);
  return moved < 0 ? least * moved : steepest * moved;
}

std::pair<std::pair<double, double>, std::pair<double, double>> ExponentLaw::ranges(std::optional<double> scale) const {
  if (!scale) return {mOptions.alpha.range(), mOptions.beta.range()};
  // v = (scale / h) (phi - (outside - ln(escape) / scale) h)
  const DetailOptions& detail = *mOptions.detail;
  const auto [leastD, mostD] = shareRange(detail.detail, "the detail");
  const auto [leastO, mostO] = shareRange(detail.outward, "the outward reach");
  const auto [leastMask, mostMask] = shareRange(mOptions.mask, "the mask");
  const auto [leastTau, mostTau] = detail.thickness.range();
  const double heights[] = {shellHeight(leastMask, leastD + leastO, leastTau),
                            shellHeight(mostMask, mostD + mostO, mostTau)};
  const double outsides[] = {outsideShare(mostD, leastO), outsideShare(leastD, mostO)};
  std::pair<double, double> beta{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};
  for (const double h : heights)
    for (const double outside : outsides) {
      const double here = (outside - elementary::log(mOptions.orbit.escapeRadius) / *scale) * h / mScale;
      beta = {std::min(beta.first, here), std::max(beta.second, here)};
    }
  return {{*scale * mScale / heights[1], *scale * mScale / heights[0]}, beta};
}

}  // namespace vdbtools
