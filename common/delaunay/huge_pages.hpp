// A std::vector for large arrays that are read at random: 64-byte aligned, and on Linux in transparent huge
// pages, which removes most TLB misses of a walk through hundreds of megabytes (measured in DECISION.md).
#pragma once

#include <cstddef>
#include <new>
#include <vector>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace fracture {

template <class T>
struct HugePageAllocator {
  using value_type = T;
  static constexpr std::size_t kHugePage = std::size_t{1} << 21;

  HugePageAllocator() = default;
  template <class U>
  HugePageAllocator(const HugePageAllocator<U>&) {}  // NOLINT: converting by contract of allocators

  static std::size_t alignment(std::size_t count) {
    return count * sizeof(T) >= 2 * kHugePage ? kHugePage : std::size_t{64};
  }
  T* allocate(std::size_t count) {
    void* p = ::operator new (count * sizeof(T), std::align_val_t{alignment(count)});
#ifdef __linux__
    if (alignment(count) == kHugePage) ::madvise(p, count * sizeof(T), MADV_HUGEPAGE);
#endif
    return static_cast<T*>(p);
  }
  void deallocate(T* p, std::size_t count) { ::operator delete (p, std::align_val_t{alignment(count)}); }
  friend bool operator==(const HugePageAllocator&, const HugePageAllocator&) { return true; }
};

template <class T>
using HugePageVector = std::vector<T, HugePageAllocator<T>>;

}  // namespace fracture
