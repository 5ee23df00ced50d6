// SPDX-License-Identifier: Apache-2.0
#include "counted_new.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

// On its own, so that no caller sees through new to malloc (g++ 12 warns of a mismatch there). All
// forms, also the one that std::stable_sort uses: memory of one must not be freed by another's.
namespace {
std::atomic<long> count{0};
}  // namespace

long egomod::allocations() { return count; }

void* operator new(std::size_t size) {
  ++count;
  if (void* p = std::malloc(size)) return p;
  throw std::bad_alloc();
}
void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  ++count;
  return std::malloc(size);
}
void operator delete(void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete(void* p, const std::nothrow_t&) noexcept { std::free(p); }
