// SPDX-License-Identifier: Apache-2.0
// Private to the modules of networks.
#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace knuckle {

/// Memory that begins with a line of the cache: a register of AVX-512 read from within two lines takes twice
/// as long.
template <class T>
struct LineAllocator {
  using value_type = T;
  static constexpr std::align_val_t kLine{64};

  LineAllocator() = default;
  template <class Other>
  LineAllocator(const LineAllocator<Other>&) {}

  T* allocate(std::size_t count) { return static_cast<T*>(::operator new(count * sizeof(T), kLine)); }
  void deallocate(T* memory, std::size_t) { ::operator delete(memory, kLine); }
  bool operator==(const LineAllocator&) const = default;
};

/// Numbers for loops over FloatLanes.
using AlignedVector = std::vector<float, LineAllocator<float>>;

}  // namespace knuckle
