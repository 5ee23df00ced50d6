// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace egomod {

// Connected components under a link test, found with a sweep along one coordinate. Its buffers are
// reused: nothing is allocated once the largest input was seen.
class Grouper {
 public:
  using Index = std::uint32_t;

  void reserve(std::size_t points);

  // Points are 0..count-1. `key(i)` is the swept coordinate: points further apart than `reach`
  // there are never linked; `linked(i, j)` must be symmetric. The result does not depend on the
  // order.
  template <class Key, class Linked>
  void group(std::size_t count, double reach, const Key& key, const Linked& linked) {
    start(count);
    std::sort(order_.begin(), order_.end(),
              [&](Index a, Index b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
    for (std::size_t i = 0; i < count; ++i) {
      for (std::size_t j = i + 1; j < count && key(order_[j]) - key(order_[i]) <= reach; ++j) {
        if (root(order_[i]) != root(order_[j]) && linked(order_[i], order_[j])) {
          unite(order_[i], order_[j]);
        }
      }
    }
    collect();
  }

  // Groups in order of their first point, points ascending.
  [[nodiscard]] std::size_t size() const { return ends_.size(); }
  [[nodiscard]] std::span<const Index> operator[](std::size_t group) const;

 private:
  void start(std::size_t count);
  [[nodiscard]] Index root(Index point);
  void unite(Index a, Index b);
  void collect();

  std::vector<Index> order_;
  std::vector<Index> parent_;  // the root of a group is its first point
  std::vector<std::size_t> ends_;
};

}  // namespace egomod
