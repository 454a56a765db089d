// SPDX-License-Identifier: Apache-2.0
/// @file object_pool.h
/// Objects for use by one thread at a time, kept between uses: working memory, and parsers that have state.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace julia {

/// Holds as many objects as were ever borrowed at once. Whoever borrows again before returning the first object, such
/// as a map that evaluates other points with its own evaluator, gets a second one.
template <class T>
class ObjectPool {
  struct GiveBack {
    ObjectPool* pool;
    void operator()(T* object) const { pool->put(std::unique_ptr<T>(object)); }
  };

 public:
  using Make = std::function<std::unique_ptr<T>()>;
  using Loan = std::unique_ptr<T, GiveBack>;

  explicit ObjectPool(Make make) : mMake(std::move(make)) {}

  /// An object in the state in which it was returned. It goes back when the loan ends, which is before the pool does.
  Loan borrow() {
    {
      const std::lock_guard lock(mMutex);
      if (!mIdle.empty()) {
        std::unique_ptr<T> object = std::move(mIdle.back());
        mIdle.pop_back();
        return Loan(object.release(), {this});
      }
      // Room for the new object, so that nothing fails on its way back.
      mIdle.reserve(++mCount);
    }
    return Loan(mMake().release(), {this});
  }

 private:
  void put(std::unique_ptr<T> object) {
    const std::lock_guard lock(mMutex);
    mIdle.push_back(std::move(object));
  }

  Make mMake;
  std::mutex mMutex;
  std::size_t mCount = 0;
  std::vector<std::unique_ptr<T>> mIdle;
};

}  // namespace julia
