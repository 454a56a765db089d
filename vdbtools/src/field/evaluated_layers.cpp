// SPDX-License-Identifier: Apache-2.0
#include "field/evaluated_layers.h"

#include <iterator>
#include <system_error>
#include <utility>

namespace vdbtools {

std::vector<EvaluatedLayers::Layer> EvaluatedLayers::next() {
  const std::size_t blocks = mEvaluator.preferredBlocks();
  std::vector<Layer> layers = mNext.valid() ? mNext.get() : evaluate(nextBatch(blocks));
  mMonitor.throwIfCancelled();
  if (blocks > 0 && !layers.empty()) beginNext(blocks);
  return layers;
}

/// The next layers until there are so many blocks; one layer at least.
EvaluatedLayers::Batch EvaluatedLayers::nextBatch(std::size_t blocks) {
  Batch batch;
  do {
    const auto layer = mLayers.next();
    if (!layer) break;
    batch.origins.insert(batch.origins.end(), layer->begin(), layer->end());
    batch.ends.push_back(batch.origins.size());
  } while (batch.origins.size() < blocks);
  return batch;
}

std::vector<EvaluatedLayers::Layer> EvaluatedLayers::evaluate(const Batch& batch) {
  std::vector<Layer> layers;
  if (batch.ends.empty()) return layers;
  Layer all = mEvaluator.evaluate(batch.origins, mMonitor);
  if (batch.ends.size() == 1) {
    layers.push_back(std::move(all));
    return layers;
  }
  auto first = all.begin();
  for (const std::size_t end : batch.ends) {
    const auto last = all.begin() + static_cast<std::ptrdiff_t>(end);
    layers.emplace_back(std::move_iterator(first), std::move_iterator(last));
    first = last;
  }
  return layers;
}

/// Begins to evaluate the next layers in a thread of its own.
void EvaluatedLayers::beginNext(std::size_t blocks) {
  Batch batch = nextBatch(blocks);
  if (batch.ends.empty()) return;
  auto work = [this, batch = std::move(batch)] { return evaluate(batch); };
  try {
    mNext = std::async(std::launch::async, work);
  } catch (const std::system_error&) {
    // There is no other thread to be had, so they are evaluated when they are wanted.
    mNext = std::async(std::launch::deferred, work);
  }
}

}  // namespace vdbtools
