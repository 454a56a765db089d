// SPDX-License-Identifier: Apache-2.0
/// @file in_pieces.h
/// Calls of a device in pieces that its memory holds.
#pragma once

#include "device/opencl_device.h"

#include <algorithm>
#include <cstddef>

namespace julia::device {

/// The number of points, edges, blocks or rays for which memory is allocated if it has to hold @a count.
inline std::size_t roomFor(std::size_t count) {
  std::size_t capacity = 64;
  while (capacity < count) capacity *= 2;
  return capacity;
}

/// Calls @a piece(first, count) for one part after another, each as large as a device gets at a time. Parts for which
/// it has no memory are halved. @param loan  the memory of the host for it
template <class Loan, class Function>
void inPieces(std::size_t size, std::size_t most, Loan& loan, const Function& piece) {
  // A device that has no memory for so few has none at all.
  constexpr std::size_t kFewest = 64;
  try {
    for (std::size_t first = 0; first < size;) {
      const std::size_t count = std::min(most, size - first);
      try {
        piece(first, count);
        first += count;
      } catch (const DeviceIsFull&) {
        if (count <= kFewest || !loan->lane.settle()) throw;
        most = count / 2;
      }
    }
  } catch (...) {
    if (!loan->lane.settle()) keepUntilExit(loan.release());
    throw;
  }
}

}  // namespace julia::device
