// SPDX-License-Identifier: Apache-2.0
// The search for a change of sign on an edge (julia/edge_search.h) as text of C++ and OpenCL C (kernels/language.h). It
// is in doubles for F in floats, too. edge_search.cpp includes it.

/// F guides the search but is unreliable: it spans many orders of magnitude and jumps where an orbit escapes one step
/// earlier. Far from 0, little more than its sign matters.
JULIA_SHARED_IN_DOUBLES double damped(double field) { return field / (1 + (field < 0 ? -field : field)); }

/// Where to evaluate next: the step of the ITP method (Oliveira and Takahashi, ACM TOMS 47(1), 2020), which
/// interpolates but never lets the bracket become wider than @a most.
JULIA_SHARED_IN_DOUBLES double nextPoint(double low, double high, double atLow, double atHigh, double most) {
  const double size = high - low, middle = low + size / 2;
  const double interpolated = (high * atLow - low * atHigh) / (atLow - atHigh);
  // Shifted slightly towards the middle, so that the sign change is likely to be on the short side.
  const double towards = middle >= interpolated ? 1 : -1;
  const double truncation = 0.1 * size * size;
  const double off = middle >= interpolated ? middle - interpolated : interpolated - middle;
  const double truncated = truncation <= off ? interpolated + towards * truncation : middle;
  const double spare = most - size / 2, reach = spare > 0 ? spare : 0;
  const double away = truncated >= middle ? truncated - middle : middle - truncated;
  return away <= reach ? truncated : middle - towards * reach;
}
