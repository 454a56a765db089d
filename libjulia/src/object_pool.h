// SPDX-License-Identifier: Apache-2.0
/// @file object_pool.h
/// Objects that one thread at a time uses and that are kept between uses: working memory, and parsers with state.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace julia {

/// Holds as many objects as were ever borrowed at once. Code that borrows again before returning the first object, such
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

  /// Lends an object in the state in which it was returned. It goes back when the loan ends, which must be before the
  /// pool is destroyed.
  Loan borrow() {
    {
      const std::lock_guard lock(mMutex);
      if (!mIdle.empty()) {
        std::unique_ptr<T> object = std::move(mIdle.back());
        mIdle.pop_back();
        return Loan(object.release(), {this});
      }
      // Reserves room for the new object, so that its return cannot fail.
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
