// SPDX-License-Identifier: Apache-2.0
#include "moving_objects/grouping.hpp"

#include <numeric>

namespace egomod {

void Grouper::reserve(std::size_t points) {
  order_.reserve(points);
  parent_.reserve(points);
  ends_.reserve(points);
}

std::span<const Grouper::Index> Grouper::operator[](std::size_t group) const {
  const std::size_t begin = group == 0 ? 0 : ends_[group - 1];
  return std::span<const Index>(order_).subspan(begin, ends_[group] - begin);
}

void Grouper::start(std::size_t count) {
  order_.resize(count);
  parent_.resize(count);
  ends_.clear();
  std::iota(order_.begin(), order_.end(), Index{0});
  std::iota(parent_.begin(), parent_.end(), Index{0});
}

Grouper::Index Grouper::root(Index point) {
  while (parent_[point] != point) point = parent_[point] = parent_[parent_[point]];
  return point;
}

void Grouper::unite(Index a, Index b) {
  const Index ra = root(a);
  const Index rb = root(b);
  parent_[std::max(ra, rb)] = std::min(ra, rb);
}

void Grouper::collect() {
  for (Index& parent : parent_) parent = root(parent);
  std::sort(order_.begin(), order_.end(), [this](Index a, Index b) {
    return parent_[a] != parent_[b] ? parent_[a] < parent_[b] : a < b;
  });
  for (std::size_t i = 1; i <= order_.size(); ++i) {
    if (i == order_.size() || parent_[order_[i]] != parent_[order_[i - 1]]) ends_.push_back(i);
  }
}

}  // namespace egomod
